"""Curves and ageing fitted to the points of files, which may hold one material or several."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TypeVar

import numpy as np

from stickslip.errors import ConfigError, Problem
from stickslip.fit.ageing import AgeingFit, fit_ageing
from stickslip.fit.curve import CurveFit, fit_curve
from stickslip.fit.names import names_of, numbered
from stickslip.fit.points import Columns, kind_of, only, read_materials
from stickslip.fit.repeats import fit_repeats
from stickslip.fit.roles import Wanted
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.settings import AGEING_COLUMNS, CURVE_COLUMNS

AnyFit = TypeVar("AnyFit", CurveFit, AgeingFit)


@dataclass(frozen=True)
class MaterialFit:
    """What the points of one material say: a curve, or ageing.

    name : no other material read with it has the same. path : the file they come from. repeats : what each repeat
    says, of a material that was measured several times; its points are those of all.
    """

    name: str
    path: Path
    points: Columns = field(repr=False)
    curve: CurveFit | None = None
    ageing: AgeingFit | None = None
    repeats: tuple[MaterialFit, ...] = field(default=(), repr=False)


def fit_file(path: Path, unit: str | None = None, wanted: Wanted | None = None) -> CurveFit:
    """The curve through the points of a CSV file.

    unit : of the speeds, where the header names none. Without it they are read in m/s, which the quality of the fit
        says, and it is not called good. wanted : the same, and which columns to take.
    Raises ConfigError, also for a table of several materials.
    """
    points = only(path, read_materials(path, CURVE_COLUMNS, wanted or Wanted(unit or "")))
    return _curve(path, "", points)


def fit_ageing_file(path: Path, unit: str | None = None) -> AgeingFit:
    """Ageing from the waiting times and friction coefficients of a CSV file; `unit` is that of the times, as above."""
    return _ageing(path, "", only(path, read_materials(path, AGEING_COLUMNS, Wanted(unit or ""))))


def fit_materials(
    paths: Sequence[Path],
    wanted: Wanted | None = None,
    columns: Sequence[Parameter] | None = None,
    same: Sequence[str] = (),
    law: str = "stribeck",
) -> list[MaterialFit]:
    """A fit for each material of some files, in their order: a wide table has several.

    columns : CURVE_COLUMNS or AGEING_COLUMNS; None takes what each file has. Materials are named by their columns in
    tables of several, else by their files. same : as for `join_repeats`. law : of curves, as for
    `fit_curve`; repeats are fitted by the Stribeck curve. Raises ConfigError.
    """
    wanted = wanted or Wanted()
    found: list[tuple[str, str, Path, Columns, Sequence[Parameter]]] = []
    for file, path in zip(names_of(paths), paths, strict=True):
        kind = columns or kind_of(path, wanted)
        found += [(label, file, path, points, kind) for label, points in read_materials(path, kind, wanted).items()]
    labels = [label or file for label, file, *_ in found]
    names = numbered(
        [
            f"{file}: {label}" if label and labels.count(label) > 1 else label or file
            for label, file, *_ in found
        ]
    )  # fmt: skip
    fits = [
        MaterialFit(name, path, points, ageing=_ageing(path, label, points))
        if kind is AGEING_COLUMNS
        else MaterialFit(name, path, points, _curve(path, label, points, law))
        for name, (label, _, path, points, kind) in zip(names, found, strict=True)
    ]
    return join_repeats(fits, same)


def join_repeats(fits: Sequence[MaterialFit], same: Sequence[str]) -> list[MaterialFit]:
    """Materials of which some are repeats of one, joined to one each, in the place of the first.

    Parameters
    ----------
    fits : of curves; two repeats at least for each pattern
    same : patterns of names, such as ``"grease A*"`` (`fnmatch`, whatever the case), one for each material; it is
        called after its pattern, without the wildcards

    Returns
    -------
    list of MaterialFit
        Those of repeats with a `RepeatedFit` through all points.

    Raises
    ------
    ConfigError
        If a pattern matches fewer than two, or one that another has; for ageing, and where `fit_repeats` does.
    """
    places = [next((p for p in same if fnmatchcase(one.name.casefold(), p.casefold())), None) for one in fits]
    joined: dict[str, MaterialFit] = {}
    for pattern in dict.fromkeys(same):
        group = [one for one in fits if fnmatchcase(one.name.casefold(), pattern.casefold())]
        if len(group) < 2 or [places[fits.index(one)] for one in group] != [pattern] * len(group):
            what = "a material of another pattern" if len(group) > 1 else ", ".join(one.name for one in group) or "none"
            message = f"matches {what}, expected two or more of {', '.join(one.name for one in fits)}"
            raise ConfigError(f"same {pattern!r}", [Problem((), message)])
        joined[pattern] = _joined(pattern, group)
    rest = [joined.pop(place, None) if place else one for one, place in zip(fits, places, strict=True)]
    found = [one for one in rest if one is not None]
    return [replace(one, name=name) for one, name in zip(found, numbered([one.name for one in found]), strict=True)]


def _joined(pattern: str, group: Sequence[MaterialFit]) -> MaterialFit:
    """Repeats as one material. Raises ConfigError."""
    points, names = [one.points for one in group], [one.name for one in group]
    if any("speed" not in one for one in points):
        message = "the repeats have no points of friction over speed, expected some of each"
        raise ConfigError(f"same {pattern!r}", [Problem((), message)])
    columns = [name for name in points[0] if all(name in one for one in points)]
    whole = Columns({name: np.concatenate([one[name] for one in points]) for name in columns})
    whole.assumed = next((one.assumed for one in points if one.assumed), ())
    whole.units, whole.read = points[0].units, points[0].read
    whole.ignored = tuple(dict.fromkeys(text for one in points for text in one.ignored))
    try:
        curve = fit_repeats(
            [one["speed"] for one in points], [one["mu"] for one in points], names, unit=whole.units.get("speed", "m/s")
        )
    except ValueError as error:
        raise ConfigError(f"same {pattern!r}", [Problem((), str(error))]) from None
    name = re.sub(r"[*?]|\[[^]]*\]", "", pattern).strip(" _-.:") or f"{names[0]} to {names[-1]}"
    return MaterialFit(name, group[0].path, whole, _cautious(curve, whole), repeats=tuple(group))


def _curve(path: Path, label: str, points: Columns, law: str = "stribeck") -> CurveFit:
    try:
        return _cautious(fit_curve(**points, unit=points.units.get("speed") or "m/s", law=law), points)
    except ValueError as error:
        raise _refused(path, label, error) from None


def _ageing(path: Path, label: str, points: Columns) -> AgeingFit:
    try:
        return _cautious(fit_ageing(points["time"], points["mu"]), points)
    except ValueError as error:
        raise _refused(path, label, error) from None


def _refused(path: Path, label: str, error: ValueError) -> ConfigError:
    return ConfigError(str(path), [Problem((label,) if label else (), str(error))])


def _cautious(fit: AnyFit, points: Columns) -> AnyFit:
    """The fit, with a word on units that were assumed."""
    caution = points.caution()
    return replace(fit, quality=f"{caution} {fit.quality}", good=False) if caution else fit
