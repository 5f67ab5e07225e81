"""Curves and ageing fitted to the points of files, which may hold one material or several."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from stickslip.errors import ConfigError
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import AGEING_COLUMNS, CURVE_COLUMNS
from stickslip_materials.fit.ageing import AgeingFit, fit_ageing
from stickslip_materials.fit.curve import CurveFit
from stickslip_materials.fit.fitting import fit_curve, fit_repeats
from stickslip_materials.fit.points import Columns, kind_of, only, read_materials
from stickslip_materials.fit.roles import Wanted

Fit = TypeVar("Fit", CurveFit, AgeingFit)
NO_CURVE = "friction over waiting time, expected it over speed", "stickslip fit ranks lubricants by their ageing"


@dataclass(frozen=True)
class MaterialFit:
    """The fit to the points of one material: a curve, or ageing.

    name : no other material read with it has the same. path : the file they come from. repeats : the fit of each
    repeat, of a material that was measured several times; its points are those of all.
    """

    name: str
    path: Path
    points: Columns = field(repr=False)
    curve: CurveFit | None = None
    ageing: AgeingFit | None = None
    repeats: tuple[MaterialFit, ...] = field(default=(), repr=False)

    @property
    def parts(self) -> tuple[MaterialFit, ...]:
        """The repeats, or the material itself."""
        return self.repeats or (self,)


def fit_file(path: str | Path, unit: str | None = None, wanted: Wanted | None = None) -> CurveFit:
    """The curve through the points of a file of one material.

    unit : of the speeds, where the header names none. Without it they are read in m/s, which the quality of the fit
    says, and it is not called good. wanted : instead of it, unit and columns to take. Raises ConfigError.
    """
    fits = fit_materials([Path(path)], wanted or Wanted(unit or ""), CURVE_COLUMNS)
    curve = only(path, {fit.name: fit.curve for fit in fits})
    assert curve is not None
    return curve


def fit_ageing_file(path: str | Path, unit: str | None = None) -> AgeingFit:
    """Ageing from the waiting times and friction coefficients of a file; `unit` is that of the times."""
    fits = fit_materials([Path(path)], Wanted(unit or ""), AGEING_COLUMNS)
    ageing = only(path, {fit.name: fit.ageing for fit in fits})
    assert ageing is not None
    return ageing


def fit_materials(
    materials: Sequence[Path] | Mapping[str, tuple[ArrayLike, ArrayLike] | CurveFit],
    wanted: Wanted | None = None,
    columns: Sequence[Parameter] | None = None,
    same: Sequence[str] = (),
    law: str = "stribeck",
    ageing: bool = True,
) -> list[MaterialFit]:
    """A fit for each material, in their order: a wide table has several.

    Parameters
    ----------
    materials : CSV or .xlsx files; or by name, points (slip speeds in m/s, friction coefficients) or a fit of them
    wanted : which columns to take, and in which units, where the headings do not say
    columns : CURVE_COLUMNS or AGEING_COLUMNS; None takes what each file has
    same : as for `join_repeats`
    law : of curves, as for `fit_curve`; repeats are fitted by the Stribeck curve
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
        return join_repeats([_named(name, points, law) for name, points in materials.items()], same)
    wanted = wanted or Wanted()
    rows: list[tuple[str, str, Path, Columns]] = []
    errors: list[ConfigError] = []
    for file, path in zip(names_of(materials), materials, strict=True):
        try:
            read = read_materials(path, columns or kind_of(path, wanted), wanted)
        except ConfigError as error:
            errors.append(error)
        else:
            rows += [(label, file, path, points) for label, points in read.items()]
    labels = Counter(label or file for label, file, *_ in rows)
    names = _numbered([f"{file}: {label}" if label and labels[label] > 1 else label or file
                       for label, file, *_ in rows])  # fmt: skip
    fits = []
    for name, (label, _, path, points) in zip(names, rows, strict=True):
        try:
            if "time" in points and not ageing:
                raise ConfigError.of(path, *NO_CURVE)
            fits.append(_fitted(name, path, label, points, law))
        except ConfigError as error:
            errors.append(error)
    if errors:
        raise ConfigError.of_files(errors)
    return join_repeats(fits, same)


def _named(name: str, points: tuple[ArrayLike, ArrayLike] | CurveFit, law: str) -> MaterialFit:
    """A material of points, or of a curve whose points nobody knows."""
    if isinstance(points, CurveFit):
        return MaterialFit(name, Path(name), Columns(), points)
    speed, mu = (np.asarray(values, np.float64) for values in points)
    try:
        return MaterialFit(name, Path(name), Columns({"speed": speed, "mu": mu}), fit_curve(speed, mu, law=law))
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def join_repeats(fits: Sequence[MaterialFit], same: Sequence[str]) -> list[MaterialFit]:
    """Materials of which some are repeats of one, joined to one each, in the place of the first, with a `RepeatedFit`
    through all points.

    same : patterns of names, such as ``"grease A*"`` (`fnmatch`, whatever the case), one for each material; it is
    called after its pattern, without the wildcards. Raises ConfigError if a pattern matches fewer than two, or one that
    another has; for ageing, and where `fit_repeats` does.
    """
    joined: dict[int, MaterialFit] = {}  # by the place of the first
    places: dict[int, int] = {}  # of each repeat, that of the first
    for pattern in dict.fromkeys(same):
        group = [i for i, fit in enumerate(fits) if fnmatchcase(fit.name.casefold(), pattern.casefold())]
        if len(group) < 2 or places.keys() & {*group}:
            matched = "a material of another pattern" if len(group) > 1 else ", ".join(fits[i].name for i in group)
            message = f"matches {matched or 'none'}, expected two or more of {', '.join(fit.name for fit in fits)}"
            raise ConfigError.of(f"same {pattern!r}", message)
        places |= dict.fromkeys(group, group[0])
        joined[group[0]] = _joined(pattern, [fits[i] for i in group])
    materials = [joined.get(i, fit) for i, fit in enumerate(fits) if places.get(i, i) == i]
    names = _numbered([fit.name for fit in materials])
    return [replace(fit, name=name) for fit, name in zip(materials, names, strict=True)]


def _joined(pattern: str, group: Sequence[MaterialFit]) -> MaterialFit:
    points, names = [fit.points for fit in group], [fit.name for fit in group]
    shared = [name for name in points[0] if all(name in columns for columns in points)]
    whole = Columns({name: np.concatenate([columns[name] for columns in points]) for name in shared})
    whole.assumed = next((columns.assumed for columns in points if columns.assumed), ())
    whole.units, whole.read = points[0].units, points[0].read
    whole.ignored = tuple(dict.fromkeys(text for columns in points for text in columns.ignored))
    try:
        if "speed" not in whole:
            raise ValueError("the repeats have no points of friction over speed, expected some of each")
        speeds, mus = ([columns[name] for columns in points] for name in ("speed", "mu"))
        ways = [columns["direction"] for columns in points] if "direction" in whole else None
        curve = fit_repeats(speeds, mus, names, unit=whole.units.get("speed", "m/s"), directions=ways)
    except ValueError as error:
        raise ConfigError.of(f"same {pattern!r}", str(error)) from None
    name = re.sub(r"[*?]|\[[^]]*\]", "", pattern).strip(" _-.:") or f"{names[0]} to {names[-1]}"
    return MaterialFit(name, group[0].path, whole, _cautious(curve, whole), repeats=tuple(group))


def _fitted(name: str, path: Path, label: str, points: Columns, law: str) -> MaterialFit:
    """The fit of the points of a material, called `label` in its file. Raises ConfigError."""
    try:
        if "time" in points:
            return MaterialFit(name, path, points, ageing=_cautious(fit_ageing(points["time"], points["mu"]), points))
        unit = points.units.get("speed") or "m/s"
        return MaterialFit(name, path, points, _cautious(fit_curve(**points, unit=unit, law=law), points))
    except ValueError as error:
        raise ConfigError.of(path, str(error), path=(label,) if label else ()) from None


def _cautious(fit: Fit, points: Columns) -> Fit:
    """The fit, with a word on units that were assumed."""
    caution = points.caution()
    return replace(fit, quality=f"{caution} {fit.quality}", good=False) if caution else fit


def names_of(paths: Sequence[Path]) -> list[str]:
    """A name for each file: its stem, with as many folders before it as tell it from the others."""
    depth = 1
    parts = [(*path.parts[:-1], path.stem) for path in paths]
    names = [whole[-1] for whole in parts]
    while len(set(names)) < len(names) and depth < max(map(len, parts)):
        depth += 1
        twice = {name for name, count in Counter(names).items() if count > 1}
        names = ["/".join(w[-depth:]) if name in twice else name for name, w in zip(names, parts, strict=True)]
    return _numbered(names)


def _numbered(names: Sequence[str]) -> list[str]:
    before = [names[:i].count(name) for i, name in enumerate(names)]
    return [f"{name} ({count + 1})" if count else name for name, count in zip(names, before, strict=True)]
