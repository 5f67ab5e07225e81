"""What a picture is of, besides what it shows: the quantities that are held fixed; and why there may be no picture."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence

import numpy as np
import xarray as xr

from stickslip.dataset.axis import short_name
from stickslip.dataset.display import unit_of
from stickslip.dataset.summary import summary
from stickslip.plots.page import NOTE_WIDTH, folded
from stickslip.vocabulary.flags import flag_label
from stickslip.vocabulary.quantities import QUANTITIES

_OF_CYCLES = "period", "frequency", "stick_fraction", "energy_per_cycle", "mu_reversal", "mu_breakaway", "tendency"
_WHY = {  # what no cell does where a variable has no value
    **dict.fromkeys(_OF_CYCLES, "no cell stick-slips"),
    **dict.fromkeys(("settling_time", "equilibrium_crossings", "settled_displacement"), "no cell settles"),
    **dict.fromkeys(("restick_time", "restick_displacement"), "no cell re-sticks"),
    **dict.fromkeys(("breakaway_time", "restick_margin"), "no cell breaks away"),
}


def held_fixed(ds: xr.Dataset, without: Collection[Hashable] = ()) -> list[tuple[str, str]]:
    """Quantities that are equal in all cells and matter, with their values as people write them.

    Those at their default are left out (no damper, a start at rest), and so are those `without`. Once a quantity is
    chosen for one picture out of many, its title says it.
    """
    found = []
    for name, one in ds.coords.items():
        declared = QUANTITIES.get(str(name))
        if declared is None or one.dims or name in without or not np.isfinite(value := float(one)):
            continue
        if value != declared.default and not _of_no_use(ds, str(name)):
            unit = unit_of(one)
            found.append((short_name(one), f"{unit.of(value):.4g} {unit.printed}".rstrip()))
    return found


def held_note(ds: xr.Dataset, first: Sequence[str] = ()) -> list[str]:
    """The note below a plot of what is held fixed, a line or none. first : what is chosen for this plot."""
    fixed = [*first, *(f"{name} = {value}" for name, value in held_fixed(ds))]
    return [folded(f"held fixed: {', '.join(fixed)}", NOTE_WIDTH)] if fixed else []


def _of_no_use(ds: xr.Dataset, name: str) -> bool:
    """Whether a quantity says nothing because another one is zero."""
    return name == "ageing_time" and "ageing_rate" in ds.coords and not ds["ageing_rate"].values.any()


def why_nothing(ds: xr.Dataset, variable: str) -> str:
    """Why a variable of a map has no value anywhere: ``no cell stick-slips, so there is no period (all damped)``."""
    reason = _WHY.get(variable, "no cell has a value")
    found = ""
    if "regime" in ds.data_vars:
        shares = summary(ds)
        names = [flag_label(name).replace("stick_slip", "stick-slip") for name in shares]
        found = f" (all cells: {names[0]})" if len(names) == 1 else f" (cells are {', '.join(names)})"
    return f"{reason}, so there is no {variable} to draw{found}"
