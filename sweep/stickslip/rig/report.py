"""The report of a test matrix: one self-contained HTML file, without network or scripts.

The frame and its parts are those of `stickslip.pages`, which escape everything that users wrote.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from html import escape
from itertools import islice
from pathlib import Path
from string import Template
from textwrap import fill

import numpy as np
import xarray as xr

from stickslip import pages
from stickslip.pages import Cell, Column, Section
from stickslip.rig.config import RigConfig
from stickslip.rig.labels import Dimension, dimension, number_text, point_name, quantity_text
from stickslip.rig.plots import LIGHTS, MEANINGS, plot_matrix, plot_records
from stickslip.rig.quantities import FEATURES
from stickslip.rig.rpn import BANDS, RPN_NAME, rpn_text
from stickslip.rig.simulation import RigTests
from stickslip.vocabulary.flags import STATUS_MESSAGES, STATUSES
from stickslip.vocabulary.quantities import PARAMETERS

MOST_ROWS = 500  # of the table
_MOST_TOGETHER = 6  # records drawn over each other, as many as there are colours
_WIDEST_ENTRY = 22  # letters, of a legend
_MOST_NAMED = 20  # tests that a warning names
_LIGHTS_IN_PRINT = """\
.green, .yellow, .red, .unknown { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
td.green, td.yellow, td.red, td.unknown { text-align: center; font-weight: 600; }
"""
_WORDS = """\
<p><strong>RPN</strong> is the $rpn_name: a number from 1 to 10 made of the number of sticks, the largest acceleration
and the integral of the acceleration over the test. It has the inputs, the scale and the bands of the rig makers' risk
priority number, whose formula is not public, and ranks tests on one rig. Sticks and integral grow with the length of a
test, so compare tests of the same strokes and speeds.</p>
$meanings
<p>The tests were simulated, sensors and their noise included. Friction coefficients are read from the force of the
spring as the rig would measure them, over the load. A dash marks a number that is not defined.</p>"""
# Of the table: feature, heading, unit, factor from SI.
_COLUMNS = (
    ("sticks", "sticks", "", 1.0),
    ("acceleration_max", "max |a|", "m/s²", 1.0),
    ("acceleration_integral", "∫|a| dt", "m/s", 1.0),
    ("drops", "drops", "", 1.0),
    ("drop_mean", "mean drop", "N", 1.0),
    ("impulse_rate", "slips", "1/mm", 1e-3),
    ("static_friction_first", "static μ, first", "", 1.0),
    ("static_friction", "static μ", "", 1.0),
    ("dynamic_friction", "dynamic μ", "", 1.0),
)


def write_report(
    path: str | os.PathLike[str], ds: xr.Dataset, records: Mapping[str, xr.Dataset], rig: RigConfig
) -> Path:
    """Write the report of a test matrix as one file, replacing `path` only once it is whole.

    Parameters
    ----------
    path
        HTML, or PDF.
    ds
        The matrix (`run_matrix`).
    records
        Those to draw, by name; names that `RigTests.name` gives get their model RPN in the legend.
    rig
        The configuration the matrix was computed from.

    Raises
    ------
    StoreError
        Where the file cannot be written.
    """
    return pages.write_page(path, report(ds, records, rig))


def report(ds: xr.Dataset, records: Mapping[str, xr.Dataset], rig: RigConfig) -> str:
    """The text of the file that `write_report` writes."""
    dims = [dimension(ds, dim) for dim in ds["model_rpn"].dims]
    traces = _traces(records, _known(ds, rig)) or pages.paragraph("No traces were asked for.")
    again = pages.paragraph("The full configuration; saved as a file, it gives the same matrix again:")
    words = Template(_WORDS).substitute(rpn_name=escape(RPN_NAME), meanings=_meanings(ds))
    sections = [
        Section("The matrix", _maps(ds)),
        Section("Traces", traces),
        Section("All tests", f'<p class="legend">RPN: {escape(RPN_NAME)}. {_legend()}</p>\n{_table(ds, dims)}'),
        Section("What the numbers mean", words),
        Section("Equal in all tests", _constants(ds, rig)),
        Section("Where this comes from", pages.provenance(ds.attrs) + again + pages.configuration(rig.to_yaml())),
    ]
    title = str(ds.attrs.get("title", "")) or rig.config.title
    lights = "".join(f".{name} {{ background: {colour}; color: #000; }}\n" for name, colour in LIGHTS.items())
    style = lights + _LIGHTS_IN_PRINT
    return pages.page(title, _summary(ds, dims), sections, warnings=_warnings(ds, dims), style=style)


# --- words ------------------------------------------------------------------------------------------------------------


def _summary(ds: xr.Dataset, dims: list[Dimension]) -> str:
    """`324 tests: pair (12) × ...` and how many are in which band."""
    sizes = " × ".join(f"{d.name} ({len(d.points)})" for d in dims)
    count = ds["model_rpn"].size
    tests = f"{count} tests: {sizes}" if dims else "One test"
    bands = ds["model_rpn_band"].values.ravel()
    shares = [f"{int((bands == code).sum())} {name}" for code, name in enumerate(LIGHTS) if code in bands]
    return f"{tests}. Bands of the {RPN_NAME}: {', '.join(reversed(shares))}."


def _warnings(ds: xr.Dataset, dims: list[Dimension]) -> list[str]:
    """Tests that were not integrated to their end, by the reason."""
    status = ds["status"].values.ravel()
    warnings = []
    for code in np.unique(status[status != STATUSES.index("horizon_reached")]).tolist():
        numbers = np.flatnonzero(status == code).tolist()
        names = "; ".join(point_name(dims, n) or "the only one" for n in numbers[:_MOST_NAMED])
        more = f"; and {len(numbers) - _MOST_NAMED} more" if len(numbers) > _MOST_NAMED else ""
        tests = "1 test was" if len(numbers) == 1 else f"{len(numbers)} tests were"
        message = f"{tests} not integrated to the end: {STATUS_MESSAGES[STATUSES[code]]} ({names}{more})"
        warnings.append(pages.warning(message))
    return warnings


def _legend() -> str:
    """The bands, each on its colour."""
    words = ((band, f"{low}–{high}: {MEANINGS[band]}") for band, (low, high) in BANDS.items())
    return " ".join(f'<span class="{band}">{escape(text)}</span>' for band, text in words)


def _constants(ds: xr.Dataset, rig: RigConfig) -> str:
    """Quantities that are equal in all tests, and matter: rigs start sticking, and `delta` is for one law only."""
    left_out = {name for name, declared in PARAMETERS.items() if declared.section == "start"}
    left_out |= set() if rig.config.friction.law == "stribeck_delta" else {"delta"}
    rows = []
    for name, c in ds.coords.items():
        if name not in left_out and not c.dims and c.dtype.kind == "f" and np.isfinite(c):
            value = quantity_text(float(c), str(c.attrs.get("units", "1")))
            rows.append((str(c.attrs.get("long_name", name)), value))
    return pages.terms(rows, "two")


def _meanings(ds: xr.Dataset) -> str:
    """The columns of the table, in words."""
    meanings = [(heading, FEATURES[feature].long_name) for feature, heading, _, _ in _COLUMNS]
    if any(_is_limited(ds, feature) for feature, *_ in _COLUMNS):
        meanings.append(("limited", "accelerations are those within the bandwidth that the configuration gives"))
    return pages.terms(meanings, "short")


# --- table ------------------------------------------------------------------------------------------------------------


def _table(ds: xr.Dataset, dims: list[Dimension]) -> str:
    """All tests, the rows after `MOST_ROWS` left out, which a line below says."""
    size = ds["model_rpn"].size
    columns = [Column("test"), *(Column(d.name, d.unit, d.is_text) for d in dims), Column("RPN")]
    columns += [Column(heading, unit) for _, heading, unit, _ in _COLUMNS]
    cut = pages.paragraph(f"{size - MOST_ROWS} more tests are left out here; the file of results has all.")
    return pages.table(columns, islice(_rows(ds, dims), MOST_ROWS)) + (cut if size > MOST_ROWS else "")


def _rows(ds: xr.Dataset, dims: list[Dimension]) -> Iterator[list[str | Cell]]:
    """A row for each test."""
    lengths = [len(d.points) for d in dims]
    values = [_best(ds, feature) * factor for feature, _, _, factor in _COLUMNS]
    rpn, bands = ds["model_rpn"].values.ravel().tolist(), ds["model_rpn_band"].values.ravel().tolist()
    lights = list(LIGHTS)
    for n in range(ds["model_rpn"].size):
        at = np.unravel_index(n, lengths) if dims else ()
        where = (d.points[int(i)] for d, i in zip(dims, at, strict=True))
        numbers = (number_text(float(column[n])) for column in values)
        yield [str(n), *where, Cell(rpn_text(rpn[n]), lights[bands[n]]), *numbers]


def _is_limited(ds: xr.Dataset, feature: str) -> bool:
    return f"{feature}_limited" in ds and bool(ds[f"{feature}_limited"].notnull().any())


def _best(ds: xr.Dataset, feature: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The band-limited values where there are any: those that the model RPN uses."""
    name = f"{feature}_limited" if _is_limited(ds, feature) else feature
    return np.asarray(ds[name].values, np.float64).ravel()


# --- plots ------------------------------------------------------------------------------------------------------------


def _maps(ds: xr.Dataset) -> str:
    shown = "acceleration_max_limited" if _is_limited(ds, "acceleration_max") else "acceleration_max"
    largest = f"Heat map: {FEATURES[shown].long_name} of every test"
    rated = pages.embedded(plot_matrix(ds), f"Heat map: {RPN_NAME} of every test")
    return pages.side_by_side(rated, pages.embedded(plot_matrix(ds, shown), largest))


def _known(ds: xr.Dataset, rig: RigConfig) -> dict[str, tuple[str, float]]:
    """By the names that records have: those of the report, and the model RPN."""
    tests, rpn = RigTests(rig), ds["model_rpn"].values.ravel().tolist()
    if tests.grid.size != len(rpn):
        return {}
    dims = [dimension(ds, dim) for dim in ds["model_rpn"].dims]
    return {tests.name(n): (point_name(dims, n) or tests.name(n), rpn[n]) for n in range(len(rpn))}


def _traces(records: Mapping[str, xr.Dataset], known: Mapping[str, tuple[str, float]]) -> str:
    """Records over each other, as many as colours tell apart, and the first stroke in detail."""
    names, figures = list(records), []
    for first in range(0, len(names), _MOST_TOGETHER):
        chosen = {name: known.get(name, (name, None)) for name in names[first : first + _MOST_TOGETHER]}
        drawn = {_in_legend(label): records[name] for name, (label, _) in chosen.items()}
        rpn = {_in_legend(label): number for label, number in chosen.values() if number is not None}
        end = min(_first_stroke(record) for record in drawn.values())
        whole = plot_records(drawn, numbers=rpn, heading="Whole tests")
        start = plot_records(drawn, numbers=rpn, heading="The first stroke", window=(0.0, end))
        labels = "; ".join(label for label, _ in chosen.values())
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
