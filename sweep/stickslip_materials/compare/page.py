"""The report of a comparison, to read, to send and to print: verdict, table, picture and notes on the first sheet, and
on the second what they rest on."""

from collections.abc import Sequence
from itertools import starmap

import numpy as np
import xarray as xr

from stickslip import pages
from stickslip.pages import Section
from stickslip.vocabulary import units
from stickslip.vocabulary.models import BREAKAWAY, FITTED, FORMULA
from stickslip_materials.compare.table import RankColumn, RankTable
from stickslip_materials.plots import plot_materials
from stickslip_materials.variables import MATERIAL_VARIABLES

_MOST_DIGITS = 6
_AGAIN = "Saved as a file, this configuration finds all borders of these curves (stickslip run):"
_SMALL_PRINT = ("tendency", BREAKAWAY)  # columns of ranks that decide nothing; the latter is among the fits


def material_page(ds: xr.Dataset, unit: str | None = None, title: str | None = None) -> str:
    """A page of a comparison (`stickslip.compare`). unit : of speeds; None takes that of the measured points.

    title : that of the dataset, unless given.
    """
    ranking = RankTable(ds, unit)
    alt = f"Friction over slip speed of {', '.join(ranking.names)}, and the belt speeds above which they are quiet"
    ranks, fits = [column for column in ranking.columns() if column.name not in _SMALL_PRINT], _fits(ds, ranking)
    system = f"The system: {', '.join(f'{name} {value}' for name, value in ranking.conditions())}."
    notes = [(name or "all", text) for name, text in ranking.notes()]
    qualities = pages.terms(zip(ranking.names, map(str, ds["fit_quality"].values), strict=True), "names")
    files = pages.terms([("points", str(ds.attrs["files"]).replace("\n", ", "))], "short")
    origin = pages.provenance(ds.attrs) + files + pages.paragraph(_AGAIN)
    formula = f"Friction coefficient over slip speed w: {FORMULA}; in brackets the 95 % intervals."
    method = "".join(map(pages.paragraph, ranking.method()))
    small = [
        ("The fitted curves", pages.paragraph(formula) + _table(fits) + qualities),
        ("What the numbers mean", method + pages.terms(_meanings([*ranks, *fits]), "short")),
        ("Where this comes from", origin + pages.configuration(ds.attrs["configuration"])),
    ]
    sections = [
        Section("Which is quiet", _table(ranks) + pages.paragraph(system)),
        Section("Friction, and where vibration ends", pages.embedded(plot_materials(ds, title=""), alt)),
        *([Section("Notes", pages.terms(notes, "short"))] if notes else []),
    ]
    heading = str(ds.attrs["title"]) if title is None else title
    sections[-1] = sections[-1]._replace(html=sections[-1].html + pages.details(small))
    return pages.page(heading, ranking.answer(), sections)


def _table(columns: list[RankColumn]) -> str:
    cells = ([cell.replace("stick_slip", "stick-slip") for cell in column.cells] for column in columns)
    heads = [pages.Column(column.name, column.unit, column.is_text) for column in columns]
    return pages.table(heads, [list(row) for row in zip(*cells, strict=True)])


def _fits(ds: xr.Dataset, ranking: RankTable) -> list[RankColumn]:
    columns = [RankColumn("material", "", True, tuple(ranking.names))]
    for name in (*FITTED, *(["mu_stop"] if "mu_stop" in ds else [])):
        declared = str(ds[name].attrs["units"])
        is_speed = declared == "m s-1"
        unit, factor = (ranking.unit, ranking.factor) if is_speed else (units.spelled(declared), 1.0)
        values = zip(*(factor * ds[f"{name}{end}"].values for end in ("", "_low", "_high")), strict=True)
        columns.append(RankColumn(name, unit, False, tuple(starmap(_with_interval, values))))
    return columns


def _with_interval(value: float, low: float, high: float) -> str:
    """A number with its interval: as many digits, three or more, as tell its ends apart."""
    if not (np.isfinite(low) and np.isfinite(high)):
        return f"{value:.3g} (not determined)" if value else "0 (assumed)"
    numbers, digits = (value, low, high), 3
    while digits < _MOST_DIGITS and low < high and len({f"{number:.{digits}g}" for number in numbers}) < 3:
        digits += 1
    texts = [f"{float(f'{number:.{digits}g}'):g}" for number in numbers]
    return f"{texts[0]} ({texts[1]} to {texts[2]})"


def _meanings(columns: Sequence[RankColumn]) -> list[tuple[str, str]]:
    """The columns of the tables on the page as the dataset describes them."""
    meanings = {}
    for column in columns:
        name = "fit_good" if column.name == "fit" else column.name.replace(" ", "_")
        name = "regime" if column.name.startswith(("at ", "worst ")) else name
        name = "quiet_probability" if name.startswith("P(quiet)") else name
        if (declared := MATERIAL_VARIABLES.get(name)) is not None:
            comment = f" ({declared.comment})" if declared.comment else ""
            meanings[column.name] = f"{declared.long_name}{comment}"
    return [*meanings.items()]
