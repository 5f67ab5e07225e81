"""The risk model fitted to measured pairs: features of a record, and the RPN that a rig maker's program gave it.

Penalised least squares: the level against the number, and each parameter against its default (ridge regression, or the
most probable parameters where those before any pair are normal about the defaults). A weight and the base have a prior
standard deviation of one level; a number has the 0.29 of rounding to whole ones, or what the residuals show if that is
more. Few pairs, or pairs whose features vary together, thus move the model only along what they determine. A number
at an end of the scale (1 or 10) says that the level is there or beyond, so levels beyond it are no misfit.

Its quality is that of predictions: each pair is left out in turn, and the others predict it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import log, sqrt

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares  # type: ignore[import-untyped]

from stickslip.vocabulary import units
from stickslip_materials.fit.uncertainty import Flags, Floats, Interval, rms, student
from stickslip_rig.risk import HIGHEST, INPUTS, LOWEST, RPN_NAME, Risk, band_of, decades, number_of
from stickslip_rig.vocabulary import RISK

LINEAR = ("base", *(f"weight_{name}" for name in INPUTS))
SCALES = tuple(f"scale_{name}" for name in INPUTS)
PRIOR_SD = 1.0  # before any pair; levels: of the base, and of a weight per decade
_PRIOR_SD_OF_SCALE = log(10.0)  # of the logarithm of a scale: a decade
ROUNDING_SD = 1.0 / sqrt(12.0)  # levels: a number is a level rounded
_WIDEST = 1e3  # times the scale at the start, and its inverse: how far a scale is looked for
_ROUNDS = 20  # of noise and fit in turn, at most; a few do
_DETERMINED = 0.5  # of the variance of the prior: what is left of it where the pairs say something of a parameter


@dataclass(frozen=True)
class Calibration:
    """A fitted risk model.

    risk : with the range of the features of the pairs. fitted : names of the parameters that were fitted; the others
    are as they were. interval : of the fitted ones, 95 %; without pairs it would be that of the prior, +- 1.96.
    unidentified : of those, the ones of which the pairs say little. noise : standard deviation of a number, levels.
    level, rpn : fitted and measured, pair by pair. left_out : the level of each pair from a fit to the others.
    default : its level without calibration. names : of the pairs. omitted : pairs without the features, and why.
    """

    risk: Risk
    fitted: tuple[str, ...]
    interval: Mapping[str, Interval]
    unidentified: tuple[str, ...]
    covariance: Floats
    noise: float
    level: Floats
    left_out: Floats
    default: Floats
    rpn: Floats
    names: tuple[str, ...] = ()
    omitted: tuple[str, ...] = ()

    @property
    def residuals(self) -> Floats:
        """Level minus number; zero where both lie at or beyond the same end of the scale."""
        return _misfit(self.level, self.rpn)

    @property
    def number(self) -> Floats:
        """The fitted number, pair by pair."""
        return number_of(self.level)

    @property
    def error(self) -> float:
        """Leave-one-out error: rms of level minus number, each pair predicted from the others."""
        return rms(_misfit(self.left_out, self.rpn))

    @property
    def default_error(self) -> float:
        """Error of the default model, which is not fitted."""
        return rms(_misfit(self.default, self.rpn))

    @property
    def is_better(self) -> bool:
        """True if the calibrated model predicts pairs it has not seen better than the default does."""
        return self.error < self.default_error

    def prediction(self) -> str:
        """The quality of predictions for pairs that the model has not seen, in words."""
        n = self.rpn.size
        text = f"leave-one-out error {self.error:.2g} levels rms, {self._bands(self.left_out)} of {n} in their band; "
        text += f"the default model: {self.default_error:.2g}, {self._bands(self.default)} of {n}"
        if self.is_better:
            return text
        return f"{text}\nThe calibrated model predicts no better than the default one: do not use it"

    def text(self) -> str:
        """The parameters as a section of a configuration, intervals as comments."""
        lines = [f"# {line}" for line in self.prediction().splitlines()]
        lines.append(f"risk:  # {RPN_NAME}; fitted to {self.rpn.size} pairs")
        for name, value in self.risk.resolved().items():
            unit, text = units.spelled(RISK[name].units), f"  {name}: {value:.6g}"
            lines.append(f"{text:44}# {unit + ', ' if unit else ''}{self._remark(name)}")
        return "\n".join(lines)

    def quality(self) -> str:
        """The quality of the fit, in words."""
        exact = int(np.sum(self.number == np.floor(self.rpn + 0.5)))
        near = int(np.sum(np.abs(self.number - self.rpn) <= 1.0))
        n = self.rpn.size
        text = f"{n} pairs: {exact} numbers reproduced, {near} within one, {self._bands(self.level)} in their band; "
        text += f"residual rms {rms(self.residuals):.2g} (rounding to whole numbers alone gives about 0.29)."
        if self.unidentified:
            names = ", ".join(self.unidentified)
            text += f"\nThe pairs do not determine {names}, which stay near their defaults: "
            text += "add pairs whose features vary independently."
        return text

    def _bands(self, level: Floats) -> int:
        """The number of pairs in their band."""
        numbers = zip(number_of(level).tolist(), number_of(self.rpn).tolist(), strict=True)
        return sum(band_of(a) == band_of(b) for a, b in numbers)

    def _remark(self, name: str) -> str:
        if name.startswith(("lowest_", "highest_")):
            return "of the pairs"
        if name not in self.fitted:
            return "as given"
        low, high = self.interval[name]
        return f"95 %: {low:.3g} to {high:.3g}" + ", not determined by the pairs" * (name in self.unidentified)


def calibrate(
    inputs: Mapping[str, ArrayLike], rpn: ArrayLike, start: Risk | None = None, scales: bool = False,
    names: Sequence[str] = (),
) -> Calibration:  # fmt: skip
    """Fit the risk model to measured numbers; it stays near the default one where they do not determine it.

    Parameters
    ----------
    inputs
        By names of `INPUTS`, in SI, one value for each pair.
    rpn
        The numbers, 1 to 10; means of repetitions need not be whole.
    start
        Its scales hold, or are those near which fitted ones stay.
    scales
        Whether the scales are fitted too; they need pairs over several decades.
    names
        Of the pairs.

    Raises
    ------
    ValueError
        Fewer pairs of different features than one more than parameters, or impossible numbers.
    """
    begin, measured = start or Risk(), np.atleast_1d(np.asarray(rpn, np.float64))
    columns = np.array([np.broadcast_to(np.asarray(inputs[name], np.float64), measured.shape) for name in INPUTS])
    fitted = (*LINEAR, *SCALES) if scales else LINEAR
    _check_pairs(columns, measured, len(fitted))
    ends = {f"lowest_{name}": float(column.min()) for name, column in zip(INPUTS, columns, strict=True)}
    ends |= {f"highest_{name}": float(column.max()) for name, column in zip(INPUTS, columns, strict=True)}
    fit = _Ridge(begin.model_copy(update=ends), fitted)
    best, covariance, noise, informative = fit.run(columns, measured)
    others = ~np.eye(measured.size, dtype=bool)
    left_out = [
        float(fit.level(fit.run(columns[:, rest], measured[rest], best, noise)[0], columns[:, ~rest])[0])
        for rest in others
    ]
    half = student(np.inf if noise == ROUNDING_SD else informative) * np.sqrt(np.diag(covariance))
    bounds = {name: fit.interval(i, best[i], half[i]) for i, name in enumerate(fitted)}
    blank = np.diag(covariance) > _DETERMINED * fit.spread**2
    return Calibration(
        fit.risk(best), fitted, bounds, tuple(n for n, b in zip(fitted, blank, strict=True) if b), covariance, noise,
        fit.level(best, columns), np.array(left_out), Risk().level(dict(zip(INPUTS, columns, strict=True))), measured,
        tuple(names) or tuple(str(i + 1) for i in range(measured.size)),
    )  # fmt: skip


# --- the fit ----------------------------------------------------------------------------------------------------------


class _Ridge:
    """Parameters in the order of `names`, scales by their logarithm, near those of the default model."""

    def __init__(self, begin: Risk, names: tuple[str, ...]) -> None:
        self._begin, self._names = begin, names
        self._is_scale = np.array([name in SCALES for name in names])
        of_default, reach = Risk(), log(_WIDEST)
        self._centre = np.array([log(getattr(begin, n)) if n in SCALES else getattr(of_default, n) for n in names])
        self.spread = np.where(self._is_scale, _PRIOR_SD_OF_SCALE, PRIOR_SD)
        lowest = np.array([-np.inf if name == "base" else 0.0 for name in names])
        self._low = np.where(self._is_scale, self._centre - reach, lowest)
        self._high = np.where(self._is_scale, self._centre + reach, np.inf)

    def risk(self, p: Floats) -> Risk:
        """The model of some parameters."""
        values = np.where(self._is_scale, np.exp(np.where(self._is_scale, p, 0.0)), p)
        model: Risk = self._begin.model_copy(update=dict(zip(self._names, values.tolist(), strict=True)))
        return model

    def level(self, p: Floats, columns: Floats) -> Floats:
        """The levels for features (inputs by pairs)."""
        return np.asarray(p[0] + p[1:4] @ decades(columns, self._scales(p)))

    def _slopes(self, p: Floats, columns: Floats) -> Floats:
        """Derivatives of the levels (pairs by parameters)."""
        scales = self._scales(p)
        slopes = [np.ones_like(columns[:1]), decades(columns, scales)]
        if self._is_scale.any():
            slopes.append(-p[1:4, None] * columns / (columns + scales) / log(10.0))
        return np.concatenate(slopes).T

    def _scales(self, p: Floats) -> Floats:
        scales = np.exp(p[4:]) if self._is_scale.any() else np.array(self._begin.scales)
        return np.asarray(scales)[:, None]

    def run(
        self, columns: Floats, rpn: Floats, begin: Floats | None = None, noise: float = ROUNDING_SD
    ) -> tuple[Floats, Floats, float, int]:
        """The most probable parameters, their covariance, the noise, and how many pairs are not beyond an end.

        begin, noise : where to begin.
        """
        best = self._centre if begin is None else begin
        for _ in range(_ROUNDS):

            def residuals(p: Floats, noise: float = noise) -> Floats:
                return np.append(_misfit(self.level(p, columns), rpn) / noise, (p - self._centre) / self.spread)

            def slopes(p: Floats, noise: float = noise) -> Floats:
                inside = ~_beyond(self.level(p, columns), rpn) / noise
                return np.append(self._slopes(p, columns) * inside[:, None], np.diag(1.0 / self.spread), axis=0)

            run = least_squares(residuals, best, slopes, (self._low, self._high), ftol=1e-12, xtol=1e-11, gtol=1e-11)
            best, of_pairs = run.x, run.jac[: rpn.size]
            covariance = np.linalg.inv(run.jac.T @ run.jac)  # the prior makes it regular
            informative = int(np.count_nonzero(of_pairs.any(axis=1)))
            freedom = max(informative - float(np.sum((of_pairs @ covariance) * of_pairs)), 1.0)
            misfit = _misfit(self.level(best, columns), rpn)
            before, noise = noise, max(ROUNDING_SD, float(np.sqrt(np.sum(misfit**2) / freedom)))
            if abs(noise - before) < 0.01 * before:
                break
        return best, covariance, noise, informative

    def interval(self, i: int, value: float, half: float) -> Interval:
        """An interval of a parameter; that of a weight begins at zero at the lowest."""
        ends = np.clip([value - half, value + half], self._low[i] if not self._is_scale[i] else -700.0, 700.0)
        low, high = np.exp(ends) if self._is_scale[i] else ends
        return float(low), float(high)


def _beyond(level: Floats, rpn: Floats) -> Flags:
    """True if both lie at or beyond the same end of the scale."""
    return ((rpn <= LOWEST) & (level < LOWEST)) | ((rpn >= HIGHEST) & (level > HIGHEST))


def _misfit(level: Floats, rpn: Floats) -> Floats:
    """Level minus number, zero where both lie at or beyond the same end."""
    return np.where(_beyond(level, rpn), 0.0, level - rpn)


def _check_pairs(columns: Floats, rpn: Floats, parameters: int) -> None:
    for name, values in zip(INPUTS, columns, strict=True):
        for i in np.flatnonzero(~(np.isfinite(values) & (values >= 0)))[:1]:
            raise ValueError(f"pair {i + 1}: got {name} = {values[i]:g}, expected a finite number >= 0")
    for i in np.flatnonzero(~((rpn >= LOWEST) & (rpn <= HIGHEST)))[:1]:
        raise ValueError(f"pair {i + 1}: got the RPN {rpn[i]:g}, expected {LOWEST} to {HIGHEST}")
    different = len(np.unique(columns, axis=1).T)
    if rpn.ndim != 1 or different <= parameters:
        of_them = f", {different} of different features," if different < rpn.size else ""
        raise ValueError(f"{rpn.size} pairs{of_them} for {parameters} parameters, expected at least {parameters + 1}")
