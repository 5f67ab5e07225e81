"""Curves and ageing fitted to the points of files, which may hold one material or several."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from stickslip.errors import ConfigError
from stickslip.vocabulary.models import BREAKAWAY
from stickslip.vocabulary.parameter import SPEED, Parameter
from stickslip.vocabulary.quantities import AGEING_COLUMNS, CURVE_COLUMNS
from stickslip_materials.fit.ageing import AgeingFit, fit_ageing
from stickslip_materials.fit.curve import CurveFit
from stickslip_materials.fit.fitting import fit_curve
from stickslip_materials.fit.points import Columns, only, read_materials
from stickslip_materials.fit.roles import Wanted

NO_CURVE = "friction over waiting time, expected it over speed", "stickslip fit ranks lubricants by their ageing"


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
    from stickslip.config.describe import DOUBTED_FRICTION, friction_question  # pydantic takes its time

    points, breakaway = material.points, material.curve.mu_start if material.curve else 0.0
    fastest, most = (float(np.max(points.get(name, 0.0))) for name in ("speed", "mu"))
    if fastest > SPEED["speed" in points.units]:
        return f"measured at up to {fastest:.6g} m/s; did you mean {fastest:.6g} mm/s?"
    if most > DOUBTED_FRICTION:
        return friction_question(most, "measured friction")
    follows = " It follows from the fit, not from a point."
    return f"{friction_question(breakaway, BREAKAWAY)}{follows}" if breakaway > DOUBTED_FRICTION else None


def names_of(paths: Sequence[Path]) -> list[str]:
    """A name for each file: its stem; the whole path of files that share it."""
    counts = Counter(path.stem for path in paths)
    whole = [path.with_suffix("").as_posix() for path in paths]
    return _numbered([path.stem if counts[path.stem] == 1 else name for path, name in zip(paths, whole, strict=True)])


def _numbered(names: Sequence[str]) -> list[str]:
    before = [names[:i].count(name) for i, name in enumerate(names)]
    return [f"{name} ({count + 1})" if count else name for name, count in zip(names, before, strict=True)]
