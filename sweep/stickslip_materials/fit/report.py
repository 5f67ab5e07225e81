"""Fits for people and programs: coefficients with their intervals, what to paste, columns."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from stickslip.config.yaml import write_yaml
from stickslip.vocabulary.models import CURVE, FITTED
from stickslip_materials.fit.ageing import Ranking
from stickslip_materials.fit.files import MaterialFit
from stickslip_materials.fit.memory import MemoryFit
from stickslip_materials.fit.steps import StepPoints

_UNITS = {
    CURVE.slope: "s/m", CURVE.decay: "m/s", "t0": "s", "beta": "per decade", "v_0": "m/s", "D_c": "m",
    "drive_stiffness": "1/m",
}  # fmt: skip
_DRIVE = "drive_stiffness"  # no parameter of a contact
_WILD = 0.2  # share of its mean by which friction varies where it sticks and slips


def describe(material: MaterialFit) -> str:
    """Numbers with their 95 % intervals, and the quality of the fit."""
    fit = material.curve or material.ageing
    assert fit is not None
    marks, head = {}, []
    if curve := material.curve:
        marks = dict.fromkeys(curve.at_bound, ", at its bound") | dict.fromkeys(curve.assumed, ", assumed")
        head = [f"  law: {curve.law}"] if curve.law != "stribeck" else []
    rows = [_row(name, value, fit.interval[name]) + marks.get(name, "") for name, value in _values(material).items()]
    worth = f"  {fit.points} points, residual {fit.residual_rms:.2g}, R2 {fit.r_squared:.4f}"
    return "\n".join([*head, *rows, worth, f"  {fit.quality}"])


def describe_memory(name: str, fit: MemoryFit) -> str:
    """Parameters with their 95 % intervals, the quality of the fit, and what to paste."""
    rows = [_row(key, value, fit.interval.get(key, (value, value))) for key, value in fit.values.items()]
    pasted = {"law": fit.law, **{name: _rounded(value) for name, value in fit.values.items() if name != _DRIVE}}
    heading = [f"{name}: {fit.law}", *([f"  {fit.columns}"] if fit.columns else [])]
    return "\n".join([*heading, *rows, f"  {fit.quality}", f"  {write_yaml({'friction': pasted})}"])


def _row(name: str, value: float, interval: tuple[float, float]) -> str:
    low, high = interval
    known = f"95 %: {low:.5g} to {high:.5g}"
    if math.isinf(low):
        known = f"95 %: {high:.5g} or less"
    elif math.isinf(high):
        known = f"95 %: {low:.5g} or more" if low > 0 else "not determined"
    return f"  {name:18}{value:10.5g} {_UNITS.get(name, ''):11} {known}"


def _values(material: MaterialFit) -> Mapping[str, float]:
    """What a fit determines."""
    if curve := material.curve:
        return {name: getattr(curve, name) for name in (*FITTED, "mu_stop") if not math.isnan(getattr(curve, name))}
    return {name: getattr(material.ageing, name) for name in ("mu0", "beta", "t0")}


def describe_ranking(order: Ranking) -> str:
    """Lubricants in order of level and of slope, best first."""
    level, slope = (", ".join(f"{place.name} ({place.value:.3f})" for place in places)
                    for places in (order.by_level, order.by_slope))  # fmt: skip
    return f"best first\n  by static friction after {order.at:g} s: {level}\n  by growth per decade: {slope}"


def describe_columns(materials: Sequence[MaterialFit]) -> str:
    """The columns of the table of these materials, what they were taken for, and what was left out."""
    points = materials[0].points
    names = [name for name in points.read if name != "mu" and (len(materials) == 1 or name != "sigma")]
    taken = {points.read[name]: " in ".join(filter(None, (name, points.units.get(name)))) for name in names}
    taken |= {material.points.read["mu"]: "friction" for material in materials}
    parts = [", ".join(f"{text!r} is {kind}" for text, kind in taken.items()), *points.notes]
    parts += [f"not used: {', '.join(map(repr, points.ignored))}"] if points.ignored else []
    parts += [f"left out above the header: lines {points.above[0]} to {points.above[1]}"] if points.above else []
    return "; ".join(parts)


def describe_steps(points: StepPoints) -> str:
    """Points of a record at steps, what is doubtful among them, and what was left out."""
    lines = [points.columns] if points.columns else []
    lines += [f"{points.speed.size} points, from the speeds {points.speed.min():.4g} to {points.speed.max():.4g} m/s"]
    wild = points.speed[points.scatter > _WILD * points.mu]
    if wild.size:
        speeds = ", ".join(f"{speed:.4g}" for speed in wild[:8])
        lines.append(f"note     friction varies by more than a fifth at {speeds} m/s, as where it sticks and slips")
    return "\n".join([*lines, *(f"left out {text}" for text in points.left_out[:20])])


def columns_of(material: MaterialFit) -> dict[str, Any]:
    """The columns of one material as plain data, for programs."""
    points = material.points
    return {"columns": dict(points.read), "ignored": list(points.ignored), "notes": list(points.notes),
            "lines_above": list(points.above or ()), "units": dict(points.units),
            "assumed_units": {column.name: column.units for column in points.assumed}}  # fmt: skip


def as_plain(material: MaterialFit) -> dict[str, Any]:
    """A fit as plain data, for programs."""
    fit, values = material.curve or material.ageing, _values(material)
    assert fit is not None
    own = ("law", "outliers", "unidentified", "assumed", "at_bound") if material.curve else ()
    shared = ("standard_error", "covariance", "residual_rms", "r_squared", "points", "good", "quality")
    return {
        "name": material.name, "file": str(material.path), "kind": "curve" if material.curve else "ageing",
        "coefficients": values, "interval": {name: list(fit.interval[name]) for name in values},
        "confidence": 0.95, **{name: getattr(fit, name) for name in (*shared, *own)}, **columns_of(material),
    }  # fmt: skip


def as_yaml(materials: Sequence[MaterialFit]) -> str:
    """The curves as a configuration has them, in SI: the section friction, of several an axis of materials; of several
    laws a section each."""
    curves = {material.name: material.curve for material in materials if material.curve is not None}
    if len({curve.law for curve in curves.values()}) > 1:
        return "\n".join(f"# {material.name}\n{as_yaml([material])}" for material in materials if material.curve)
    law = next(iter(curves.values())).law
    friction = {} if law == "stribeck" else {"law": law} | ({"delta": 2} if law == "stribeck_delta" else {})
    names = dict.fromkeys(name for curve in curves.values() for name in curve.coefficients())
    columns = {name: [_rounded(getattr(curve, name)) for curve in curves.values()] for name in names}
    if len(curves) == 1:
        return write_yaml({"friction": friction | {name: value for name, (value,) in columns.items()}})
    axes = {"material": {"zip": columns, "labels": [*curves]}}
    return write_yaml({"friction": friction, "axes": axes} if friction else {"axes": axes})


def _rounded(value: float) -> float | str:
    """Six digits; `none` for NaN."""
    return "none" if math.isnan(value) else float(f"{value:.6g}")
