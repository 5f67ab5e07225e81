"""Materials compared in one system: `stickslip.compare`."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from stickslip.borders import Limits, Scan
from stickslip.config.examples import found_points
from stickslip.config.forgotten_units import question as question_about
from stickslip.config.plausible import question_about_points
from stickslip.config.reader import make_config
from stickslip.config.yaml import Document
from stickslip.dataset.materials import Material, material_dataset
from stickslip.dataset.provenance import provenance
from stickslip.engine import Options, Progress
from stickslip.errors import ConfigError, Problem, UnitWarning
from stickslip.fit import CurveFit, MaterialFit, Wanted, fit_curve, fit_materials, join_repeats
from stickslip.fit.points import Columns
from stickslip.materials.quiet import (
    NOT_DETERMINED,
    QUIET,
    VIBRATES,
    VIBRATING_CODES,
    Quiet,
    cells_of,
    quiet_above,
    regimes,
    watcher,
)
from stickslip.materials.scatter import below, drawn_of, nothing_known, scatter_of
from stickslip.materials.system import (
    Amount,
    Amounts,
    Question,
    in_percent,
    is_plain,
    quantity,
    speeds_of,
    system_of,
)
from stickslip.progress import Watch, watched
from stickslip.theory import loss_of_stability, reversal_speed, stick_slip_limit, tendency
from stickslip.vocabulary import units
from stickslip.vocabulary.flags import VIBRATING
from stickslip.vocabulary.quantities import PARAMETERS

Floats = NDArray[np.float64]
Points = tuple[ArrayLike, ArrayLike] | CurveFit
Asked = str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | Mapping[str, Points] | Sequence[MaterialFit]

_COEFFICIENTS = ("a1", "a2", "a3", "a4")
_SLOWER, _FASTER = 10.0, 4.0  # how far beyond what is measured, and what linear theory says, speeds are searched


def compare(
    materials: Asked,
    *,
    mass: Amount,
    stiffness: Amount,
    normal_load: Amounts,
    damping: Amounts | None = None,
    belt_speed: Amounts | None = None,
    speed_range: tuple[Amount, Amount] | None = None,
    friction_scale: Amounts = 1.0,
    between: tuple[Amount, Amount] | None = None,
    unit: str | None = None,
    columns: Wanted | None = None,
    same: str | Sequence[str] = (),
    level: float = 0.95,
    draws: int = 1000,
    seed: int = 1,
    tolerance: float = 1e-9,
    scan: int = 64,
    threads: int | None = None,
    progress: Watch = "auto",
) -> xr.Dataset:
    """Which material keeps a contact quiet, from measured friction over slip speed.

    materials : CSV files of points, each of one material or of several (`stickslip fit` reads the same); or by name,
        points (slip speeds in m/s, friction coefficients) or a `fit.CurveFit`; or fits of `fit.fit_materials`.
    mass, stiffness, normal_load, damping : of the system, numbers in SI or texts with a unit ("5 N/mm"); damping also
        in percent of critical damping, 2 sqrt(k m) ("3 %"). No damping is taken as 0, which the attribute
        `damping_assumed` says; a damper lowers the borders.
    friction_scale : by which all friction is multiplied, where a part has another than the rig that measured it.
    belt_speed : at which regime, margin and probability of being quiet are told, each with the dimension `belt_speed`
        if several are given; without it they are left out, and the tendency is that at the slowest speed searched.
    speed_range : instead of it, the ends of a range in which a contact is to be quiet throughout: margin and
        probability are those of its slowest speed, the regime is that at the speed where it vibrates most
        (worst_speed). A text such as "5..60 mm/s" as belt_speed says the same.
    between : belt speeds searched; None takes a tenth of the slowest measured speed to four times the fastest, or to
        four times where theory sees the end of vibration, if that is more.
    unit : of speeds whose heading names none. columns : which columns of the files to take, where headings do not say.
    same : patterns of names ("grease A*") of repeats of one material each: one row, whose interval holds what differs
        between them (`fit.fit_repeats`); the variables `repeats` and `repeat_names` tell how many there are, and which.
    level : of the confidence intervals. draws : curves drawn per material from what its fit leaves open, of which the
        intervals are quantiles; 0 leaves intervals out. seed : of the draws.
    tolerance, scan : of the search of borders, as for `border`. threads : None for all. progress : as for `run`; what
        is counted are curves, those drawn among them.

    Of normal_load, damping and friction_scale several values may be given, or a range ("0.5..5 %": five values): ranks
    are those with the largest load and scale and the least damping, and quiet_above_over_damping and so on have the
    border at each value.

    Returns a dataset over `material`, best first: quiet_above and the interval quiet_above_low to quiet_above_high,
    what kind of number it is (quiet_state), the coefficients, the two speeds at which more points would narrow the
    interval most, and over `slip_speed` the curves with their 95 % bands, over `point` what was measured. Materials
    whose points do not tell where vibration ends, or have implausible friction, come last, without a rank (NaN). Raises
    ConfigError for files that will not do, TypeError or ValueError for other wrong input.
    """
    wanted = columns or Wanted()
    load = wanted.load  # by which friction forces are divided
    if load is None and isinstance(normal_load, float | int | str) and ".." not in str(normal_load):
        load = normal_load
    fits = _fits(materials, replace(wanted, unit=unit or wanted.unit, load=load))
    fits = join_repeats(fits, [same] if isinstance(same, str) else same)
    given = {"mass": mass, "stiffness": stiffness, "normal_load": normal_load,
             "damping": 0.0 if damping is None else damping, "friction_scale": friction_scale}  # fmt: skip
    if not 0 < level < 1:
        raise ValueError(f"level: got {level!r}, expected a share above 0 and below 1, such as 0.95")
    if isinstance(draws, bool) or not isinstance(draws, int) or draws < 0:
        raise ValueError(f"draws: got {draws!r}, expected a whole number of at least 0")
    limits = Limits(scan, tolerance)
    ends = None if between is None else tuple(quantity("belt_speed", end, "between") for end in between)
    system, over = system_of(given)
    question = Question(
        system, over, speeds_of(belt_speed, speed_range), None if ends is None else (ends[0], ends[1]),
        level, draws, seed, limits, limits.applied(Options(threads=threads), None),
    )  # fmt: skip
    if asked := _doubts(fits, given | {"belt_speed": belt_speed}, question):
        warnings.warn(asked, UnitWarning, stacklevel=2)
    with watched(progress, "curves", question.options.law) as move:
        ds = compare_fits(fits, question, move)
    written = {f"written_{name}": value for name, value in given.items()
               if isinstance(value, str) and name not in over and not is_plain(value)}  # fmt: skip
    notes = {"damping_assumed": 1} if damping is None else {}
    return ds.assign_attrs(written | notes | ({"damping_in_percent": 1} if in_percent(damping) else {}))


def compare_fits(fits: Sequence[MaterialFit], question: Question, progress: Progress | None = None) -> xr.Dataset:
    """The same of fitted curves; see `compare`. progress : called with curves done, in part too, and in all."""
    doubts = [_doubt_of(one) for one in fits]
    known = {
        i: (one.curve, drawn)
        for i, one in enumerate(fits)
        if one.curve
        and one.curve.determined
        and not doubts[i]
        and ((drawn := drawn_of(one.curve, question)) or not one.curve.has_intervals)
    }
    scan = _scan([fits[i] for i in known], fits, question)
    told = [_undetermined(one, doubt, question) for one, doubt in zip(fits, doubts, strict=True)]
    keys: list[tuple[int, float]] = [(3, 0.0)] * len(fits)
    over: dict[str, Floats] = {
        name: np.full((len(fits), len(values)), np.nan) for name, values in question.over.items()
    }
    quiet: dict[int, Quiet | None] = {}
    curves_in_all = max(len(known), 1) * (1 + question.draws)
    watch = watcher(question.limits, len(known), curves_in_all, progress)
    if known:
        curves = {name: np.array([getattr(fits[i].curve, name) for i in known]) for name in _COEFFICIENTS}
        found = quiet_above(
            curves, question.system, scan, question.limits.tolerance, question.options, watch(0, len(known))
        )
        motion = _motion(curves, question, scan)
        for row, (i, (curve, drawn)) in enumerate(known.items()):
            values, quiet[i] = scatter_of(
                curve, drawn, question, scan, float(found.speed[row]), watch(row + 1, question.draws)
            )
            told[i] = _material(fits[i], found, motion, values, row, question)
            keys[i] = _rank_key(found, row)
        for name in over:
            over[name][[*known]] = _over(name, curves, question, scan)
    if progress:
        progress(curves_in_all, curves_in_all)
    order = sorted(range(len(fits)), key=lambda i: (keys[i], fits[i].name))
    _note_ranks([told[i] for i in order], [quiet.get(i) for i in order], [keys[i] for i in order])
    attributes = _attributes([fits[i] for i in order], question, scan)
    table = {name: (question.over[name], values[order]) for name, values in over.items()}
    return material_dataset([told[i] for i in order], attributes, question.speeds.values, table)


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


def _doubts(fits: Sequence[MaterialFit], given: Mapping[str, Amounts | None], question: Question) -> str | None:
    """What to ask about a system that is implausible with these curves, as a configuration is asked about it, and about
    implausible friction."""
    plausible = [one.curve for one in fits if one.curve and not _doubt_of(one)]
    curves = plausible or [one.curve for one in fits if one.curve]
    zipped = {name: [getattr(curve, name) for curve in curves] for name in _COEFFICIENTS}
    speed = question.speeds.values[-1] if question.speeds.values else float(min(one.searched[0] for one in curves))
    used = {**question.system, "belt_speed": speed}
    plain = {name: value for name, value in used.items() if name != "friction_scale"}
    bare = {name: plain[name] for name, value in given.items() if name in plain and is_plain(value)}
    config = make_config({"system": plain, "axes": {"material": {"zip": zipped}}})
    asked = question_about(Document("compare", {"system": {**_written(plain), **bare}}), config)
    odd = [f"{one.name}: {doubt}" for one in fits if (doubt := _doubt_of(one))]
    return "\n".join([*([asked] if asked else []), *odd]) or None


def _written(system: Mapping[str, float]) -> dict[str, str]:
    """Quantities with their units, about which nothing needs to be asked as if a unit were missing."""
    return {name: f"{value!r} {units.spelled(PARAMETERS[name].units)}" for name, value in system.items()}


def _doubt_of(fit: MaterialFit) -> str | None:
    """What to ask about a material whose friction is implausible."""
    assert fit.curve is not None
    return question_about_points(fit.curve.mu_start, fit.points.get("mu"))


def _scan(known: Sequence[MaterialFit], fits: Sequence[MaterialFit], question: Question) -> Scan:
    """The speeds looked at first. Raises ValueError."""
    asked = question.speeds.values
    if question.between is not None:
        low, high = question.between
        if not 0 < low < high:
            raise ValueError(f"between: got {low:g} to {high:g} m/s, expected two speeds above 0, the slower one first")
        if asked and not low <= min(asked) <= max(asked) <= high:
            raise ValueError(f"between: got {low:g} to {high:g} m/s, expected it to hold the belt speed asked about")
        return Scan(low, high, question.limits.scan, "log")
    curves = [one.curve for one in known or fits if one.curve is not None]
    slowest = min(one.searched[0] for one in curves)  # a tenth of the slowest measured speed above 0
    fastest = max(one.speeds[1] for one in curves)
    system = question.system
    for one in curves:
        if known and one.a3 > 0:
            load = system["normal_load"] * system["friction_scale"]
            ends = [
                end(one.a2, one.a3, one.a4, system["damping"], load) for end in (loss_of_stability, stick_slip_limit)
            ]
            fastest = max([fastest, *(float(end) for end in ends if np.isfinite(end))])
    if asked:
        slowest, fastest = min(slowest, min(asked) / _SLOWER), max(fastest, *asked)
    return Scan(slowest, _FASTER * fastest, question.limits.scan, "log")


# --- what is found ----------------------------------------------------------------------------------------------------


def _motion(curves: Mapping[str, Floats], question: Question, scan: Scan) -> dict[str, Floats]:
    """The motion of each curve at the belt speeds that are asked about, (n, speeds); of a range at the speed where it
    vibrates most, its slowest if it is quiet throughout; without any at the slowest speed searched."""
    places = np.array(question.speeds.values or (scan.low,))
    if question.speeds.is_range:
        low, high = places
        places = np.array([low, *scan.places[(scan.places > low) & (scan.places < high)], high])
    column = {name: values[:, None] for name, values in curves.items()}
    found = regimes(cells_of(column, question.system, places), question.options)
    names = ("regime", "frequency", "stick_fraction", "slip_speed_max")
    motion = {name: np.asarray(found[name], np.float64).reshape(-1, places.size) for name in names}
    if not question.speeds.is_range:
        return motion
    amplitude = np.nan_to_num(np.asarray(found["velocity_amplitude"]).reshape(-1, places.size))
    vibrates = np.isin(motion["regime"], VIBRATING_CODES)
    worst = np.argmax(np.where(vibrates, 1.0 + amplitude, 0.0), axis=1)[:, None]
    motion = {name: np.take_along_axis(values, worst, 1) for name, values in motion.items()}
    return motion | {"worst_speed": places[worst], "vibrating_share": vibrates.mean(axis=1, keepdims=True)}


def _rank_key(found: Quiet, i: int) -> tuple[int, float]:
    """What materials are ordered by: quiet throughout first, then by speed, vibrating throughout last."""
    state = found.state[i]
    group = 0 if state == QUIET else 2 if state == VIBRATES else 1
    return group, float(found.speed[i]) if group == 1 else 0.0


def _material(
    fit: MaterialFit, found: Quiet, motion: Mapping[str, Floats], scatter: dict[str, Any], i: int, question: Question
) -> Material:
    """All that is known of one material; numbers at belt speeds are arrays where several are asked about."""
    assert fit.curve is not None
    at = slice(None) if question.several_speeds else 0
    values: dict[str, Any] = {
        "quiet_above": float(found.speed[i]), "quiet_state": float(found.state[i]),
        "tendency": _tendency(fit.curve, motion["slip_speed_max"][i], question.system["friction_scale"])[at],
    }  # fmt: skip
    if question.speeds.values:
        values |= {name: array[i][at] for name, array in motion.items() if name != "slip_speed_max"}
        speeds = np.array(question.speeds.values)[at]
        values["margin"] = speeds / values["quiet_above"] if found.state[i] != QUIET else np.full_like(speeds, np.inf)
    return Material(fit, values | scatter)


def _undetermined(fit: MaterialFit, doubt: str | None, question: Question) -> Material:
    """A material that is not ranked, and why."""
    assert fit.curve is not None
    reason = doubt or ("" if not fit.curve.determined else "No curve can be drawn from what its fit leaves open.")
    at_speed = np.full(len(question.speeds.values), np.nan) if question.several_speeds else np.nan
    found = {"rank": np.nan, "quiet_above": np.nan, "quiet_state": float(NOT_DETERMINED), "tendency": at_speed}
    if question.speeds.values:
        found |= dict.fromkeys(("regime", "frequency", "stick_fraction", "margin"), at_speed)
        found |= {"worst_speed": np.nan, "vibrating_share": np.nan} if question.speeds.is_range else {}
    return Material(fit, found | nothing_known(question), reason)


def _tendency(curve: CurveFit, slip_speed_max: Floats, scale: float) -> Floats:
    """Eq. (3) of motions that reached a slip speed (m/s), on a curve without hysteresis.

    Its reversal point lies at that speed or at the minimum of the curve, and friction at standstill is `mu_start`.
    """
    reversal = np.fmin(slip_speed_max, reversal_speed(curve.a2, curve.a3, curve.a4))
    return scale * tendency(curve.mu_start, curve.predict(reversal), curve.mu_start)


def _over(name: str, curves: Mapping[str, Floats], question: Question, scan: Scan) -> Floats:
    """The borders of curves (n, values) at the values of a quantity that varies: 0 where a curve is quiet throughout,
    inf where it vibrates up to the fastest speed searched."""
    values = np.array(question.over[name])
    size = curves["a1"].size
    repeated = {key: np.repeat(one, values.size) for key, one in curves.items()}
    system: dict[str, ArrayLike] = {**question.system, name: np.tile(values, size)}
    found = quiet_above(repeated, system, scan, question.limits.tolerance, question.options)
    return found.between()[1].reshape(size, values.size)


def _note_ranks(told: Sequence[Material], drawn: Sequence[Quiet | None], keys: Sequence[tuple[int, float]]) -> None:
    """Ranks, equal for what is equal, and the probability that each is better than the next."""
    for i, one in enumerate(told):
        if one.values["quiet_state"] == NOT_DETERMINED:
            continue
        same = i > 0 and keys[i] == keys[i - 1]
        one.values["rank"] = told[i - 1].values["rank"] if same else i + 1
        if "quiet_above_low" in one.values:
            here, there = drawn[i], drawn[i + 1] if i + 1 < len(told) else None
            one.values["better_than_next"] = np.nan if here is None or there is None else below(here, there)


def _attributes(fits: Sequence[MaterialFit], question: Question, scan: Scan) -> dict[str, Any]:
    """What was done, from what: the configuration finds the same borders, all of them."""
    scale, speeds = question.system["friction_scale"], question.speeds
    zipped = {name: [getattr(one.curve, name) * (1.0 if name == "a4" else scale) for one in fits]
              for name in _COEFFICIENTS}  # fmt: skip
    system = {name: value for name, value in question.system.items() if name != "friction_scale"}
    speed = speeds.values[0] if speeds.values else scan.low
    data = {
        "title": f"{len(fits)} materials compared",
        "system": {**system, "belt_speed": speed},
        "axes": {"material": {"zip": zipped, "labels": [one.name for one in fits]}},
        "border": {"along": "belt_speed", "between": [scan.low, scan.high], "scan": scan.points,
                   "tolerance": question.limits.tolerance},
    }  # fmt: skip
    told: dict[str, Any] = dict(
        provenance(make_config(data).to_yaml(), title=str(data["title"]), action="compare materials")
    )
    told |= {f"system_{name}": value for name, value in system.items()}
    told |= {
        "searched_from": scan.low, "searched_to": scan.high, "searched_points": scan.points,
        "tendency_at": speed, "confidence": question.level, "draws": question.draws, "seed": question.seed,
        "vibrating_regimes": " ".join(VIBRATING),
        "files": "\n".join(dict.fromkeys(str(each.path) for one in fits for each in one.repeats or (one,))),
    }  # fmt: skip
    if len(speeds.values) > 1:
        del told["tendency_at"]
    told |= {"friction_scale": scale} if scale != 1.0 or "friction_scale" in question.over else {}
    if speeds.is_range:
        return told | {"speed_range_from": speeds.values[0], "speed_range_to": speeds.values[1]}
    return told | ({"belt_speed": speed} if len(speeds.values) == 1 else {})
