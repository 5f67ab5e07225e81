"""Materials compared in one system: `stickslip.compare`."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from stickslip.borders import Limits, Scan
from stickslip.config.examples import found_points
from stickslip.config.forgotten_units import question as question_about
from stickslip.config.reader import make_config
from stickslip.config.yaml import Document
from stickslip.dataset.materials import Material, material_dataset
from stickslip.dataset.provenance import provenance
from stickslip.engine import Options, compute
from stickslip.errors import ConfigError, Problem, QuantityError, UnitWarning
from stickslip.fit import CurveFit, MaterialFit, Wanted, draw_curves, fit_curve, fit_materials, join_repeats
from stickslip.fit.points import Columns
from stickslip.materials.quiet import QUIET, UNRESOLVED, VIBRATES, Quiet, quiet_above
from stickslip.theory import loss_of_stability, reversal_speed, stick_slip_limit, tendency
from stickslip.vocabulary.cells import as_cells
from stickslip.vocabulary.flags import VIBRATING
from stickslip.vocabulary.quantities import PARAMETERS

Floats = NDArray[np.float64]
Points = tuple[ArrayLike, ArrayLike] | CurveFit
Asked = str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | Mapping[str, Points] | Sequence[MaterialFit]

_COEFFICIENTS = ("a1", "a2", "a3", "a4")
_SLOWER, _FASTER = 10.0, 4.0  # how far beyond what is measured, and what linear theory says, speeds are searched
_DRAWN_TO = 1e-3  # tolerance of the borders of drawn curves, which scatter by far more
_DRAWN_STEPS = 20_000  # of a cell of a drawn curve; without a verdict by then it widens the interval


@dataclass(frozen=True)
class Question:
    """What is asked of every material.

    system : by names of PARAMETERS, in SI. belt_speed : m/s, or None. between : speeds searched, None for a range about
    the measured ones. level : of confidence. draws : curves drawn per material, 0 for no intervals.
    """

    system: Mapping[str, float]
    belt_speed: float | None
    between: tuple[float, float] | None
    level: float
    draws: int
    seed: int
    limits: Limits
    options: Options


def compare(
    materials: Asked,
    *,
    mass: float | str,
    stiffness: float | str,
    normal_load: float | str,
    damping: float | str | None = None,
    belt_speed: float | str | None = None,
    between: tuple[float | str, float | str] | None = None,
    unit: str | None = None,
    columns: Wanted | None = None,
    same: str | Sequence[str] = (),
    level: float = 0.95,
    draws: int = 1000,
    seed: int = 1,
    tolerance: float = 1e-9,
    scan: int = 64,
    threads: int | None = None,
) -> xr.Dataset:
    """Which material keeps a contact quiet, from measured friction over slip speed.

    materials : CSV files of points, each of one material or of several (`stickslip fit` reads the same); or by name,
        points (slip speeds in m/s, friction coefficients) or a `fit.CurveFit`; or fits of `fit.fit_materials`.
    mass, stiffness, normal_load, damping : of the system, numbers in SI or texts with a unit ("5 N/mm"). No damping is
        taken as 0, which the attribute `damping_assumed` says; a damper lowers the borders.
    belt_speed : at which regime, margin and probability of being quiet are told; without it they are left out, and the
        tendency is that at the slowest speed searched.
    between : belt speeds searched; None takes a tenth of the slowest measured speed to four times the fastest, or to
        four times where theory sees the end of vibration, if that is more.
    unit : of speeds whose heading names none. columns : which columns of the files to take, where headings do not say.
    same : patterns of names ("grease A*") of repeats of one material each: one row, whose interval holds what differs
        between them (`fit.fit_repeats`); the variables `repeats` and `repeat_names` tell how many there are, and which.
    level : of the confidence intervals. draws : curves drawn per material from what its fit leaves open, of which the
        intervals are quantiles; 0 leaves intervals out. seed : of the draws.
    tolerance, scan : of the search of borders, as for `border`. threads : None for all.

    Returns a dataset over `material`, best first: quiet_above and the interval quiet_above_low to quiet_above_high,
    what kind of number it is (quiet_state), the coefficients, and over `slip_speed` the curves with their 95 % bands,
    over `point` what was measured. Raises ConfigError for files that will not do, TypeError or ValueError for other
    wrong input.
    """
    fits = _fits(materials, replace(columns or Wanted(), unit=unit or (columns.unit if columns else "")))
    fits = join_repeats(fits, [same] if isinstance(same, str) else same)
    given = {"mass": mass, "stiffness": stiffness, "normal_load": normal_load,
             "damping": 0.0 if damping is None else damping}  # fmt: skip
    if belt_speed is not None:
        given["belt_speed"] = belt_speed
    if not 0 < level < 1:
        raise ValueError(f"level: got {level!r}, expected a share above 0 and below 1, such as 0.95")
    if isinstance(draws, bool) or not isinstance(draws, int) or draws < 0:
        raise ValueError(f"draws: got {draws!r}, expected a whole number of at least 0")
    limits = Limits(scan, tolerance)
    ends = None if between is None else tuple(_quantity("belt_speed", end, "between") for end in between)
    question = Question(
        {name: _quantity(name, value) for name, value in given.items() if name != "belt_speed"},
        None if belt_speed is None else _quantity("belt_speed", belt_speed),
        None if ends is None else (ends[0], ends[1]),
        level, draws, seed, limits, Options(rtol=limits.rtol(), threads=threads),
    )  # fmt: skip
    if question.belt_speed is not None and not question.belt_speed > 0:
        raise ValueError(f"belt_speed: got {question.belt_speed:g}, expected a speed above 0 m/s")
    if asked := _doubts(fits, given):
        warnings.warn(asked, UnitWarning, stacklevel=2)
    ds = compare_fits(fits, question)
    written = {f"written_{name}": value for name, value in given.items() if isinstance(value, str)}
    return ds.assign_attrs(written | ({"damping_assumed": 1} if damping is None else {}))


def compare_fits(fits: Sequence[MaterialFit], question: Question) -> xr.Dataset:
    """The same of fitted curves; see `compare`."""
    scan = _scan(fits, question)
    curves = [one.curve for one in fits if one.curve is not None]
    best = {name: np.array([getattr(curve, name) for curve in curves]) for name in _COEFFICIENTS}
    found = quiet_above(best, question.system, scan, question.limits.tolerance, question.options)
    speed = scan.low if question.belt_speed is None else question.belt_speed
    cells = as_cells({**question.system, **best, "belt_speed": speed})
    motion = compute(lambda start, stop: {name: v[start:stop] for name, v in cells.items()}, len(fits),
                     question.options).results  # fmt: skip
    drawn = [_drawn(curve, question, scan) for curve in curves]
    order = sorted(range(len(fits)), key=lambda i: (_rank_key(found, i), fits[i].name))
    told = [_material(fits[i], found, motion, drawn[i], i, question) for i in order]
    _note_ranks(told, [one.quiet if (one := drawn[i]) else None for i in order], [_rank_key(found, i) for i in order])
    return material_dataset(told, _attributes([fits[i] for i in order], question, scan, speed))


# --- what is compared -------------------------------------------------------------------------------------------------


def _fits(materials: Asked, wanted: Wanted) -> list[MaterialFit]:
    """A fit per material. Raises ConfigError, TypeError or ValueError."""
    if isinstance(materials, Mapping):
        fits = [_fit_of(name, points) for name, points in materials.items()]
    elif isinstance(materials, str | os.PathLike):
        fits = fit_materials([found_points(materials)], wanted)
    elif all(isinstance(one, MaterialFit) for one in materials):
        fits = [one for one in materials if isinstance(one, MaterialFit)]
    else:
        fits = fit_materials([found_points(one) for one in materials if not isinstance(one, MaterialFit)], wanted)
    if not fits:
        raise ValueError("materials: got none, expected at least one")
    for one in fits:
        if one.curve is None:
            hint = "stickslip fit ranks lubricants by their ageing"
            raise ConfigError(
                str(one.path), [Problem((), "friction over waiting time, expected it over speed", hint=hint)]
            )
    return fits


def _fit_of(name: str, points: Points) -> MaterialFit:
    if isinstance(points, CurveFit):
        return MaterialFit(name, Path(name), Columns(), points)
    speed, mu = points
    columns = Columns({"speed": np.asarray(speed, np.float64), "mu": np.asarray(mu, np.float64)})
    try:
        return MaterialFit(name, Path(name), columns, fit_curve(speed, mu))
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def _doubts(fits: Sequence[MaterialFit], given: Mapping[str, float | str]) -> str | None:
    """What to ask about a system that is implausible with these curves, as a configuration is asked about it."""
    curves = [one.curve for one in fits if one.curve is not None]
    zipped = {name: [getattr(curve, name) for curve in curves] for name in _COEFFICIENTS}
    speed = {} if "belt_speed" in given else {"belt_speed": float(min(one.searched[0] for one in curves))}
    config = make_config({"system": {**given, **speed}, "axes": {"material": {"zip": zipped}}})
    return question_about(Document("compare", {"system": dict(given)}), config)


def _quantity(name: str, value: float | str, called: str = "") -> float:
    """A quantity in SI. Raises ValueError."""
    row = PARAMETERS[name]
    number = value if isinstance(value, str) else float(value)
    try:
        return row.read(number)
    except QuantityError as error:
        hint = f"; {error.hint}" if error.hint else ""
        raise ValueError(f"{called or name}: got {value!r}, expected {error.expected}{hint}") from None


def _scan(fits: Sequence[MaterialFit], question: Question) -> Scan:
    """The speeds looked at first. Raises ValueError."""
    if question.between is not None:
        low, high = question.between
        if not 0 < low < high:
            raise ValueError(f"between: got {low:g} to {high:g} m/s, expected two speeds above 0, the slower one first")
        return Scan(low, high, question.limits.scan, "log")
    curves = [one.curve for one in fits if one.curve is not None]
    slowest = min(one.searched[0] for one in curves)  # a tenth of the slowest measured speed above 0
    fastest = max(one.speeds[1] for one in curves)
    system = question.system
    for one in curves:
        if one.a3 > 0:
            ends = (
                loss_of_stability(one.a2, one.a3, one.a4, system["damping"], system["normal_load"]),
                stick_slip_limit(one.a2, one.a3, one.a4, system["damping"], system["normal_load"]),
            )
            fastest = max([fastest, *(float(end) for end in ends if np.isfinite(end))])
    if question.belt_speed is not None:
        slowest, fastest = min(slowest, question.belt_speed / _SLOWER), max(fastest, question.belt_speed)
    return Scan(slowest, _FASTER * fastest, question.limits.scan, "log")


# --- what is found ----------------------------------------------------------------------------------------------------


class _Drawn(NamedTuple):
    """Drawn curves: the speeds above which they are quiet, and the share of them that fall for ever (a2 < 0)."""

    quiet: Quiet
    falling: float


def _drawn(curve: CurveFit, question: Question, scan: Scan) -> _Drawn | None:
    """What is found of drawn curves; None where none can be drawn.

    A curve that falls for ever faster than the damper grows vibrates at any speed; so does, as far as this can tell,
    one whose friction would be negative within the range.
    """
    drawn = draw_curves(curve, question.draws, question.seed, falling=True) if question.draws else None
    if drawn is None:
        return None
    options = replace(question.options, rtol=Options.rtol, max_steps=_DRAWN_STEPS)
    tolerance = max(_DRAWN_TO, question.limits.tolerance)
    a1, a2 = drawn.coefficients["a1"], drawn.coefficients["a2"]
    held = question.system["damping"] + question.system["normal_load"] * a2 >= 0
    lost = drawn.falling & ~(held & (a1 + a2 * scan.high >= 0))
    found = Quiet(np.full(a2.size, scan.high), np.full(a2.size, scan.high), np.full(a2.size, VIBRATES, np.int8))
    if not lost.all():
        rest = {name: values[~lost] for name, values in drawn.coefficients.items()}
        part = quiet_above(rest, question.system, scan, tolerance, options)
        found.speed[~lost], found.low[~lost], found.state[~lost] = part.speed, part.low, part.state
    return _Drawn(found, float(drawn.falling.mean()))


def _rank_key(found: Quiet, i: int) -> tuple[int, float]:
    """What materials are ordered by: quiet throughout first, then by speed, vibrating throughout last."""
    state = found.state[i]
    group = 0 if state == QUIET else 2 if state == VIBRATES else 1
    return group, float(found.speed[i]) if group == 1 else 0.0


def _material(
    fit: MaterialFit, found: Quiet, motion: Mapping[str, NDArray[Any]], drawn: _Drawn | None, i: int, question: Question
) -> Material:
    """All that is known of one material."""
    assert fit.curve is not None
    values: dict[str, float] = {
        "quiet_above": float(found.speed[i]), "quiet_state": float(found.state[i]),
        "tendency": _tendency(fit.curve, float(motion["slip_speed_max"][i])),
    }  # fmt: skip
    if question.belt_speed is not None:
        values |= {name: float(motion[name][i]) for name in ("regime", "frequency", "stick_fraction")}
        values["margin"] = question.belt_speed / values["quiet_above"] if found.state[i] != QUIET else np.inf
    if question.draws:
        values |= _interval(drawn, question)
    return Material(fit, values, question.belt_speed is not None)


def _tendency(curve: CurveFit, slip_speed_max: float) -> float:
    """Eq. (3) of a motion that reached a slip speed (m/s), on a curve without hysteresis.

    Its reversal point lies at that speed or at the minimum of the curve, and friction at standstill is `mu_start`.
    """
    reversal = min(slip_speed_max, float(reversal_speed(curve.a2, curve.a3, curve.a4)))
    return float(tendency(curve.mu_start, curve.predict(reversal), curve.mu_start))


def _interval(drawn: _Drawn | None, question: Question) -> dict[str, float]:
    """What the scatter of the points leaves open; NaN where they determine too little."""
    found = {"quiet_above_low": np.nan, "quiet_above_high": np.nan, "draws_used": 0.0, "draws_falling": np.nan}
    if question.belt_speed is not None:
        found["quiet_probability"] = np.nan
    if drawn is None:
        return found
    least, most = (np.sort(bound) for bound in drawn.quiet.between())
    tail = round((1.0 - question.level) / 2.0 * most.size)
    found["quiet_above_low"], found["quiet_above_high"] = float(least[tail]), float(most[-1 - tail])
    found["draws_used"] = float(np.count_nonzero(drawn.quiet.state != UNRESOLVED))
    found["draws_falling"] = drawn.falling
    if question.belt_speed is not None:
        found["quiet_probability"] = float(np.mean(most < question.belt_speed))
    return found


def _note_ranks(told: Sequence[Material], drawn: Sequence[Quiet | None], keys: Sequence[tuple[int, float]]) -> None:
    """Ranks, equal for what is equal, and the probability that each is better than the next."""
    for i, one in enumerate(told):
        same = i > 0 and keys[i] == keys[i - 1]
        one.values["rank"] = told[i - 1].values["rank"] if same else i + 1
        if "quiet_above_low" in one.values:
            here, there = drawn[i], drawn[i + 1] if i + 1 < len(told) else None
            one.values["better_than_next"] = np.nan if here is None or there is None else _below(here, there)


def _below(one: Quiet, other: Quiet) -> float:
    """Probability that a draw of one is below an independent one of the other; equal ones count half."""
    values, ordered = one.between()[1], np.sort(other.between()[1])
    left, right = (np.searchsorted(ordered, values, side=side) for side in ("left", "right"))
    return float(np.mean(ordered.size - 0.5 * (left + right)) / ordered.size)


def _attributes(fits: Sequence[MaterialFit], question: Question, scan: Scan, speed: float) -> dict[str, Any]:
    """What was done, from what: the configuration finds the same borders, all of them."""
    zipped = {name: [getattr(one.curve, name) for one in fits] for name in _COEFFICIENTS}
    data = {
        "title": f"{len(fits)} materials compared",
        "system": {**question.system, "belt_speed": speed},
        "axes": {"material": {"zip": zipped, "labels": [one.name for one in fits]}},
        "border": {"along": "belt_speed", "between": [scan.low, scan.high], "scan": scan.points,
                   "tolerance": question.limits.tolerance},
    }  # fmt: skip
    told: dict[str, Any] = dict(
        provenance(make_config(data).to_yaml(), title=str(data["title"]), action="compare materials")
    )
    told |= {f"system_{name}": value for name, value in question.system.items()}
    told |= {
        "searched_from": scan.low, "searched_to": scan.high, "searched_points": scan.points,
        "tendency_at": speed, "confidence": question.level, "draws": question.draws, "seed": question.seed,
        "vibrating_regimes": " ".join(VIBRATING),
        "files": "\n".join(dict.fromkeys(str(each.path) for one in fits for each in one.repeats or (one,))),
    }  # fmt: skip
    return told | ({} if question.belt_speed is None else {"belt_speed": question.belt_speed})
