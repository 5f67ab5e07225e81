"""Shares of the regimes in a map, how many cells need attention, and which variables it does not hold."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.reader import parse_config
from stickslip.config.unit_warnings import one_regime_question
from stickslip.dataset.coarse import chunks
from stickslip.vocabulary.flags import FLAGS, REGIMES, flag_label
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.suggest import listed

BAD_REGIMES = ("failed", "unresolved", "not_computed")  # cells that say nothing about the contact
_CODES = 256  # what fits in the byte of a flag


class Share(NamedTuple):
    """Number of cells, and their part of all cells."""

    cells: int
    fraction: float


def summary(ds: xr.Dataset) -> dict[str, Share]:
    """The regimes that occur, in the order of `REGIMES`, with their number of cells and their share of the dataset."""
    return shares(flag_counts(ds["regime"]))


def shares(cells: Mapping[str, int]) -> dict[str, Share]:
    """Numbers of cells with their shares of all of them, without those that are zero."""
    total = max(1, sum(cells.values()))
    return {name: Share(n, n / total) for name, n in cells.items() if n}


def flag_counts(flags: xr.DataArray) -> dict[str, int]:
    """Number of cells with each value of a flag, by name, in one pass that holds little in memory.

    Codes without a name, which a newer version may have written, are counted as ``code_9``.
    """
    counts = np.zeros(_CODES, np.int64)
    for chunk in chunks(flags):
        part = flags.isel(chunk)
        if part.dtype.kind == "f":  # `where` left cells out
            part = xr.DataArray(part.values[~np.isnan(part.values)])
        counts += np.bincount(codes(part), minlength=_CODES)
    return named(counts, str(flags.name))


def codes(flags: xr.DataArray) -> NDArray[np.uint8]:
    """The values of a flag as unsigned bytes in one row, as `named` counts them."""
    return np.ascontiguousarray(flags.values, np.int8).view(np.uint8).ravel()


def named(counts: NDArray[np.int64], flag: str) -> dict[str, int]:
    """Counts by code as counts by name: all names, and codes without a name where they occur."""
    names = list(FLAGS[flag])
    known = {name: int(counts[code]) for code, name in enumerate(names)}
    unknown = np.flatnonzero(counts[len(names) :]) + len(names)
    return known | {f"code_{code}": int(counts[code]) for code in unknown}


def remark(parts: Mapping[str, Share], file: str | None = None, bad: Collection[str] = BAD_REGIMES) -> str | None:
    """A line about cells without a result; None if there are none.

    parts : as `summary` gives them. file : of the map, for the command that lists them.
    """
    counts = [f"{parts[name].cells:,} {name.replace('_', ' ')}" for name in REGIMES if name in bad and name in parts]
    if not counts:
        return None
    cells = sum(parts[name].cells for name in bad if name in parts)
    text = f"{listed(counts, 'and')} cell{'s' * (cells != 1)}"
    return text if file is None else f"{text}: stickslip inspect {shlex.quote(file)}"


def one_regime_remark(ds: xr.Dataset, parts: Mapping[str, Share]) -> str | None:
    """A question about a map whose cells all have one regime, if a value in its configuration is implausible."""
    text = str(ds.attrs.get("configuration", ""))
    if len(parts) != 1 or "axes:" not in text:  # cells computed one by one have no configuration
        return None
    return one_regime_question(parse_config(text), flag_label(next(iter(parts))))


def step_limit_remark(ds: xr.Dataset, file: str | None = None) -> str | None:
    """A line about cells that ran out of steps; None if there are none. file : as for `remark`.

    Of a map that does not keep `status`, that it could tell why cells are unresolved.
    """
    if "status" not in ds:
        open_cells = flag_counts(ds["regime"])["unresolved"]
        return "why cells are unresolved is in status, which output.variables leaves out" if open_cells else None
    limited = flag_counts(ds["status"])["step_limit"]
    if not limited:
        return None
    text = f"{limited:,} cell{'s' * (limited != 1)} ended at the step limit; solver: {{max_steps: ...}} raises it"
    return text if file is None else f"{text}: stickslip inspect {shlex.quote(file)} --status step_limit"


def why_absent(ds: xr.Dataset, *names: str) -> str | None:
    """The reason why a map lacks the variables `names`, and how to get them; None if it holds them or never would.

    Two lines: `holds no damping_ratio, ...` and the hint. `output: {variables: [...]}` may leave variables out; a map
    to the horizon (early_stop: false) has some that no other has.
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
    variables = ", ".join(name for name in VARIABLES if name in there or name in absent)
    return (
        f"holds no {listed(absent, 'and')}, since output.variables kept {listed(there, 'and')} alone\n"
        f"hint: stickslip run CONFIG --set 'output.variables=[{variables}]' -o other.nc computes the map with "
        f"{'it' if len(absent) == 1 else 'them'}"
    )
