"""Maps that do not hold every variable of a cell (`output: {variables: [...]}`): what is missing, and how to get it."""

from __future__ import annotations

import xarray as xr

from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.suggest import listed


def why_absent(ds: xr.Dataset, *names: str) -> str | None:
    """Why a map does not hold the variables `names`, and how to get them; None if it holds them or never would.

    Two lines: `holds no damping_ratio, ...` and the hint. A map to the horizon (early_stop: false) has some that no
    other has.
    """
    there = [str(name) for name in ds.data_vars if name in VARIABLES]
    absent = [name for name in names if name in VARIABLES and name not in there]
    if not absent or "regime" not in there:
        return None
    to_horizon = [name for name in absent if VARIABLES[name].when == "full"]
    if to_horizon and VARIABLES.keys() - set(there) == {v.name for v in VARIABLES.values() if v.when == "full"}:
        return (
            f"holds no {listed(absent, 'and')}, which only a run to a horizon defines\n"
            "hint: solver: {early_stop: false, horizon: ...} computes to a horizon"
        )
    wanted = [name for name in VARIABLES if name in there or name in absent]
    return (
        f"holds no {listed(absent, 'and')}, since output.variables kept {listed(there, 'and')} alone\n"
        f"hint: stickslip run CONFIG --set 'output.variables=[{', '.join(wanted)}]' -o other.nc computes the map with "
        f"{'it' if len(absent) == 1 else 'them'}"
    )
