"""The page of a comparison, to read, to send and to print: answer, ranks, picture and notes, and on a second sheet what
they rest on."""

from collections.abc import Iterable, Iterator

import numpy as np
import xarray as xr

from stickslip import pages
from stickslip.config.studies import Table
from stickslip.pages import Section
from stickslip.vocabulary import units
from stickslip.vocabulary.models import BREAKAWAY, FITTED, FORMULA
from stickslip_materials.compare.table import RankTable
from stickslip_materials.plots import plot_materials
from stickslip_materials.variables import MATERIAL_VARIABLES

_AGAIN = "Saved as a file, this configuration finds all borders of these curves (stickslip run):"
_SMALL_PRINT = ("tendency", BREAKAWAY)  # columns of ranks that decide nothing; the latter is among the fits
_MEANT = ("quiet_above", "margin", "quiet_probability", "fit_good")


def material_page(ds: xr.Dataset, unit: str | None = None, title: str | None = None) -> str:
    """A page of a comparison (`stickslip.compare`). unit : of speeds; None takes that of the measured points.

    title : that of the dataset, unless given.
    """
    ranking = RankTable(ds, unit)
    alt = f"Friction over slip speed of {', '.join(ranking.names)}, and the belt speeds above which they are quiet"
    system = f"The system: {', '.join(f'{name} {value}' for name, value in ranking.conditions())}."
    notes = [(name or "all", text) for name, text in ranking.notes()]
    qualities = pages.terms(zip(ranking.names, map(str, ds["fit_quality"].values), strict=True), "names")
    files = pages.terms([("points", str(ds.attrs["files"]).replace("\n", ", "))], "short")
    origin = pages.provenance(ds.attrs) + files + pages.paragraph(_AGAIN)
    formula = f"Friction coefficient over slip speed w: {FORMULA}; in brackets the 95 % intervals."
    small = [
        ("The fitted curves", pages.paragraph(formula) + _table_of(_fits(ds, ranking)) + qualities),
        ("What the numbers mean", pages.terms(_meanings(), "short")),
        ("Where this comes from", origin + pages.configuration(ds.attrs["configuration"])),
    ]
    sections = [
        Section("Which is quiet", _table_of(ranking.table(), _SMALL_PRINT) + pages.paragraph(system)),
        Section("Friction, and where vibration ends", pages.embedded(plot_materials(ds, title=""), alt)),
        *([Section("Notes", pages.terms(notes, "short"))] if notes else []),
    ]
    sections[-1] = sections[-1]._replace(html=sections[-1].html + pages.details(small))
    return pages.page(str(ds.attrs["title"]) if title is None else title, ranking.answer(), sections)


def _table_of(table: Table, left_out: Iterable[str] = ()) -> str:
    """A table as HTML, without the columns of these names."""
    names = [*table.words, *table.numbers]
    shown = [i for i, name in enumerate(names) if name not in left_out]
    columns = [pages.Column(names[i], is_text=i < len(table.words)) for i in shown]
    return pages.table(columns, ([row[i].replace("stick_slip", "stick-slip") for i in shown] for row in table.rows))


def _fits(ds: xr.Dataset, ranking: RankTable) -> Table:
    """The coefficients with their intervals."""
    columns = {}
    for name in (*FITTED, *(["mu_stop"] if "mu_stop" in ds else [])):
        declared = str(ds[name].attrs["units"])
        is_speed = declared == "m s-1"
        unit, factor = (ranking.unit, ranking.factor) if is_speed else (units.spelled(declared), 1.0)
        values = (factor * ds[f"{name}{end}"].values for end in ("", "_low", "_high"))
        columns[f"{name} [{unit}]" if declared != "1" else name] = [*map(_with_interval, *values)]
    return Table("", ["material"], [*columns], zip(ranking.names, *columns.values(), strict=True))


def _with_interval(value: float, low: float, high: float) -> str:
    """A number with its interval, in digits that tell its ends apart."""
    if not (np.isfinite(low) and np.isfinite(high)):
        return f"{value:.3g} (not determined)" if value else "0 (assumed)"
    digits = next((n for n in (3, 4, 5) if len({f"{end:.{n}g}" for end in (low, value, high)}) == 3), 6)
    return f"{value:.{digits}g} ({low:.{digits}g} to {high:.{digits}g})"


def _meanings() -> Iterator[tuple[str, str]]:
    """The columns that decide, as the dataset describes them."""
    for row in map(MATERIAL_VARIABLES.__getitem__, _MEANT):
        yield row.name.replace("_", " "), f"{row.long_name} ({row.comment})" if row.comment else row.long_name
