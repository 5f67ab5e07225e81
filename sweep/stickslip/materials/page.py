"""The report of a comparison: one HTML page, to read, to send and to print."""

from __future__ import annotations

import xarray as xr

from stickslip.dataset.export import table_of
from stickslip.materials.words import Shown, Words
from stickslip.pages import (
    Column,
    Section,
    configuration,
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
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import MATERIAL_VARIABLES

_COEFFICIENTS = ("a1", "a2", "a3", "a4", "mu_start")
_SYSTEM = ("mass", "stiffness", "damping", "normal_load")


def material_page(ds: xr.Dataset, unit: str | None = None, title: str | None = None) -> str:
    """A page of what `stickslip.compare` found. unit : of speeds; None takes that of the measured points.

    title : that of the dataset, unless given.
    """
    words = Words(ds, unit)
    best = words.names[0]
    alt = f"Friction over slip speed of {', '.join(words.names)}, and the belt speeds above which they are quiet"
    meaning = "".join(paragraph(text) for text in (words.what_quiet_means(), words.what_the_interval_means()) if text)
    sections = [
        Section("Which is quiet", _ranks(words) + meaning),
        Section("Friction, and where vibration ends", embedded(plot_materials(ds), alt)),
        Section("The fitted curves", _fits(ds)),
        Section("The system", terms(_system(ds, words))),
        Section("What the numbers mean", terms(_meanings(ds))),
        Section("Where this comes from", _origin(ds)),
    ]
    several = len(words.names) > 1
    summary = f"{best} is quiet from the lowest belt speed on." if several else f"The border of {best}."
    return page(
        str(ds.attrs["title"]) if title is None else title,
        summary,
        sections,
        warnings=[warning(r.rstrip(".")) for r in words.remarks()],
    )


def _ranks(words: Words) -> str:
    """The table of ranks."""
    columns = [*words.columns()]
    # the material is the heading of its row
    columns[0], columns[1] = columns[1], columns[0]
    return _table(columns)


def _table(columns: list[Shown]) -> str:
    rows = zip(*(column.cells for column in columns), strict=True)
    return table([Column(column.name, column.unit, column.is_text) for column in columns], [list(row) for row in rows])


def _fits(ds: xr.Dataset) -> str:
    """Coefficients with their intervals, and what is said of each fit."""
    columns = [Shown("material", "", True, tuple(map(str, ds["material"].values)))]
    for name in _COEFFICIENTS:
        values = zip(*(ds[f"{name}{end}"].values for end in ("", "_low", "_high")), strict=True)
        cells = tuple(f"{value:.3g} ({low:.2g} to {high:.2g})" for value, low, high in values)
        columns.append(Shown(name, units.spelled(str(ds[name].attrs["units"])), False, cells))
    columns.append(Shown("points", "", False, tuple(str(int(count)) for count in ds["points"].values)))
    columns.append(Shown("residual", "rms", False, tuple(f"{float(one):.2g}" for one in ds["residual_rms"].values)))
    said = zip(map(str, ds["material"].values), map(str, ds["fit_quality"].values), strict=True)
    formula = "Friction coefficient over slip speed w: a1 + a2 w + a3 exp(-w/a4); in brackets the 95 % intervals."
    return paragraph(formula) + _table(columns) + terms(said, "short")


def _system(ds: xr.Dataset, words: Words) -> list[tuple[str, str]]:
    found = []
    for name in _SYSTEM:
        row = PARAMETERS[name]
        found.append((row.long_name, f"{float(ds.attrs[f'system_{name}']):.6g} {units.spelled(row.units)}"))
    if "belt_speed" in ds.attrs:
        found.append(("belt speed", f"{words.speed(float(ds.attrs['belt_speed']))} {words.unit}"))
    return found


def _meanings(ds: xr.Dataset) -> list[tuple[str, str]]:
    """The variables of the table, as the dataset has them."""
    shown = [name for name in table_of(ds).columns if name in MATERIAL_VARIABLES]
    found = []
    for name in shown:
        declared = MATERIAL_VARIABLES[name]
        comment = f" ({declared.comment})" if declared.comment else ""
        unit = units.spelled(declared.units)
        found.append((f"{name} [{unit}]" if unit else name, f"{declared.long_name}{comment}"))
    return found


def _origin(ds: xr.Dataset) -> str:
    files = terms([("points", str(ds.attrs["files"]).replace("\n", ", "))], "short")
    intro = paragraph("Saved as a file, this configuration finds all borders of these curves (stickslip run):")
    return provenance(ds.attrs) + files + intro + configuration(str(ds.attrs["configuration"]))
