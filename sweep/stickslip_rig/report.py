"""The report of a test matrix: one self-contained HTML file, without network or scripts.

The frame and its parts are those of `stickslip.pages`, which escape everything that users wrote.
"""

from collections.abc import Iterator, Mapping
from itertools import islice
from textwrap import fill

import numpy as np
import xarray as xr

from stickslip import pages
from stickslip.config.model import Config
from stickslip.pages import Cell, Column, Section
from stickslip.vocabulary.display_units import quantity
from stickslip.vocabulary.models import laws_with
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip_rig.evaluation import SHOWN, as_records, rated, shown_text, unfinished
from stickslip_rig.labels import Dimension, dimensions
from stickslip_rig.plots import LIGHTS, MEANINGS, plot_matrix, plot_records
from stickslip_rig.quantities import FEATURES
from stickslip_rig.risk import BANDS, RPN_NAME, rpn_text

MOST_ROWS = 500  # of the table
_MOST_TOGETHER = 6  # records drawn over each other, as many as there are colours
_WIDEST_ENTRY = 22  # letters, of a legend
_MOST_NAMED = 20  # tests that a warning names
_LIGHTS_IN_PRINT = """\
.green, .yellow, .red, .unknown { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
td.green, td.yellow, td.red, td.unknown { text-align: center; font-weight: 600; }
"""
_RPN_IN_WORDS = (
    f"RPN is the {RPN_NAME}: a number from 1 to 10 made of the number of sticks, the largest acceleration and the "
    "integral of the acceleration over the test. It has the inputs, the scale and the bands of the rig makers' risk "
    "priority number, whose formula is not public, and ranks tests on one rig. Sticks and integral grow with the "
    "length of a test, so compare tests of the same strokes and speeds."
)
_SENSORS_IN_WORDS = (
    "The tests were simulated, sensors and their noise included. Friction coefficients are read from the force of the "
    "spring as the rig would measure them, over the load. A dash marks a number that is not defined."
)


def report(ds: xr.Dataset, records: Mapping[str, xr.Dataset], rig: Config) -> str:
    """The page of a test matrix (`run_matrix`) as text.

    records : those to draw, by name; names that `RigTests.title` gives get their model RPN in the legend. rig : the
    configuration the matrix was computed from.
    """
    dims, title = dimensions(ds, ds["model_rpn"].dims), str(ds.attrs.get("title", "")) or rig.title
    legend = pages.legend(
        f"RPN: {RPN_NAME}.", [(f"{low}–{high}: {MEANINGS[band]}", band) for band, (low, high) in BANDS.items()]
    )
    again = pages.paragraph("The full configuration; saved as a file, it gives the same matrix again:")
    sections = [
        Section("The matrix", _maps(ds)),
        Section("Traces", _traces(ds, records) or pages.paragraph("No traces were asked for.")),
        Section("All tests", legend + _table(ds, dims)),
        Section("What the numbers mean", "".join((
            pages.paragraph(_RPN_IN_WORDS), pages.terms(_meanings(ds), "short"), pages.paragraph(_SENSORS_IN_WORDS)
        ))),
        Section("Equal in all tests", pages.terms(_constants(ds, rig), "two")),
        Section("Where this comes from", pages.provenance(ds.attrs) + again + pages.configuration(rig.to_yaml())),
    ]  # fmt: skip
    lights = "".join(f".{name} {{ background: {colour}; color: #000; }}\n" for name, colour in LIGHTS.items())
    return pages.page(title, _summary(ds, dims), sections, warnings=_warnings(ds), style=lights + _LIGHTS_IN_PRINT)


# --- words ------------------------------------------------------------------------------------------------------------


def _summary(ds: xr.Dataset, dims: list[Dimension]) -> str:
    """`324 tests: pair (12) × ...` and how many are in which band."""
    sizes = " × ".join(f"{d.name} ({len(d.points)})" for d in dims)
    tests = f"{ds['model_rpn'].size} tests: {sizes}" if dims else "One test"
    bands = ds["model_rpn_band"].values
    shares = [f"{int((bands == code).sum())} {name}" for code, name in enumerate(LIGHTS) if code in bands]
    return f"{tests}. Bands of the {RPN_NAME}: {', '.join(reversed(shares))}."


def _warnings(ds: xr.Dataset) -> list[str]:
    """Tests that were not integrated to their end, by the reason."""
    names, warnings = as_records(ds)["record"].values, []
    for sentence, numbers in unfinished(ds):
        more = f"; and {len(numbers) - _MOST_NAMED} more" if len(numbers) > _MOST_NAMED else ""
        warnings.append(pages.warning(f"{sentence} ({'; '.join(names[numbers[:_MOST_NAMED]])}{more})"))
    return warnings


def _constants(ds: xr.Dataset, rig: Config) -> Iterator[tuple[str, str]]:
    """Quantities that are equal in all tests, and matter: rigs start sticking, and `delta` is for one law only."""
    left_out = {name for name, declared in PARAMETERS.items() if declared.section == "start"}
    left_out |= set() if rig.friction.law in laws_with("delta") else {"delta"}
    for name, c in ds.coords.items():
        if name not in left_out and not c.dims and c.dtype.kind == "f" and np.isfinite(c):
            yield str(c.attrs.get("long_name", name)), quantity(float(c), str(c.attrs.get("units", "1")))


def _meanings(ds: xr.Dataset) -> Iterator[tuple[str, str]]:
    """The columns of the table, in words."""
    for column in SHOWN:
        yield f"{column.heading} {column.below}".rstrip(), FEATURES[column.feature].long_name
    if _is_limited(ds):
        yield "limited", "accelerations are those within the bandwidth that the configuration gives"


def _is_limited(ds: xr.Dataset) -> bool:
    return "acceleration_max_limited" in ds and bool(ds["acceleration_max_limited"].notnull().any())


# --- table and plots --------------------------------------------------------------------------------------------------


def _table(ds: xr.Dataset, dims: list[Dimension]) -> str:
    """All tests, the rows after `MOST_ROWS` left out, which a line below says."""
    size = ds["model_rpn"].size
    columns = [Column("test"), *(Column(d.name, d.unit, d.is_text) for d in dims), Column("RPN")]
    columns += [Column(column.heading, column.below) for column in SHOWN]
    cut = pages.paragraph(f"{size - MOST_ROWS} more tests are left out here; the file of results has all.")
    return pages.table(columns, islice(_rows(ds, dims), MOST_ROWS)) + (cut if size > MOST_ROWS else "")


def _rows(ds: xr.Dataset, dims: list[Dimension]) -> Iterator[list[str | Cell]]:
    """A row for each test."""
    lights, values = list(LIGHTS), [rated(ds, column.feature).ravel() for column in SHOWN]
    rpn, bands = ds["model_rpn"].values.ravel().tolist(), ds["model_rpn_band"].values.ravel().tolist()
    for n, at in enumerate(np.ndindex(*(len(d.points) for d in dims))):
        where = (d.points[i] for d, i in zip(dims, at, strict=True))
        numbers = (shown_text(column, own[n]) for column, own in zip(SHOWN, values, strict=True))
        yield [str(n), *where, Cell(rpn_text(rpn[n]), lights[bands[n]]), *numbers]


def _maps(ds: xr.Dataset) -> str:
    largest = "acceleration_max_limited" if _is_limited(ds) else "acceleration_max"
    return pages.side_by_side(
        pages.embedded(plot_matrix(ds), f"Heat map: {RPN_NAME} of every test"),
        pages.embedded(plot_matrix(ds, largest), f"Heat map: {FEATURES[largest].long_name} of every test"),
    )


def _traces(ds: xr.Dataset, records: Mapping[str, xr.Dataset]) -> str:
    """Records over each other, as many as colours tell apart, and the first stroke in detail."""
    rpn = dict(zip(as_records(ds)["record"].values.tolist(), ds["model_rpn"].values.ravel().tolist(), strict=True))
    names, figures = list(records), []
    for first in range(0, len(names), _MOST_TOGETHER):
        chosen = names[first : first + _MOST_TOGETHER]
        drawn = {_in_legend(name): records[name] for name in chosen}
        numbers = {_in_legend(name): rpn[name] for name in chosen if name in rpn}
        end = min(_first_stroke(record) for record in drawn.values())
        whole = plot_records(drawn, numbers=numbers, heading="Whole tests")
        start = plot_records(drawn, numbers=numbers, heading="The first stroke", window=(0.0, end))
        labels = "; ".join(chosen)
        figures.append(pages.embedded(whole, f"Force and acceleration over time: {labels}"))
        figures.append(pages.embedded(start, f"The first stroke of the same: {labels}"))
    return "\n".join(figures)


def _in_legend(name: str) -> str:
    """A name as matplotlib shows it: `_` in front hides an entry, and four entries stand side by side."""
    return ("\u2009" if name.startswith("_") else "") + fill(name, _WIDEST_ENTRY)


def _first_stroke(record: xr.Dataset) -> float:
    """End of the first stroke, s since the start; a tenth of the record where the drive is not known."""
    time = record["time"].values - record["time"].values[0]
    if "drive_velocity" in record:
        moving = record["drive_velocity"].values > 0
        begin = int(np.argmax(moving))
        rests = np.flatnonzero(~moving[begin:])
        if moving.any() and rests.size:
            return float(time[begin + rests[0]])
    return 0.1 * float(time[-1])
