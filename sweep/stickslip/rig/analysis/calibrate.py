"""The risk model fitted to measured pairs: features of a record, and the RPN that a rig maker's program gave it.

Least squares of the level against the number. A number at an end of the scale (1 or 10) only says that the level is
there or beyond, so levels beyond it are no misfit. With fixed scales the sum of squares is convex in the base and the
weights: the optimum is unique, and found from any start.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares  # type: ignore[import-untyped]

from stickslip.errors import ConfigError, Problem
from stickslip.fit.points import read_points
from stickslip.fit.uncertainty import Floats, Interval, covariance, rms, student
from stickslip.rig.quantities import FEATURES
from stickslip.rig.risk import HIGHEST, INPUTS, LOWEST, RPN_NAME, Risk, band_of, number_of
from stickslip.vocabulary import units
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.settings import RISK

RPN = "rpn"
COLUMNS = (
    *(Parameter(name, FEATURES[name].units, FEATURES[name].long_name, "pairs", at_least=0) for name in INPUTS),
    Parameter(RPN, "1", "risk priority number, 1 to 10", "pairs", at_least=LOWEST),
)
LINEAR = ("base", *(f"weight_{name}" for name in INPUTS))
SCALES = tuple(f"scale_{name}" for name in INPUTS)
_WIDEST = 1e3  # times the scale at the start, and its inverse: how far a scale is looked for
_ZERO = 1e-9  # a weight below is at its bound


@dataclass(frozen=True)
class Calibration:
    """A fitted risk model.

    fitted : names of the parameters that were fitted; the others are as they were. interval : of the fitted ones, 95 %,
    infinite where the pairs do not determine a parameter. level, rpn : fitted and measured, pair by pair.
    """

    risk: Risk
    fitted: tuple[str, ...]
    interval: Mapping[str, Interval]
    covariance: Floats
    level: Floats
    rpn: Floats

    @property
    def residuals(self) -> Floats:
        """Level minus number; zero where both lie at or beyond the same end of the scale."""
        return _misfit(self.level, self.rpn)

    @property
    def number(self) -> Floats:
        """The fitted number, pair by pair."""
        return number_of(self.level).astype(np.float64)

    @property
    def unidentified(self) -> tuple[str, ...]:
        """Parameters that the pairs do not determine: their interval is infinite, or a weight might as well be zero."""
        return tuple(name for name in self.fitted if self._is_open(name))

    def _is_open(self, name: str) -> bool:
        low, high = self.interval[name]
        return not (np.isfinite(low) and np.isfinite(high)) or (name.startswith("weight_") and low <= 0.0)

    def text(self) -> str:
        """The parameters as a section of a configuration, intervals as comments."""
        lines = [f"risk:  # {RPN_NAME}; fitted to {self.rpn.size} pairs"]
        for name, value in asdict(self.risk).items():
            unit = units.spelled(RISK[name].units)
            said = f"  {name}: {value:.6g}"
            remark = "as given" if name not in self.fitted else _interval_text(self.interval[name])
            lines.append(f"{said:44}# {unit + ', ' if unit else ''}{remark}")
        return "\n".join(lines)

    def quality(self) -> str:
        """The quality of the fit, in words."""
        exact = int(np.sum(self.number == np.floor(self.rpn + 0.5)))
        near = int(np.sum(np.abs(self.number - self.rpn) <= 1.0))
        bands = sum(band_of(int(a)) == band_of(int(b + 0.5)) for a, b in zip(self.number, self.rpn, strict=True))
        n = self.rpn.size
        said = f"{n} pairs: {exact} numbers reproduced, {near} within one, {bands} in their band; residual rms "
        said += f"{rms(self.residuals):.2g} (rounding to whole numbers alone gives about 0.29)."
        if self.unidentified:
            names = ", ".join(self.unidentified)
            said += f"\nThe pairs do not determine {names}: add pairs whose features vary independently."
        return said


def calibrate(
    inputs: Mapping[str, ArrayLike], rpn: ArrayLike, start: Risk | None = None, scales: bool = False
) -> Calibration:
    """The risk model that fits measured numbers best.

    inputs : by names of `INPUTS`, in SI, one value for each pair. rpn : the numbers, 1 to 10; means of repetitions need
    not be whole. start : what holds for everything that is not fitted, and where the fit begins. scales : whether the
    scales are fitted too; they need pairs over several decades. Raises ValueError.
    """
    begin = start or Risk()
    measured = np.atleast_1d(np.asarray(rpn, np.float64))
    features = np.array([np.broadcast_to(np.asarray(inputs[name], np.float64), measured.shape) for name in INPUTS])
    names = (*LINEAR, *SCALES) if scales else LINEAR
    _check(features, measured, len(names))
    free = np.array([_outward(name, getattr(begin, name)) for name in names])
    low = np.array([-np.inf if n == "base" else 0.0 if n in LINEAR else _outward(n, getattr(begin, n) / _WIDEST)
                    for n in names])  # fmt: skip
    high = np.array([np.inf if n in LINEAR else _outward(n, getattr(begin, n) * _WIDEST) for n in names])

    def model(p: Floats) -> Risk:
        found = {name: float(_inward(name, value)) for name, value in zip(names, p, strict=True)}
        return Risk(**(asdict(begin) | found))

    def level(p: Floats) -> Floats:
        return model(p).level(dict(zip(INPUTS, features, strict=True)))

    run = least_squares(
        lambda p: _misfit(level(p), measured), free, bounds=(low, high), ftol=1e-13, xtol=1e-12, gtol=1e-12
    )
    best = np.array([0.0 if n.startswith("weight_") and v < _ZERO else v for n, v in zip(names, run.x, strict=True)])
    spread = rms(_misfit(level(best), measured)) ** 2 * measured.size
    freedom = _freedom(level(best), measured, len(names))
    found = covariance(run.jac) * (spread / freedom if freedom > 0 else np.inf)
    reach = student(freedom) * np.sqrt(np.diag(found))
    interval = {
        name: (float(_inward(name, value - half)), float(_inward(name, value + half)))
        for name, value, half in zip(names, best, reach, strict=True)
    }
    return Calibration(model(best), names, interval, found, level(best), measured)


def calibrate_file(path: Path, start: Risk | None = None, scales: bool = False) -> Calibration:
    """The risk model fitted to the pairs of a CSV file, columns as `COLUMNS`. Raises ConfigError."""
    points = read_points(path, COLUMNS)
    try:
        return calibrate({name: points[name] for name in INPUTS}, points[RPN], start, scales)
    except ValueError as error:
        raise ConfigError(str(path), [Problem((), str(error))]) from None


def _misfit(level: Floats, rpn: Floats) -> Floats:
    """Level minus number, zero where both lie at or beyond the same end."""
    beyond = ((rpn <= LOWEST) & (level < LOWEST)) | ((rpn >= HIGHEST) & (level > HIGHEST))
    return np.where(beyond, 0.0, level - rpn)


def _freedom(level: Floats, rpn: Floats, parameters: int) -> int:
    """Degrees of freedom: informative pairs minus parameters."""
    beyond = ((rpn <= LOWEST) & (level < LOWEST)) | ((rpn >= HIGHEST) & (level > HIGHEST))
    return int(np.sum(~beyond)) - parameters


def _outward(name: str, value: float) -> float:
    """A parameter as it is fitted: scales by their logarithm."""
    return float(np.log(value)) if name in SCALES else value


def _inward(name: str, value: float) -> float:
    return float(np.exp(np.minimum(value, 700.0))) if name in SCALES else value


def _check(features: Floats, rpn: Floats, parameters: int) -> None:
    if rpn.ndim != 1 or rpn.size <= parameters:
        raise ValueError(f"{rpn.size} pairs for {parameters} parameters, expected at least {parameters + 1}")
    for name, values in zip(INPUTS, features, strict=True):
        if not (np.isfinite(values) & (values >= 0)).all():
            raise ValueError(f"{name}: expected finite numbers >= 0")
    wrong = ~((rpn >= LOWEST) & (rpn <= HIGHEST))
    if wrong.any():
        i = int(np.argmax(wrong))
        raise ValueError(f"pair {i + 1}: got the RPN {rpn[i]:g}, expected {LOWEST} to {HIGHEST}")


def _interval_text(interval: Interval) -> str:
    low, high = interval
    if not (np.isfinite(low) and np.isfinite(high)):
        return "not determined by the pairs"
    return f"95 %: {low:.3g} to {high:.3g}"
