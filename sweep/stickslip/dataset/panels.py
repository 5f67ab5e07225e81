"""What of a result fits on one picture: its last two dimensions are its axes, the others become panels."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from math import prod

import xarray as xr

from stickslip.dataset.axis import MapAxis
from stickslip.dataset.select import ascending

MAX_PANELS = 16
_NO_PANELS = ("state",)  # one of it is drawn


def too_many(sizes: Mapping[Hashable, int]) -> list[Hashable]:
    """The dimensions to fix so that no more panels than fit are left, the longest first. sizes : of all, in order."""
    outer = {dim: size for dim, size in list(sizes.items())[:-2] if size > 1}
    found = list[Hashable]()
    while prod(outer.values()) > MAX_PANELS:
        longest = max(outer, key=lambda dim: outer[dim])
        found.append(longest)
        del outer[longest]
    return found


def told_of(sizes: Mapping[Hashable, int]) -> str | None:
    """What a picture of dimensions of these sizes will leave out, in words; None for nothing."""
    fixed = too_many(sizes)
    if not fixed:
        return None
    outer = {dim: size for dim, size in list(sizes.items())[:-2] if size > 1}
    counts = ", ".join(f"{dim} ({size:,})" for dim, size in outer.items())
    at = " and ".join(f"the middle {dim}" for dim in fixed)
    return (
        f"{prod(outer.values()):,} panels over {counts} are more than the {MAX_PANELS} that fit: a plot of the whole "
        f"shows {at}; stickslip plot --select {fixed[0]}=VALUE shows another"
    )


def part_that_fits(ds: xr.Dataset, dims: Sequence[Hashable]) -> tuple[xr.Dataset, list[str]]:
    """The dataset at the middle of dimensions that would be too many panels, which its title then says; and these
    points, as plain text.

    dims : of what is drawn.
    """
    fixed = too_many({dim: ds.sizes[dim] for dim in dims if dim not in _NO_PANELS})
    if not fixed:
        return ds, []
    ds = ascending(ds)
    at = {dim: ds.sizes[dim] // 2 for dim in fixed}
    title = "\n".join([str(ds.attrs.get("title", "")), ", ".join(MapAxis(ds, dim).heading(i) for dim, i in at.items())])
    told = [MapAxis(ds, dim, plain=True).heading(i) for dim, i in at.items()]
    return ds.isel(at).assign_attrs(title=title.strip()), told
