"""The page of a comparison, to read, to send and to print: answer, ranks, picture and notes, and on a second sheet what
they rest on."""

from collections.abc import Iterator

import xarray as xr

from stickslip.plots import pages
from stickslip.plots.pages import Section
from stickslip.vocabulary.models import FORMULA
from stickslip_materials.compare.table import RankTable
from stickslip_materials.plots import plot_materials
from stickslip_materials.variables import MATERIAL_VARIABLES

_AGAIN = "Saved as a file, this configuration finds all borders of these curves (stickslip run):"
_MEANT = ("quiet_above", "margin", "quiet_probability", "fit_good")


def material_page(ds: xr.Dataset, title: str | None = None) -> str:
    """A page of a comparison (`stickslip.compare`). title : that of the dataset, unless given."""
    ranking = RankTable(ds)
    alt = f"Friction over slip speed of {', '.join(ranking.names)}, and the belt speeds above which they are quiet"
    table = ranking.table()
    columns = [*(pages.Column(name, is_text=True) for name in table.words), *map(pages.Column, table.numbers)]
    system = f"The system: {', '.join(f'{name} {value}' for name, value in ranking.conditions())}."
    notes = [(name or "all", text) for name, text in ranking.notes()]
    qualities = pages.terms(zip(ranking.names, map(str, ds["fit_quality"].values), strict=True), "names")
    files = pages.terms([("points", str(ds.attrs["files"]).replace("\n", ", "))], "short")
    origin = pages.provenance(ds.attrs) + files + pages.paragraph(_AGAIN)
    small = [
        ("The fitted curves", pages.paragraph(f"Friction coefficient over slip speed w: {FORMULA}.") + qualities),
        ("What the numbers mean", pages.terms(_meanings(), "short")),
        ("Where this comes from", origin + pages.configuration(ds.attrs["configuration"])),
    ]
    sections = [
        Section("Which is quiet", pages.table(columns, table.rows) + pages.paragraph(system)),
        Section("Friction, and where vibration ends", pages.embedded(plot_materials(ds, title=""), alt)),
        *([Section("Notes", pages.terms(notes, "short"))] if notes else []),
    ]
    sections[-1] = sections[-1]._replace(html=sections[-1].html + pages.details(small))
    return pages.page(str(ds.attrs["title"]) if title is None else title, ranking.answer(), sections)


def _meanings() -> Iterator[tuple[str, str]]:
    """The columns that decide, as the dataset describes them."""
    for row in map(MATERIAL_VARIABLES.__getitem__, _MEANT):
        yield row.name.replace("_", " "), f"{row.long_name} ({row.comment})" if row.comment else row.long_name
