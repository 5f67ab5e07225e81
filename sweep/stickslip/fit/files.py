"""Curves and ageing fitted to the points of files, which may hold one material or several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from stickslip.errors import ConfigError, Problem
from stickslip.fit.ageing import AgeingFit, fit_ageing
from stickslip.fit.curve import CurveFit, fit_curve
from stickslip.fit.names import names_of, numbered
from stickslip.fit.points import Columns, kind_of, only, read_materials
from stickslip.fit.roles import Wanted
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.settings import AGEING_COLUMNS, CURVE_COLUMNS

AnyFit = TypeVar("AnyFit", CurveFit, AgeingFit)


@dataclass(frozen=True)
class MaterialFit:
    """What the points of one material say: a curve, or ageing.

    name : no other material read with it has the same. path : the file they come from.
    """

    name: str
    path: Path
    points: Columns = field(repr=False)
    curve: CurveFit | None = None
    ageing: AgeingFit | None = None


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
    paths: Sequence[Path], wanted: Wanted | None = None, columns: Sequence[Parameter] | None = None
) -> list[MaterialFit]:
    """A fit for each material of some files, in their order: a wide table has several.

    columns : CURVE_COLUMNS or AGEING_COLUMNS; None takes what each file has. Materials are named by their columns in
    tables of several, else by their files. Raises ConfigError.
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
    return [
        MaterialFit(name, path, points, ageing=_ageing(path, label, points))
        if kind is AGEING_COLUMNS
        else MaterialFit(name, path, points, _curve(path, label, points))
        for name, (label, _, path, points, kind) in zip(names, found, strict=True)
    ]


def _curve(path: Path, label: str, points: Columns) -> CurveFit:
    try:
        return _cautious(fit_curve(**points, unit=points.units.get("speed") or "m/s"), points)
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
