"""Measured points on screen: fits of files, in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from stickslip.fit import AgeingFit, CurveFit, Ranking, fit_ageing_file, fit_file, rank

_CURVE = ("a1", "a2", "a3", "a4")
_UNITS = {"a2": "s/m", "a4": "m/s", "t0": "s", "beta": "per decade"}


@dataclass(frozen=True)
class FileFit:
    """What the points of a file say: a curve, or ageing."""

    curve: CurveFit | None = None
    ageing: AgeingFit | None = None


def fit_points(path: Path, unit: str | None = None) -> FileFit:
    """The fit that belongs to the columns of a CSV file: speed and mu, or time and mu.

    unit : of the speeds or times, where the header names none. Raises ConfigError.
    """
    try:
        heading = next(
            (line for line in path.read_text("utf-8-sig").splitlines() if line.strip()[:1] not in ("", "#")), ""
        )
    except (OSError, UnicodeDecodeError):
        heading = ""  # the reader of points says what is wrong
    if heading.strip().lower().startswith("time"):
        return FileFit(ageing=fit_ageing_file(path, unit))
    return FileFit(curve=fit_file(path, unit))


def describe_curve(fit: CurveFit) -> str:
    """Coefficients with their 95 % intervals, and the quality of the fit."""
    rows = [
        _row(name, getattr(fit, name), None if name in fit.assumed else fit.interval[name], name in fit.at_bound)
        for name in (*_CURVE, "mu_start")
    ]
    worth = f"  {fit.points} points, residual {fit.residual_rms:.2g}, R2 {fit.r_squared:.4f}"
    return "\n".join([*rows, worth, f"  {fit.quality}"])


def describe_ageing(fit: AgeingFit | None) -> str:
    """Level, slope and onset with their 95 % intervals, and the quality of the fit."""
    if fit is None:
        return ""
    rows = [_row(name, getattr(fit, name), fit.interval[name]) for name in ("mu0", "beta", "t0")]
    worth = f"  {fit.points} points, residual {fit.residual_rms:.2g}, R2 {fit.r_squared:.4f}"
    return "\n".join([*rows, worth, f"  {fit.quality}"])


def describe_ranking(fits: Mapping[str, AgeingFit], at: float) -> str:
    """Lubricants in order of level and of slope, best first."""
    order: Ranking = rank(fits, at=at)
    level = ", ".join(f"{place.name} ({place.value:.3f})" for place in order.by_level)
    slope = ", ".join(f"{place.name} ({place.value:.3f})" for place in order.by_slope)
    return f"best first\n  by static friction after {at:g} s: {level}\n  by growth per decade: {slope}"


def _row(name: str, value: float, interval: tuple[float, float] | None, at_bound: bool = False) -> str:
    """A coefficient with its 95 % interval; None: it was assumed."""
    known = "assumed" if interval is None else f"95 %: {interval[0]:.4g} to {interval[1]:.4g}"
    return f"  {name:9}{value:10.4g} {_UNITS.get(name, ''):11} {known}{', at its bound' if at_bound else ''}"
