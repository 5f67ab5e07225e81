"""The quantities that are held fixed in a picture; and why there may be no picture."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from stickslip.config.yaml import section_in
from stickslip.dataset.display import short_name, unit_of
from stickslip.dataset.summary import summary
from stickslip.plots.layout import NOTE_WIDTH, folded
from stickslip.plots.palette import regime_label
from stickslip.vocabulary.models import BREAKAWAY, CURVE, STRIBECK
from stickslip.vocabulary.models.stribeck import OF_HYSTERESIS
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.results import REGIMES

_LONGEST = 20_000  # letters of a configuration that is looked into
_ALWAYS = ("damping",)  # none decides everything
_OF_CYCLES = ("period", "frequency", "stick_fraction", "energy_per_cycle", *(row.name for row in STRIBECK.results))
_WHY = {  # what no cell does where a variable has no value
    **dict.fromkeys(_OF_CYCLES, "no cell stick-slips"),
    **dict.fromkeys(("settling_time", "equilibrium_crossings", "settled_displacement"), "no cell settles"),
    **dict.fromkeys(("restick_time", "restick_displacement"), "no cell re-sticks"),
    **dict.fromkeys(("breakaway_time", "restick_margin"), "no cell breaks away"),
}


def fixed_values(ds: xr.Dataset) -> list[tuple[str, str]]:
    """Quantities that are equal in all cells and matter, with their values as people write them.

    Those at their default are left out (no damper, a start at rest).
    """
    rows = []
    measured = _measured(ds)
    for name, coordinate in ds.coords.items():
        declared = QUANTITIES.get(str(name))
        if declared is None or coordinate.dims or not np.isfinite(value := float(coordinate)):
            continue
        if measured and name in STRIBECK.replaced:
            if name == STRIBECK.replaced[0]:
                rows.append(measured)
        elif name == "ageing_time" and "ageing_rate" in ds.coords and not ds["ageing_rate"].values.any():
            continue  # says nothing
        elif value != declared.default or name in _ALWAYS:
            unit = unit_of(coordinate)
            rows.append((short_name(coordinate), f"{unit.of(value):.4g} {unit.printed}".rstrip()))
    return rows


def _measured(ds: xr.Dataset) -> tuple[str, str] | None:
    """The curve as it was written by what is measured, if all cells have the same."""
    text = str(ds.attrs.get("configuration", ""))
    names = tuple(STRIBECK.measured)
    if names[-1] not in text or len(text) > _LONGEST or any(ds.coords[a].dims for a in CURVE if a in ds.coords):
        return None
    friction = section_in(text, "friction")
    start, least, speed = (friction.get(name) for name in names)
    if not all(isinstance(value, int | float) for value in (start, least, speed)) or not {*CURVE} <= {*ds.coords}:
        return None  # of goals, a plane of what is measured
    if not np.isclose(float(STRIBECK.start_of(ds)), float(start)):  # type: ignore[arg-type]
        return None
    unit = unit_of(ds["belt_speed"] if "belt_speed" in ds.coords else ds[CURVE.decay])
    return BREAKAWAY, f"{start:g} falling to {least:g} at {unit.of(speed):.4g} {unit.printed}"


def fixed_note(ds: xr.Dataset, first: Sequence[str] = ()) -> list[str]:
    """The note below a plot of what is held fixed, a line or none. first : what is chosen for this plot."""
    fixed = [*first, *(f"{name} = {value}" for name, value in fixed_values(ds))]
    return [folded(f"held fixed: {', '.join(fixed)}", NOTE_WIDTH)] if fixed else []


def why_nothing(ds: xr.Dataset, variable: str) -> str:
    """Why a variable of a map has no value anywhere: ``no cell stick-slips, so there is no period (all damped)``."""
    reason = _true_reason(ds, variable) or _WHY.get(variable, "no cell has a value")
    cells = ""
    if "regime" in ds.data_vars:
        shares = summary(ds)
        names = [*map(regime_label, shares)]
        cells = f" (all cells: {names[0]})" if len(names) == 1 else f" (cells are {', '.join(names)})"
    return f"{reason}, so there is no {variable} to draw{cells}"


def _true_reason(ds: xr.Dataset, variable: str) -> str | None:
    """Why motions that do what a variable needs have no value of it all the same."""
    given = "mu_stop" in ds.coords and np.isfinite(ds["mu_stop"].values).any()
    if variable in OF_HYSTERESIS and not given:
        return f"{variable} is defined where friction returns along a line to mu_stop, which is none in all cells"
    regime = ds.get("regime")
    if variable in _OF_CYCLES and regime is not None and (regime == REGIMES.index("stick_slip")).any():
        return "no cell has a value, although some stick-slip"
    return None
