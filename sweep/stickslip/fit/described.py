"""Fits in words: coefficients with their intervals, the section of a configuration they make, materials in order."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from stickslip.fit.ageing import AgeingFit, Ranking, rank
from stickslip.fit.curve import CurveFit
from stickslip.fit.files import MaterialFit

_CURVE = ("a1", "a2", "a3", "a4")
_AGEING = ("mu0", "beta", "t0")
_UNITS = {"a2": "s/m", "a4": "m/s", "t0": "s", "beta": "per decade"}


def describe(fit: MaterialFit) -> str:
    """What the points of one material say."""
    return describe_curve(fit.curve) if fit.curve else describe_ageing(fit.ageing)


def describe_curve(fit: CurveFit) -> str:
    """Coefficients with their 95 % intervals, and the quality of the fit."""
    rows = [
        _row(name, getattr(fit, name), None if name in fit.assumed else fit.interval[name], name in fit.at_bound)
        for name in (*_CURVE, "mu_start")
    ]
    worth = f"  {fit.points} points, residual {fit.residual_rms:.2g}, R2 {fit.r_squared:.4f}"
    law = (
        [] if fit.law == "stribeck" else [f"  law: {fit.law} (AICc lower than that of stribeck by {fit.preferred:.2g})"]
    )
    return "\n".join([*law, *rows, worth, f"  {fit.quality}"])


def describe_ageing(fit: AgeingFit | None) -> str:
    """Level, slope and onset with their 95 % intervals, and the quality of the fit."""
    if fit is None:
        return ""
    rows = [_row(name, getattr(fit, name), fit.interval[name]) for name in _AGEING]
    worth = f"  {fit.points} points, residual {fit.residual_rms:.2g}, R2 {fit.r_squared:.4f}"
    return "\n".join([*rows, worth, f"  {fit.quality}"])


def describe_ranking(fits: Mapping[str, AgeingFit], at: float) -> str:
    """Lubricants in order of level and of slope, best first."""
    order: Ranking = rank(fits, at=at)
    level = ", ".join(f"{place.name} ({place.value:.3f})" for place in order.by_level)
    slope = ", ".join(f"{place.name} ({place.value:.3f})" for place in order.by_slope)
    return f"best first\n  by static friction after {at:g} s: {level}\n  by growth per decade: {slope}"


def describe_columns(fits: Sequence[MaterialFit]) -> str:
    """What the columns of the table of these materials were taken for, and what was left out."""
    points = fits[0].points
    shared = {name: text for name, text in points.read.items() if name != "mu" and (name != "sigma" or len(fits) == 1)}
    taken = [f"{heading!r} is {name}" for name, heading in shared.items()]
    columns = dict.fromkeys(repr(one.points.read["mu"]) for one in fits)
    notes = [f"; {note}" for note in points.notes]
    left = f"; not used: {', '.join(map(repr, points.ignored))}" if points.ignored else ""
    above = (
        "; left out above the header: line {0}"
        if len({*(points.above or ())}) == 1
        else "; left out above the header: lines {0} to {1}"
    )
    skipped = above.format(*points.above) if points.above else ""
    return f"{', '.join(taken)}, {', '.join(columns)} friction{''.join(notes)}{left}{skipped}"


def columns_of(fit: MaterialFit) -> dict[str, Any]:
    """The same of one material as plain data, for programs."""
    points = fit.points
    return {"columns": dict(points.read), "ignored": list(points.ignored), "notes": list(points.notes),
            "lines_above": list(points.above or ()), "units": dict(points.units),
            "assumed_units": {column.name: column.units for column in points.assumed}}  # fmt: skip


def is_plain(fit: MaterialFit) -> bool:
    """Whether the columns are plainly called what they were taken for, and nothing was left out."""
    points = fit.points
    return not (points.ignored or points.notes or points.above) and all(
        text.lower().startswith(name) for name, text in points.read.items()
    )


def as_yaml(fits: Sequence[MaterialFit]) -> str:
    """The curves as a configuration has them: the section friction, of several an axis of materials; of several laws
    a section each."""
    curves = [(one.name, one.curve) for one in fits if one.curve is not None]
    laws = {curve.law for _, curve in curves}
    if len(laws) > 1:
        return "\n".join(f"# {one.name}\n{as_yaml([one])}" for one in fits if one.curve is not None)
    (law,) = laws
    of_law = [] if law == "stribeck" else [f"  law: {law}", *(["  delta: 2"] if law == "stribeck_delta" else [])]
    if len(curves) == 1:
        ((_, curve),) = curves
        rows = [f"  {name}: {_number(getattr(curve, name)):14}{_comment(name)}".rstrip() for name in _CURVE]
        return "\n".join(["friction:", *of_law, *rows])
    columns = [
        f"      {name}: [{', '.join(_number(getattr(curve, name)) for _, curve in curves)}]{_comment(name, '   ')}"
        for name in _CURVE
    ]
    labels = ", ".join(_quoted(name) for name, _ in curves)
    return "\n".join([*(["friction:", *of_law] if of_law else []),
                      "axes:", "  material:", "    zip:", *columns, f"    labels: [{labels}]"])  # fmt: skip


def as_plain(fit: MaterialFit) -> dict[str, Any]:
    """A fit as plain data, for programs."""
    found = fit.curve or fit.ageing
    assert found is not None
    names = (*_CURVE, "mu_start") if fit.curve else _AGEING
    told: dict[str, Any] = {
        "name": fit.name, "file": str(fit.path), "kind": "curve" if fit.curve else "ageing",
        "coefficients": {name: getattr(found, name) for name in names},
        "interval": {name: list(found.interval[name]) for name in names},
        "standard_error": dict(found.standard_error), "covariance": found.covariance, "confidence": 0.95,
        "residual_rms": found.residual_rms, "r_squared": found.r_squared, "points": found.points,
        "good": found.good, "quality": found.quality, **columns_of(fit),
    }  # fmt: skip
    if fit.curve is not None:
        told |= {
            "law": fit.curve.law,
            "outliers": fit.curve.outliers,
            "unidentified": fit.curve.unidentified,
            "assumed": fit.curve.assumed,
            "at_bound": fit.curve.at_bound,
        }
    return told


def _row(name: str, value: float, interval: tuple[float, float] | None, at_bound: bool = False) -> str:
    """A coefficient with its 95 % interval; None: it was assumed."""
    known = "assumed" if interval is None else _known(*interval)
    return f"  {name:9}{value:10.4g} {_UNITS.get(name, ''):11} {known}{', at its bound' if at_bound else ''}"


def _known(low: float, high: float) -> str:
    """A 95 % interval, as far as there is one."""
    if math.isinf(high):
        return f"95 %: {low:.4g} or more" if low > 0 else "not determined"
    return f"95 %: {low:.4g} to {high:.4g}" if math.isfinite(low) else f"95 %: {high:.4g} or less"


def _number(value: float) -> str:
    """A number that YAML reads as one: with a point before an exponent."""
    text = f"{value:.6g}"
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def _comment(name: str, before: str = "") -> str:
    return f"{before}# {_UNITS[name]}" if name in _UNITS else ""


def _quoted(name: str) -> str:
    """A name as YAML writes it in a list; in quotes unless it is a plain word."""
    words = name.replace("-", "").replace("_", "").replace(" ", "")
    is_word = words.isalnum() and words[:1].isalpha() and words.lower() not in ("null", "true", "false", "yes", "no")
    return name if is_word and name == name.strip() else '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
