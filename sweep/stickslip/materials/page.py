"""The report of a comparison, to read, to send and to print: the decision, what limits it, table and
picture on the first sheet, and on the second what they rest on."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import starmap

import numpy as np
import xarray as xr

from stickslip.materials.varied import varied
from stickslip.materials.words import Shown, Words
from stickslip.pages import (
    Column,
    Section,
    configuration,
    details,
    embedded,
    page,
    paragraph,
    provenance,
    table,
    terms,
    warning,
)
from stickslip.plots.materials import plot_materials
from stickslip.vocabulary import units
from stickslip.vocabulary.results import MATERIAL_VARIABLES

_COEFFICIENTS = ("a1", "a2", "a3", "a4", "mu_start")
_MOST_DIGITS = 6
_ONLY_SCATTER = "Other specimens, another temperature and what is not known of the system are in no number here."
_SMALL_PRINT = ("tendency", "mu_start")  # columns of ranks that decide nothing; mu_start is among the fits
_VARIABLES = {"fit": "fit_good"}  # shown under other names


def material_page(ds: xr.Dataset, unit: str | None = None, title: str | None = None) -> str:
    """A page of what `stickslip.compare` found. unit : of speeds; None takes that of the measured points.

    title : that of the dataset, unless given.
    """
    words = Words(ds, unit)
    alt = f"Friction over slip speed of {', '.join(words.names)}, and the belt speeds above which they are quiet"
    ranks, fits = [one for one in words.columns() if one.name not in _SMALL_PRINT], _fits(ds, words)
    others = words.remarks()
    first = next((text for text in words.limits() if _limits(text, words.names)), _ONLY_SCATTER)
    system = paragraph(f"The system: {', '.join(f'{name} {value}' for name, value in words.conditions())}.")
    small = [
        ("The fitted curves", _curves(ds, fits)),
        ("What the numbers mean", _items(_method(words)) + terms(_meanings([*ranks, *fits]), "short")),
        ("Where this comes from", _origin(ds)),
    ]
    sections = [
        Section("Which is quiet", system + _table(ranks) + _items([text for text in others if text != first])),
        *(Section(f"Over {one.name}", _table(one.columns) + _items(one.remarks)) for one in varied(ds, words)),
        Section("Friction, and where vibration ends", embedded(plot_materials(ds, title=""), alt) + details(small)),
    ]
    heading = str(ds.attrs["title"]) if title is None else title
    return page(heading, words.answer(), sections, warnings=[warning(first, "What limits this")])


def _limits(text: str, names: Sequence[str]) -> bool:
    """Whether a remark limits the decision most: it is about the best material, or about all."""
    about = [name for name in names if re.search(rf"(?<!\w){re.escape(name)}(?!\w)", text)]
    return not about or names[0] in about


def _items(texts: Sequence[str]) -> str:
    return "".join(map(paragraph, texts))


def _method(words: Words) -> list[str]:
    return [text for text in (words.what_quiet_means(), words.what_the_interval_means()) if text]


def _table(columns: list[Shown]) -> str:
    rows = zip(*([cell.replace("stick_slip", "stick-slip") for cell in one.cells] for one in columns), strict=True)
    return table([Column(column.name, column.unit, column.is_text) for column in columns], [list(row) for row in rows])


def _fits(ds: xr.Dataset, words: Words) -> list[Shown]:
    """Coefficients with their intervals, speeds in the unit of the page."""
    columns = [Shown("material", "", True, tuple(map(str, ds["material"].values)))]
    for name in _COEFFICIENTS:
        declared = str(ds[name].attrs["units"])
        unit, factor = (words.unit, words.factor) if declared == "m s-1" else (units.spelled(declared), 1.0)
        values = zip(*(factor * ds[f"{name}{end}"].values for end in ("", "_low", "_high")), strict=True)
        columns.append(Shown(name, unit, False, tuple(starmap(_within, values))))
    return columns


def _within(value: float, low: float, high: float) -> str:
    """A number with its interval: as many digits, three or more, as tell its ends apart."""
    if not (np.isfinite(low) and np.isfinite(high)):
        return f"{value:.3g} (not determined)" if value else "0 (assumed)"
    digits = 3
    while digits < _MOST_DIGITS and low < high and len({f"{one:.{digits}g}" for one in (value, low, high)}) < 3:
        digits += 1
    told = [f"{float(f'{one:.{digits}g}'):g}" for one in (value, low, high)]
    return f"{told[0]} ({told[1]} to {told[2]})"


def _curves(ds: xr.Dataset, columns: list[Shown]) -> str:
    """The table of fits, and what is said of each."""
    said = zip(map(str, ds["material"].values), map(str, ds["fit_quality"].values), strict=True)
    formula = "Friction coefficient over slip speed w: a1 + a2 w + a3 exp(-w/a4); in brackets the 95 % intervals."
    return paragraph(formula) + _table(columns) + terms(said, "names")


def _meanings(columns: Sequence[Shown]) -> list[tuple[str, str]]:
    """What the columns of the tables on the page are, as the dataset has them."""
    found = {}
    for name in (column.name for column in columns):
        declared = MATERIAL_VARIABLES.get(_VARIABLES.get(name, name.replace(" ", "_")))
        declared = MATERIAL_VARIABLES["regime"] if name.startswith(("at ", "worst ")) else declared
        declared = MATERIAL_VARIABLES["quiet_probability"] if name.startswith("P(quiet)") else declared
        if declared is not None:
            comment = f" ({declared.comment})" if declared.comment else ""
            found[name] = f"{declared.long_name}{comment}"
    return [*found.items()]


def _origin(ds: xr.Dataset) -> str:
    files = terms([("points", str(ds.attrs["files"]).replace("\n", ", "))], "short")
    intro = paragraph("Saved as a file, this configuration finds all borders of these curves (stickslip run):")
    return provenance(ds.attrs) + files + intro + configuration(str(ds.attrs["configuration"]))
