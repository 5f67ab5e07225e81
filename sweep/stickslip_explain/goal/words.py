"""What panels would need, in words."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from stickslip.config.studies import Table
from stickslip.dataset.display import unit_of
from stickslip.studies.borders.contours import line_counts
from stickslip.studies.report import axis_names, parts_over, search_settings
from stickslip.vocabulary.display_units import spoken
from stickslip.vocabulary.flags import VERDICTS

_DIGITS = 4
_SMALL = 0.01  # of the square of a change: if one of two parameters has no larger part, it alone changes


def report(ds: xr.Dataset) -> Iterator[str | Table]:
    """The goal, what each panel would need, how much of the plane is quiet, and what can be missed."""
    yield f"goal     {ds.attrs['goal']}"
    if bool((ds["verdict"] != 0).any()):
        yield needs(ds)
    exists = ds["quiet_probability"].notnull()
    share = float((ds["quiet_probability"] >= ds.attrs["goal_probability"]).sum()) / max(int(exists.sum()), 1)
    yield f"quiet    {100 * share:.3g} % of the points of the plane that a cell can have"
    yield line_counts(ds, "goal")
    yield search_settings(ds, "goal")


def needs(ds: xr.Dataset) -> Table:
    """A row for each panel: verdict and probability, and the nearest changes along either parameter and in both."""
    dims, (y, x) = list(map(str, ds["verdict"].dims)), map(str, ds["quiet_probability"].dims[-2:])
    rows = []
    for where, part in parts_over(ds, dims):
        both = " and ".join(filter(None, (_change(part, "together", name) for name in (x, y))))
        changes = [*(_change(part, "alone", name) for name in (x, y)), "" if _is_hardly_both(part, x, y) else both]
        row = [*where, VERDICTS[int(part["verdict"])], f"{float(part['quiet_share']):.3g}"]
        rows.append([*row, *(change or "-" for change in changes)])
    words = [*axis_names(ds, dims), "now"]
    return Table(
        "What each needs to be quiet, or has in reserve", words, ["P(quiet)", "one", "or the other", "or both"], rows
    )


def _change(part: xr.Dataset, what: str, name: str) -> str:
    """`mu_start below 0.31 (-0.04)`; nothing where there is no such change."""
    value, here = float(part[f"{what}_{name}"]), float(part[f"here_{name}"])
    if not np.isfinite(value):
        return ""
    ways = ("down to", "up to") if VERDICTS[int(part["verdict"])] == "quiet" else ("below", "above")
    unit = unit_of(part[f"here_{name}"])
    by = f"{unit.of(value - here):+.{_DIGITS - 1}g} {unit.name}".rstrip()
    return f"{spoken(name)} {ways[value >= here]} {unit.text(value, _DIGITS)} ({by})"


def _is_hardly_both(part: xr.Dataset, *names: str) -> bool:
    """True if the nearest change of both is one of a single parameter, as nearly as makes no difference."""
    value, here = (np.array([float(part[f"{what}_{name}"]) for name in names]) for what in ("together", "here"))
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.log(value / here) ** 2
    return bool(np.isfinite(change).all() and change.min() < _SMALL * change.sum())
