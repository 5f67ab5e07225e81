"""Fits in words: coefficients with their intervals, the section of a configuration they make, materials in order."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from stickslip.vocabulary.models import CURVE, FITTED
from stickslip.vocabulary.suggest import listed
from stickslip_materials.fit.ageing import AgeingFit, rank
from stickslip_materials.fit.curve import CurveFit
from stickslip_materials.fit.files import MaterialFit
from stickslip_materials.fit.memory import BRISTLES, MemoryFit
from stickslip_materials.fit.steps import StepPoints

_UNITS = {CURVE.slope: "s/m", CURVE.decay: "m/s", "t0": "s", "beta": "per decade"}
_MEMORY_UNITS = {"v_0": "m/s", "D_c": "m", "contact_stiffness": "N/m", "drive_stiffness": "1/m"}
_AGEING = ("mu0", "beta", "t0")


def describe(material: MaterialFit) -> str:
    """Numbers with their 95 % intervals, and the quality of the fit."""
    curve, fit = material.curve, material.curve or material.ageing
    assert fit is not None
    rows = []
    if curve and curve.law != "stribeck":
        rows.append(f"  law: {curve.law} (AICc lower than that of stribeck by {curve.preferred:.2g})")
    for name in _names(curve):
        low, high = fit.interval[name]
        known = f"95 %: {low:.4g} to {high:.4g}" if math.isfinite(low) else f"95 %: {high:.4g} or less"
        if math.isinf(high):
            known = f"95 %: {low:.4g} or more" if low > 0 else "not determined"
        if curve and name in curve.assumed:
            known = "assumed"
        elif curve and name in curve.at_bound:
            known += ", at its bound"
        rows.append(f"  {name:9}{getattr(fit, name):10.4g} {_UNITS.get(name, ''):11} {known}")
    worth = f"  {fit.points} points, residual {fit.residual_rms:.2g}, R2 {fit.r_squared:.4f}"
    return "\n".join([*rows, worth, f"  {fit.quality}"])


def _names(curve: CurveFit | None) -> tuple[str, ...]:
    """What a fit of a curve, or of ageing, determines."""
    if curve is None:
        return _AGEING
    return (*FITTED, "mu_stop") if "mu_stop" in curve.coefficients() else FITTED


def describe_memory(name: str, fit: MemoryFit) -> str:
    """Parameters with their 95 % intervals, the quality of the fit, and what to paste."""
    rows = [f"{name}: {fit.law}", *([f"  {fit.columns}"] if fit.columns else [])]
    for key, value in fit.values.items():
        low, high = fit.interval.get(key, (math.nan, math.nan))
        known = f"95 %: {low:.5g} to {high:.5g}" if math.isfinite(low) else "the first speed"
        rows.append(f"  {key:18}{value:10.5g} {_MEMORY_UNITS.get(key, ''):4} {known}")
    paste = {key: value for key, value in fit.values.items() if key not in ("mu_k", "drive_stiffness")}
    law = "" if fit.law == BRISTLES else f"law: {fit.law}, "
    pasted = ", ".join(f"{key}: {value:.6g} {_MEMORY_UNITS.get(key, '')}".rstrip() for key, value in paste.items())
    return "\n".join([*rows, f"  {fit.quality}", f"  friction: {{{law}{pasted}}}"])


def describe_ranking(fits: Mapping[str, AgeingFit], at: float) -> str:
    """Lubricants in order of level and of slope, best first."""
    order = rank(fits, at=at)
    level, slope = (", ".join(f"{place.name} ({place.value:.3f})" for place in places)
                    for places in (order.by_level, order.by_slope))  # fmt: skip
    return f"best first\n  by static friction after {at:g} s: {level}\n  by growth per decade: {slope}"


def describe_columns(materials: Sequence[MaterialFit]) -> str:
    """The columns of the table of these materials, what they were taken for, and what was left out."""
    points = materials[0].points
    several = len(materials) > 1
    parts = [f"{text!r} is {name}" + (f" in {points.units[name]}" if name in points.units else "")
             for name, text in points.read.items() if name != "mu" and (not several or name != "sigma")]  # fmt: skip
    columns = dict.fromkeys(repr(one.points.read["mu"]) for one in materials)
    parts = [", ".join([*parts, f"{', '.join(columns)} friction"])]
    parts += points.notes
    parts += [f"not used: {', '.join(map(repr, points.ignored))}"] if points.ignored else []
    if points.above:
        first, last = points.above
        lines = f"line {first}" if first == last else f"lines {first} to {last}"
        parts.append(f"left out above the header: {lines}")
    return "; ".join(parts)


def describe_steps(points: StepPoints) -> str:
    """Points of a record at steps, what is doubtful among them, and what was left out."""
    lines = [points.columns] if points.columns else []
    lines += [f"{points.speed.size} points, from the speeds {points.speed.min():.4g} to {points.speed.max():.4g} m/s"]
    wild = points.speed[points.scatter > 0.2 * points.mu]
    if wild.size:
        speeds = listed([f"{1000 * speed:.4g} mm/s" for speed in wild[:8]], "and")
        reason = "where it sticks and slips, its mean is not that of sliding"
        lines.append(f"note     friction varies by more than a fifth at {speeds}: {reason}")
    return "\n".join([*lines, *(f"left out {text}" for text in points.left_out[:20])])


def columns_of(material: MaterialFit) -> dict[str, Any]:
    """The columns of one material as plain data, for programs."""
    points = material.points
    return {"columns": dict(points.read), "ignored": list(points.ignored), "notes": list(points.notes),
            "lines_above": list(points.above or ()), "units": dict(points.units),
            "assumed_units": {column.name: column.units for column in points.assumed}}  # fmt: skip


def as_plain(material: MaterialFit) -> dict[str, Any]:
    """A fit as plain data, for programs."""
    fit, names = material.curve or material.ageing, _names(material.curve)
    assert fit is not None
    own = ("law", "outliers", "unidentified", "assumed", "at_bound") if material.curve else ()
    shared = ("standard_error", "covariance", "residual_rms", "r_squared", "points", "good", "quality")
    return {
        "name": material.name, "file": str(material.path), "kind": "curve" if material.curve else "ageing",
        "coefficients": {name: getattr(fit, name) for name in names},
        "interval": {name: list(fit.interval[name]) for name in names},
        "confidence": 0.95, **{name: getattr(fit, name) for name in (*shared, *own)}, **columns_of(material),
    }  # fmt: skip


# --- YAML -------------------------------------------------------------------------------------------------------------


def as_yaml(materials: Sequence[MaterialFit]) -> str:
    """The curves as a configuration has them: the section friction, of several an axis of materials; of several laws
    a section each."""
    curves = [(one.name, one.curve) for one in materials if one.curve is not None]
    laws = {curve.law for _, curve in curves}
    if len(laws) > 1:
        return "\n".join(f"# {one.name}\n{as_yaml([one])}" for one in materials if one.curve is not None)
    (law,) = laws
    of_law = [] if law == "stribeck" else [f"  law: {law}", *(["  delta: 2"] if law == "stribeck_delta" else [])]
    names = dict.fromkeys(name for _, curve in curves for name in curve.coefficients())
    rows = {name: [_number(getattr(curve, name)) for _, curve in curves] for name in names}
    comments = {name: f"# {_UNITS[name]}" if name in _UNITS else "" for name in names}
    if len(curves) == 1:
        lines = [f"  {name}: {value:14}{comments[name]}".rstrip() for name, (value,) in rows.items()]
        return "\n".join(["friction:", *of_law, *lines])
    lines = [f"      {name}: [{', '.join(row)}]   {comments[name]}".rstrip() for name, row in rows.items()]
    labels = f"    labels: {json.dumps([name for name, _ in curves], ensure_ascii=False)}"  # which is YAML
    return "\n".join([*(["friction:", *of_law] if of_law else []), "axes:", "  material:", "    zip:", *lines, labels])


def _number(value: float) -> str:
    """A number that YAML reads as one: with a point before an exponent; `none` for NaN."""
    if math.isnan(value):
        return "none"
    text = f"{value:.6g}"
    return text.replace("e", ".0e") if "e" in text and "." not in text else text
