"""Curves and ageing fitted to the points of files, which may hold one material or several, and fits for people and
programs: coefficients with their intervals, what to paste, columns."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.config.yaml import write_yaml
from stickslip.errors import ConfigError
from stickslip.vocabulary.models import BREAKAWAY, CURVE, FITTED
from stickslip.vocabulary.parameter import FRICTION, SPEED, Parameter
from stickslip.vocabulary.quantities import AGEING_COLUMNS, CURVE_COLUMNS
from stickslip_materials.fit.ageing import AgeingFit, Ranking, fit_ageing
from stickslip_materials.fit.curve import CurveFit
from stickslip_materials.fit.fitting import fit_curve
from stickslip_materials.fit.points import Columns, only, read_materials
from stickslip_materials.fit.roles import Wanted

if TYPE_CHECKING:
    from stickslip_materials.fit.steps import StepPoints

NO_CURVE = "friction over waiting time, expected it over speed", "stickslip fit ranks lubricants by their ageing"
_UNITS = {CURVE.slope: "s/m", CURVE.decay: "m/s", "t0": "s", "beta": "per decade"}
_FASTEST = 200.0  # m/s, beyond which a speed is doubted that has a unit
_WILD = 0.2  # share of its mean by which friction varies where it sticks and slips


@dataclass(frozen=True)
class MaterialFit:
    """The fit to the points of one material: a curve, or ageing.

    name : no other material read with it has the same. path : the file they come from.
    """

    name: str
    path: Path
    points: Columns = field(repr=False)
    curve: CurveFit | None = None
    ageing: AgeingFit | None = None

    def coefficients(self) -> dict[str, float]:
        """Of the curve; none of ageing."""
        return self.curve.coefficients() if self.curve else {}


def fit_file(path: str | Path, unit: str | None = None, wanted: Wanted | None = None) -> CurveFit:
    """The curve through the points of a file of one material.

    unit : of the speeds, where the header names none. Without it they are read in m/s, which the quality of the fit
    says, and it is not called good. wanted : instead of it, unit and columns to take. Raises ConfigError.
    """
    fits = fit_materials([Path(path)], wanted or Wanted(unit or ""), CURVE_COLUMNS)
    return only(path, {fit.name: fit.curve for fit in fits if fit.curve})


def fit_ageing_file(path: str | Path, unit: str | None = None) -> AgeingFit:
    """Ageing from the waiting times and friction coefficients of a file; `unit` is that of the times."""
    fits = fit_materials([Path(path)], Wanted(unit or ""), AGEING_COLUMNS)
    return only(path, {fit.name: fit.ageing for fit in fits if fit.ageing})


def fit_materials(
    materials: Sequence[Path] | Mapping[str, tuple[ArrayLike, ArrayLike] | CurveFit],
    wanted: Wanted | None = None,
    columns: Sequence[Parameter] | None = None,
    law: str = "stribeck",
    ageing: bool = True,
) -> list[MaterialFit]:
    """A fit for each material, in their order: a wide table has several.

    Parameters
    ----------
    materials : CSV or .xlsx files; or by name, points (slip speeds in m/s, friction coefficients) or a fit of them
    wanted : which columns to take, and in which units, where the headings do not say
    columns : CURVE_COLUMNS or AGEING_COLUMNS; None takes what each file has
    law : of curves, as for `fit_curve`
    ageing : False refuses friction over waiting time

    Returns
    -------
    list of MaterialFit
        Named by their columns in tables of several, else by their files.

    Raises
    ------
    ConfigError
        For files that will not do, all of them.
    ValueError
        For points that will not do.
    """
    if isinstance(materials, Mapping):
        return [_named(name, points, law) for name, points in materials.items()]
    rows: list[tuple[str, str, Path, Columns]] = []
    errors: list[ConfigError] = []
    for file, path in zip(names_of(materials), materials, strict=True):
        try:
            read = read_materials(path, columns, wanted)
            rows += [(label, file, path, points) for label, points in read.items()]
        except ConfigError as error:
            errors.append(error)
    labels, fits = Counter(label or file for label, file, *_ in rows), []
    for label, file, path, points in rows:
        name = f"{file}: {label}" if label and labels[label] > 1 else label or file
        try:
            fits.append(_fitted(name, path, label, points, law, ageing))
        except ConfigError as error:
            errors.append(error)
    if errors:
        raise ConfigError.of_files(errors)
    names = _numbered([fit.name for fit in fits])
    return [replace(fit, name=name) for fit, name in zip(fits, names, strict=True)]


def _named(name: str, points: tuple[ArrayLike, ArrayLike] | CurveFit, law: str) -> MaterialFit:
    """A material of points, or of a curve whose points nobody knows."""
    if isinstance(points, CurveFit):
        return MaterialFit(name, Path(name), Columns(), points)
    speed, mu = (np.asarray(values, np.float64) for values in points)
    try:
        return MaterialFit(name, Path(name), Columns({"speed": speed, "mu": mu}), fit_curve(speed, mu, law=law))
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def _fitted(name: str, path: Path, label: str, points: Columns, law: str, ageing: bool) -> MaterialFit:
    """The fit of the points of a material, called `label` in its file. Raises ConfigError."""
    if "time" in points and not ageing:
        raise ConfigError.of(path, *NO_CURVE)
    try:
        if "time" in points:
            return _cautious(MaterialFit(name, path, points, ageing=fit_ageing(points["time"], points["mu"])))
        curve = fit_curve(**points, unit=points.units.get("speed") or "m/s", law=law)
        return _cautious(MaterialFit(name, path, points, curve))
    except ValueError as error:
        raise ConfigError.of(path, str(error), path=(label,) if label else ()) from None


def _cautious(fit: MaterialFit) -> MaterialFit:
    """The fit, with a word on units that were assumed."""
    if not (caution := fit.points.caution()):
        return fit
    own = {name: replace(each, quality=f"{caution} {each.quality}", good=False)
           for name in ("curve", "ageing") if (each := getattr(fit, name))}  # fmt: skip
    return replace(fit, **own)


def question_of(material: MaterialFit) -> str | None:
    """The question about a fitted curve of implausible speeds, or implausible friction at its points or break-away."""
    points, breakaway = material.points, material.curve.mu_start if material.curve else 0.0
    fastest, most = (float(np.max(points.get(name, 0.0))) for name in ("speed", "mu"))
    if fastest > (_FASTEST if "speed" in points.units else SPEED):
        return f"measured at up to {fastest:.6g} m/s; did you mean {fastest:.6g} mm/s?"
    for what, value in (("measured friction", most), (f"{BREAKAWAY} of the fit", breakaway)):
        if value > FRICTION:
            return f"{what} = {value:.3g} is more than the friction coefficient of most contacts ({FRICTION:g})"
    return None


def names_of(paths: Sequence[Path]) -> list[str]:
    """A name for each file: its stem; the whole path of files that share it."""
    counts = Counter(path.stem for path in paths)
    whole = [path.with_suffix("").as_posix() for path in paths]
    return _numbered([path.stem if counts[path.stem] == 1 else name for path, name in zip(paths, whole, strict=True)])


def _numbered(names: Sequence[str]) -> list[str]:
    before = [names[:i].count(name) for i, name in enumerate(names)]
    return [f"{name} ({count + 1})" if count else name for name, count in zip(names, before, strict=True)]


# --- for people and programs ------------------------------------------------------------------------------------------


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
