"""Curves fitted to the points of a file."""

from __future__ import annotations

from pathlib import Path

from stickslip.fit.curve import CurveFit, fit_curve
from stickslip.fit.points import CURVE_COLUMNS, read_points
from stickslip.problems import ConfigError, Problem


def fit_file(path: Path) -> CurveFit:
    """The curve through the points of a CSV file. Raises ConfigError."""
    points = read_points(path, CURVE_COLUMNS)
    try:
        return fit_curve(**points)
    except ValueError as error:
        raise ConfigError(str(path), [Problem((), str(error))]) from None
