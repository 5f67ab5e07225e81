"""The risk model fitted to measured pairs: features of a record, and the RPN that a rig maker's program gave it.

Ridge regression: least squares of the level against the number, and of base and weights against their defaults, from
which they are expected one level away; weights are never negative. A number has the 0.29 of rounding to whole ones, or
what the residuals show if that is more. One at an end of the scale (1 or 10) says that the level is there or beyond:
levels beyond it are no misfit, so such pairs do not count. Its quality is that of predictions: each pair is left out in
turn, and the others predict it (in closed form).

Pairs in files are the tables that `rig features -o` writes, to which people add a column.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import nan, sqrt
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import lsq_linear  # type: ignore[import-untyped]

from stickslip.errors import ConfigError, Problem
from stickslip.files.tables import cells, read_table
from stickslip.vocabulary.quantities import listed
from stickslip_materials.fit.columns import HeadedTable, factor
from stickslip_materials.fit.headings import Heading
from stickslip_materials.fit.uncertainty import Flags, Floats, Interval, rms, student
from stickslip_materials.fit.words import plain
from stickslip_rig.defects import reason_of
from stickslip_rig.quantities import FEATURES, RPN_NAME
from stickslip_rig.risk import HIGHEST, INPUTS, LOWEST, Risk, decades

FITTED = ("base", *(f"weight_{name}" for name in INPUTS))
ROUNDING_SD = 1.0 / sqrt(12.0)  # levels: a number is a level rounded
RPN = "rpn"  # the column of measured numbers
_COLUMNS = {RPN, "model_rpn", "remarks", "record", *INPUTS, *(f"{name}_limited" for name in INPUTS)}
_EXAMPLE = "sticks, acceleration_max [m/s2], acceleration_integral [m/s], rpn"
_ROUNDS = 50  # of noise, of what counts, and of the fit in turn, at most; a few do
_DETERMINED = 0.5  # of the variance of the prior, 1: what is left of it where the pairs say something of a parameter


@dataclass(frozen=True)
class Calibration:
    """A fitted risk model.

    interval : of base and weights, 95 %. unidentified : those of which the pairs say little. noise : of a number,
    levels. level, rpn : fitted and measured, pair by pair. left_out : the level of each pair from a fit to the others.
    default : its level without calibration. names : of the pairs. omitted : pairs without the features, and why.
    """

    risk: Risk
    interval: Mapping[str, Interval]
    unidentified: tuple[str, ...]
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
        errors = f"leave-one-out error {self.error:.2g} levels rms, that of the default model {self.default_error:.2g}"
        return f"{self.rpn.size} pairs: {errors}{'' if self.is_better else ', which is no worse: do not use this one'}"

    def text(self) -> str:
        """The parameters as a section of a configuration, intervals as comments."""
        lines = [f"# {self.prediction()}", f"risk:  # {RPN_NAME}"]
        for name, value in self.risk.resolved().items():
            low, high = self.interval.get(name, (nan, nan))
            unsure = ", not determined by the pairs" * (name in self.unidentified)
            remark = f"  # 95 %: {low:.3g} to {high:.3g}{unsure}" if name in self.interval else ""
            lines.append(f"  {name}: {value:.6g}{remark}")
        return "\n".join(lines)


def calibrate(
    inputs: Mapping[str, ArrayLike], rpn: ArrayLike, start: Risk | None = None, names: Sequence[str] = ()
) -> Calibration:
    """Fit base and weights of the risk model to measured numbers; they stay near their defaults where pairs say little.

    Parameters
    ----------
    inputs
        By names of `INPUTS`, in SI, one value for each pair.
    rpn
        The numbers, 1 to 10; means of repetitions need not be whole.
    start
        Its scales hold.
    names
        Of the pairs.

    Raises
    ------
    ValueError
        Fewer pairs of different features than one more than parameters, or impossible numbers.
    """
    begin, measured = start or Risk(), np.atleast_1d(np.asarray(rpn, np.float64))
    columns = np.array([np.broadcast_to(np.asarray(inputs[name], np.float64), measured.shape) for name in INPUTS])
    _check_pairs(columns, measured)
    terms = np.vstack([np.ones(measured.size), decades(columns, np.array(begin.scales)[:, None])]).T
    best, noise, counts = _fit(terms, measured)
    rows, level, is_base = terms[counts] / noise, terms @ best, np.arange(best.size) == 0
    precision = rows.T @ rows + np.eye(best.size)  # the prior makes it regular
    covariance, free = np.linalg.inv(precision), is_base | (best > 1e-9)  # a weight at zero stays there without a pair
    moving = terms[:, free] / noise
    own = np.sum(moving * np.linalg.solve(precision[np.ix_(free, free)], moving.T).T, axis=1)  # a number in its level
    half = student(np.inf if noise == ROUNDING_SD else int(counts.sum())) * np.sqrt(np.diag(covariance))
    low = np.where(is_base, best - half, np.maximum(best - half, 0.0))
    fitted = dict(zip(FITTED, best.tolist(), strict=True))
    return Calibration(
        risk=begin.model_copy(update=fitted),
        interval=dict(zip(FITTED, zip(low.tolist(), (best + half).tolist(), strict=True), strict=True)),
        unidentified=tuple(np.array(FITTED)[np.diag(covariance) > _DETERMINED].tolist()),
        noise=noise,
        level=level,
        left_out=np.where(counts, measured - (measured - level) / (1.0 - own), level),
        default=Risk().level(dict(zip(INPUTS, columns, strict=True))),
        rpn=measured,
        names=tuple(names) or tuple(str(i + 1) for i in range(measured.size)),
    )


def _fit(terms: Floats, rpn: Floats) -> tuple[Floats, float, Flags]:
    """Base and weights for the terms of the levels (pairs, parameters), the noise, and which pairs count."""
    default, noise, counts = np.array([getattr(Risk(), name) for name in FITTED]), ROUNDING_SD, np.ones(rpn.size, bool)
    lowest = np.array([-np.inf, 0.0, 0.0, 0.0])
    for _ in range(_ROUNDS):
        rows = np.vstack([terms[counts] / noise, np.eye(default.size)])
        best = lsq_linear(rows, np.append(rpn[counts] / noise, default), (lowest, np.inf), tol=1e-12).x
        before, counts_before, level = noise, counts, terms @ best
        counts = ~_beyond(level, rpn)
        used = terms[counts] / noise
        share = np.trace(np.linalg.solve(used.T @ used + np.eye(default.size), used.T @ used))
        spread = sqrt(float(np.sum(_misfit(level, rpn) ** 2)) / max(float(counts.sum() - share), 1.0))
        noise = max(ROUNDING_SD, spread)
        if abs(noise - before) < 1e-6 * before and (counts == counts_before).all():
            break
    return best, noise, counts


def _beyond(level: Floats, rpn: Floats) -> Flags:
    """True if both lie at or beyond the same end of the scale."""
    return ((rpn <= LOWEST) & (level < LOWEST)) | ((rpn >= HIGHEST) & (level > HIGHEST))


def _misfit(level: Floats, rpn: Floats) -> Floats:
    """Level minus number, zero where both lie at or beyond the same end."""
    return np.where(_beyond(level, rpn), 0.0, level - rpn)


def _check_pairs(columns: Floats, rpn: Floats) -> None:
    for name, values in zip(INPUTS, columns, strict=True):
        for i in np.flatnonzero(~(np.isfinite(values) & (values >= 0)))[:1]:
            raise ValueError(f"pair {i + 1}: got {name} = {values[i]:g}, expected a finite number >= 0")
    for i in np.flatnonzero(~((rpn >= LOWEST) & (rpn <= HIGHEST)))[:1]:
        raise ValueError(f"pair {i + 1}: got the RPN {rpn[i]:g}, expected {LOWEST} to {HIGHEST}")
    different, parameters = len(np.unique(columns, axis=1).T), len(FITTED)
    if rpn.ndim != 1 or different <= parameters:
        of_them = f", {different} of different features," if different < rpn.size else ""
        raise ValueError(f"{rpn.size} pairs{of_them} for {parameters} parameters, expected at least {parameters + 1}")


# --- pairs in files ---------------------------------------------------------------------------------------------------


def calibrate_file(path: Path, start: Risk | None = None) -> Calibration:
    """Fit the risk model to the pairs of a table: CSV or Excel.

    Its column `rpn` holds the measured numbers; a row without one is left out. The features are columns named as in
    `FEATURES` with their units, as `rig features -o` writes them; the band-limited ones where there are any. Records of
    which a feature is not determined are left out, and named in `omitted`. start : its scales hold. Raises ConfigError.
    """
    headed = HeadedTable(read_table(path, _EXAMPLE, "pairs"), ())
    columns, rows = _columns(headed), list(cells(headed.table))
    whole = [row if len(row) == len(headed.headings) else None for row in rows]  # others are refused as they are read

    def text(i: int, name: str, default: str = "") -> str:
        row = whole[i]
        return row[columns[name][0]].text if row and name in columns else default

    names = {name: f"{name}_limited" if any(text(i, f"{name}_limited") for i in range(len(rows))) else name
             for name in INPUTS} | {RPN: RPN}  # fmt: skip
    used, omitted = [], []
    for i in range(len(rows)):
        if not whole[i] or all(text(i, name) for name in names.values()):
            used.append(i)
        elif text(i, RPN):
            reason = reason_of(text(i, "remarks")) or "a feature is empty"
            omitted.append(f"{text(i, 'record', f'row {i + 1}')} ({reason})")
    headed.table = replace(headed.table, lines=tuple(headed.table.lines[i] for i in used))
    hint = f"left out: {'; '.join(omitted)}" if omitted else None
    if not used:
        raise ConfigError(headed.table.name, [Problem((RPN,), "no row has a number and features", hint=hint)])
    numbers = headed.values({name: columns[column] for name, column in names.items()})
    for name, values in numbers.items():
        low, high = (LOWEST, HIGHEST) if name == RPN else (0.0, np.inf)
        for i in np.flatnonzero(~((values >= low) & (values <= high)))[:1].tolist():
            bounds, cell = f">= {low:g}" if np.isinf(high) else f"from {low:g} to {high:g}", rows[used[i]]
            at = cell[columns[names[name]][0]]
            raise ConfigError.of(headed.table.name, f"got {at.text}, expected a number {bounds}", place=at.place)
    pairs = [text(i, "record", f"row {i + 1}") for i in used]
    try:
        return replace(calibrate(numbers, numbers[RPN], start, pairs), omitted=tuple(omitted))
    except ValueError as error:
        raise ConfigError(str(path), [Problem((), str(error), hint=hint)]) from None


def _columns(headed: HeadedTable) -> Mapping[str, tuple[int, float]]:
    """Position and factor to SI of the columns by name. Raises ConfigError, also if one is missing."""

    def name_of(column: Heading) -> str | None:
        name = plain(column.name).replace(" ", "_")
        return name if name in _COLUMNS else None

    def factor_of(name: str, column: Heading) -> float:
        return factor(name, column.unit, FEATURES[name].units) if name in FEATURES else 1.0

    columns = headed.find(name_of, factor_of, "remove one of the two columns")
    if lacking := [name for name in (RPN, *INPUTS) if name not in columns]:
        hint = "model_rpn is computed by this program: put the measured numbers beside it, in a column rpn"
        raise headed.error(f"no column is called {listed(lacking, 'and')}", hint if RPN in lacking else None)
    return columns
