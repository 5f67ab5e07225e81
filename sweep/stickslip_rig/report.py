"""The page of a test matrix: one self-contained HTML file, without network or scripts."""

from collections.abc import Iterator, Mapping
from itertools import islice

import numpy as np
import xarray as xr

from stickslip.config.model import Config
from stickslip.plots import pages
from stickslip.plots.pages import Cell, Column, Section
from stickslip_rig.evaluation import as_records, shown_table, unfinished
from stickslip_rig.plots import LIGHTS, plot_matrix, plot_records
from stickslip_rig.quantities import RPN_NAME
from stickslip_rig.sections import sections_of

MOST_ROWS = 500  # of the table
_MOST_TOGETHER = 6  # records drawn over each other, as many as there are colours
_STYLE = "".join(f"td.{name} {{ background: {colour}; color: #000; }}\n" for name, colour in LIGHTS.items()) + (
    "td { -webkit-print-color-adjust: exact; print-color-adjust: exact; }\n"
)


def report(ds: xr.Dataset, records: Mapping[str, xr.Dataset], rig: Config) -> str:
    """The page of a test matrix (`run_matrix`) as text.

    records : those to draw, by name. rig : the configuration the matrix was computed from.
    """
    again = pages.paragraph("The full configuration; saved as a file, it gives the same matrix again:")
    words = ((str(name).replace("_", " "), str(v.attrs.get("long_name", name))) for name, v in ds.data_vars.items())
    sections = [
        Section("The matrix", pages.embedded(plot_matrix(ds), f"Heat map: {RPN_NAME} of every test")),
        Section("Traces", "\n".join(_traces(ds, records, sections_of(rig).drive.strokes))),
        Section("All tests", _table(ds)),
        Section("What the words mean", pages.terms(words, "short")),
        Section("Where this comes from", pages.provenance(ds.attrs) + again + pages.configuration(rig.to_yaml())),
    ]
    title = str(ds.attrs.get("title", "")) or rig.title
    return pages.page(
        title, f"{ds['model_rpn'].size} tests", sections, warnings=[*map(pages.warning, unfinished(ds))], style=_STYLE
    )


def _traces(ds: xr.Dataset, records: Mapping[str, xr.Dataset], strokes: int) -> Iterator[str]:
    """Records over each other, as many as colours tell apart, and the first stroke in detail."""
    rpn = dict(zip(as_records(ds)["record"].values.tolist(), ds["model_rpn"].values.ravel().tolist(), strict=True))
    for first in range(0, len(records), _MOST_TOGETHER):
        drawn = dict(islice(records.items(), first, first + _MOST_TOGETHER))
        end = min(float(np.ptp(record["time"].values)) for record in drawn.values()) / strokes
        whole = plot_records(drawn, numbers=rpn, heading="Whole tests")
        start = plot_records(drawn, numbers=rpn, heading="The first stroke", window=(0.0, end))
        yield pages.embedded(whole, f"Force and acceleration over time: {'; '.join(drawn)}")
        yield pages.embedded(start, f"The first stroke of the same: {'; '.join(drawn)}")


def _table(ds: xr.Dataset) -> str:
    """All tests, the model RPN on its light; rows after `MOST_ROWS` are left out, which a line below says."""
    table, bands = shown_table(ds), [list(LIGHTS)[code] for code in ds["model_rpn_band"].values.ravel().tolist()]
    columns = [Column("test", is_text=True), *map(Column, table.numbers)]
    rows: Iterator[list[str | Cell]] = (
        [name, Cell(rpn, band), *rest] for (name, rpn, *rest), band in zip(table.rows, bands, strict=True)
    )
    more = len(bands) - MOST_ROWS
    cut = pages.paragraph(f"{more} more tests are left out here; the file of results has all.") if more > 0 else ""
    return pages.table(columns, islice(rows, MOST_ROWS)) + cut
