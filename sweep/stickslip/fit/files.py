"""Curves and ageing fitted to the points of a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from stickslip.errors import ConfigError, Problem
from stickslip.fit.ageing import AgeingFit, fit_ageing
from stickslip.fit.curve import CurveFit, fit_curve
from stickslip.fit.points import Columns, read_points
from stickslip.vocabulary.settings import AGEING_COLUMNS, CURVE_COLUMNS

AnyFit = TypeVar("AnyFit", CurveFit, AgeingFit)


def fit_file(path: Path, unit: str | None = None) -> CurveFit:
    """The curve through the points of a CSV file.

    unit : of the speeds, where the header names none. Without it they are read in m/s, which the quality of the fit
        says, and it is not called good. Raises ConfigError.
    """
    points = read_points(path, CURVE_COLUMNS, unit)
    try:
        return _cautious(fit_curve(**points), points)
    except ValueError as error:
        raise ConfigError(str(path), [Problem((), str(error))]) from None


def fit_ageing_file(path: Path, unit: str | None = None) -> AgeingFit:
    """Ageing from the waiting times and friction coefficients of a CSV file; `unit` is that of the times, as above."""
    points = read_points(path, AGEING_COLUMNS, unit)
    try:
        return _cautious(fit_ageing(points["time"], points["mu"]), points)
    except ValueError as error:
        raise ConfigError(str(path), [Problem((), str(error))]) from None


def _cautious(fit: AnyFit, points: Columns) -> AnyFit:
    """The fit, with a word on units that were assumed."""
    caution = points.caution()
    return replace(fit, quality=f"{caution} {fit.quality}", good=False) if caution else fit
