"""How borders and the order of materials change over a quantity of the system, in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np
import xarray as xr

from stickslip.materials.system import critical_damping
from stickslip.materials.words import Shown, Words

_CALLED = {"damping": "damping", "normal_load": "load", "friction_scale": "scale of friction"}


class Varied(NamedTuple):
    """A quantity that varies: what it is called, the table of borders, and where the order of materials changes."""

    name: str
    columns: list[Shown]
    remarks: list[str]


def varied(ds: xr.Dataset, words: Words) -> Iterator[Varied]:
    """The quantities of a comparison that vary."""
    for name in words.varied:
        values, borders = ds[name].values, ds[f"quiet_above_over_{name}"].values
        told = [_value(ds, name, value) for value in values]
        columns = [Shown(_CALLED[name], "", True, tuple(words.names))]
        columns += [Shown(one, words.unit, False, tuple(words.bound(border) for border in borders[:, j]))
                    for j, one in enumerate(told)]  # fmt: skip
        changes = [
            f"{words.names[i]} and {words.names[k]} change places between {told[j]} and {told[j + 1]}."
            for i, k in combinations(range(len(borders)), 2)
            for j in range(values.size - 1)
            if _crosses(*borders[i, j : j + 2], *borders[k, j : j + 2])
        ]
        known = bool(np.count_nonzero(np.isfinite(borders).any(axis=1)) > 1)
        yield Varied(_CALLED[name], columns, changes or ["The order is the same at all of these."] * known)


def _value(ds: xr.Dataset, name: str, value: float) -> str:
    """A value of the quantity as it was given."""
    if name == "damping" and "damping_in_percent" in ds.attrs:
        return f"{100.0 * value / critical_damping(ds):.3g} %"
    unit: Callable[[str], str] = {"damping": "{} N s/m", "normal_load": "{} N"}.get(name, "x {}").format
    return unit(f"{value:.3g}")


def _crosses(one: float, one_then: float, other: float, other_then: float) -> bool:
    """Whether the order of two borders is another one afterwards; those that are equal have none."""
    if any(map(math.isnan, (one, one_then, other, other_then))):
        return False
    return (one < other and one_then > other_then) or (one > other and one_then < other_then)
