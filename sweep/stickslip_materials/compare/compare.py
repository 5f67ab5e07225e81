"""Materials compared in one system: `stickslip.compare`."""

import math
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from stickslip.config.describe import unit_question
from stickslip.config.reader import make_config
from stickslip.config.resolve import points_path
from stickslip.config.studies import section_of_call
from stickslip.config.yaml import Document
from stickslip.dataset.provenance import provenance
from stickslip.engine import Options, Progress
from stickslip.errors import ConfigError, UnitWarning
from stickslip.progress import Watch, watched
from stickslip.studies.borders import Border, Scan, fine_enough
from stickslip.theory import loss_of_stability, reversal_speed, stick_slip_limit, tendency
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import as_cells
from stickslip.vocabulary.flags import VIBRATING
from stickslip.vocabulary.models import CURVE
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip_materials.compare import stick_slip_end as end
from stickslip_materials.compare.dataset import material_dataset
from stickslip_materials.compare.stick_slip_end import NOT_DETERMINED, QUIET, VIBRATES, QuietSpeeds
from stickslip_materials.compare.system import (
    Amount,
    Amounts,
    CompareRequest,
    alike,
    is_plain,
    quantity,
    speeds_of,
    system_of,
)  # fmt: skip
from stickslip_materials.doubts import question_of_fit
from stickslip_materials.fit import CurveFit, MaterialFit, Wanted, fit_materials, join_repeats
from stickslip_materials.fit.files import NO_CURVE

Floats = NDArray[np.float64]
Points = tuple[ArrayLike, ArrayLike] | CurveFit
Materials = str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | Mapping[str, Points] | Sequence[MaterialFit]

_NO_CURVES = "No curve can be drawn from what its fit leaves open."
_SLOWER, _FASTER = 10.0, 4.0  # how far beyond what is measured, and what linear theory says, speeds are searched


def compare(
    materials: Materials,
    *,
    mass: Amount,
    stiffness: Amount,
    normal_load: Amount,
    damping: Amount | None = None,
    belt_speed: Amounts | None = None,
    speed_range: tuple[Amount, Amount] | None = None,
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
    """Materials in the order of the belt speed above which a contact is quiet, from measured friction over slip speed.

    Parameters
    ----------
    materials : CSV files of points, each of one material or of several (`stickslip fit` reads the same); or by name,
        points (slip speeds in m/s, friction coefficients) or a `fit.CurveFit`; or fits of `fit.fit_materials`.
    mass, stiffness, normal_load, damping : of the system, numbers in SI or texts with a unit ("5 N/mm"); damping also
        in percent of critical damping, 2 sqrt(k m) ("3 %"). No damping is taken as 0, which the attribute
        `damping_assumed` says; a damper lowers the borders.
    belt_speed : at which regime, margin and probability of being quiet are told, each with the dimension `belt_speed`
        if several are given; without it they are left out, and the tendency is that at the slowest speed searched.
    speed_range : instead of it, the ends of a range in which a contact is to be quiet throughout: margin and
        probability are those of its slowest speed, the regime is that at the speed where it vibrates most
        (worst_speed). A text such as "5..60 mm/s" as belt_speed says the same.
    between : belt speeds searched; None takes a tenth of the slowest measured speed to four times the fastest, or to
        four times where theory sees the end of vibration, if that is more.
    unit : of speeds whose heading names none.
    columns : which columns of the files to take, where headings do not say.
    same : patterns of names ("grease A*") of repeats of one material each: one row, whose interval holds what differs
        between them (`fit.fit_repeats`); the variables `repeats` and `repeat_names` tell how many there are, and which.
    level : of the confidence intervals.
    draws, seed : curves drawn per material from what its fit leaves open, of which the intervals are quantiles; 0
        leaves intervals out.
    tolerance, scan : of the search of borders, as for `border`.
    threads, progress : as for `run`; None takes all threads, and progress counts curves, those drawn among them.

    Returns
    -------
    xarray.Dataset
        Over `material`, best first: quiet_above and the interval quiet_above_low to quiet_above_high, what kind of
        number it is (quiet_state), the coefficients, and over `slip_speed` the curves with their 95 % bands, over
        `point` what was measured. Materials whose points do not tell where vibration ends, whose friction or speeds are
        implausible, or whose curve says other than most of the curves drawn, come last, without a rank (NaN).

    Raises
    ------
    ConfigError
        For files that will not do.
    TypeError, ValueError
        For other wrong input.
    """
    given = {"mass": mass, "stiffness": stiffness, "normal_load": normal_load,
             "damping": 0.0 if damping is None else damping}  # fmt: skip
    if not 0 < level < 1:
        raise ValueError(f"level: got {level!r}, expected a share above 0 and below 1, such as 0.95")
    if isinstance(draws, bool) or not isinstance(draws, int) or draws < 0:
        raise ValueError(f"draws: got {draws!r}, expected a whole number of at least 0")
    search, options = fine_enough(
        section_of_call(Border, along="belt_speed", scan=scan, tolerance=tolerance), Options(threads=threads)
    )
    low, high = (None, None) if between is None else alike("between", between)
    searched = None if low is None or high is None else (
        quantity("belt_speed", low, "between"), quantity("belt_speed", high, "between")
    )  # fmt: skip
    request = CompareRequest(
        system_of(given), speeds_of(belt_speed, speed_range), searched, level, draws, seed, search, options
    )
    wanted = columns or Wanted()
    load = normal_load if wanted.load is None else wanted.load  # by which friction forces are divided
    fits = _fits(materials, replace(wanted, unit=unit or wanted.unit, load=load))
    fits = join_repeats(fits, [same] if isinstance(same, str) else same)
    if question := _question(fits, given | {"belt_speed": belt_speed}, request):
        warnings.warn(question, UnitWarning, stacklevel=2)
    with watched(progress, "curves", request.options.law) as move:
        ds = compare_fits(fits, request, move)
    return ds.assign_attrs(damping_assumed=1) if damping is None else ds


def compare_fits(fits: Sequence[MaterialFit], request: CompareRequest, progress: Progress | None = None) -> xr.Dataset:
    """As `compare`, of fitted curves. progress : called with curves done, and in all."""
    curves = _curves(fits)
    doubts = [question_of_fit(curve.mu_start, fit.points) or "" for curve, fit in zip(curves, fits, strict=True)]
    drawn = {i: end.drawn_of(curve, request) for i, curve in enumerate(curves) if curve.determined and not doubts[i]}
    known = [i for i, allowed in drawn.items() if allowed or not curves[i].has_intervals]
    for i in drawn.keys() - {*known}:
        doubts[i] = _NO_CURVES
    scan = _scan([curves[i] for i in known], curves, request)
    table, quiet = _blank(len(fits), request), dict[int, QuietSpeeds | None]()
    total = len(known) * (1 + request.draws)
    if known:
        friction = end.friction_of([curves[i] for i in known])
        borders = end.quiet_above(friction, request.system, scan, request.search.tolerance, request.options)
        for name, of_known in _at_speeds([curves[i] for i in known], friction, borders, request, scan).items():
            table[name][known] = of_known
        for place, (i, ends) in enumerate(zip(known, zip(*borders.between(), strict=True), strict=True)):
            scatter, of_drawn = end.scatter_of(drawn[i], request, scan)
            if doubt := _contradiction(scatter, ends):
                doubts[i], scatter = doubt, {name: values[0] for name, values in _blank(1, request).items()}
            else:
                quiet[i] = of_drawn
            for name, value in scatter.items():
                table[name][i] = value
            if progress:
                progress(len(known) + (place + 1) * request.draws, total)
    order = _rank(table, quiet, [fit.name for fit in fits])
    ordered = {name: values[order] for name, values in table.items()}
    fits, doubts = [fits[i] for i in order], [doubts[i] for i in order]
    return material_dataset(fits, ordered, doubts, _attributes(fits, request, scan), request.speeds.values)


def _contradiction(scatter: dict[str, float | Floats], ends: tuple[float, float]) -> str:
    """Why a border, whose ends these are, cannot stand beside what the curves drawn say; empty where it can.

    An interval that misses the border by no more than the tolerance of the borders of drawn curves is widened to it.
    """
    if not scatter:
        return ""
    (least, most), (low, high) = ends, (float(scatter[f"quiet_above_{which}"]) for which in ("low", "high"))
    if most == 0.0 and np.ravel(scatter.get("quiet_probability", 1.0))[0] < 0.5:  # at the slowest belt speed
        return "The fitted curve vibrates at no speed; most of the curves that the points allow do at the belt speed."
    if not (least <= high * (1.0 + end.DRAWN_TO) and most * (1.0 + end.DRAWN_TO) >= low):
        return "The border of the fitted curve lies outside of the interval that the points leave."
    scatter |= {"quiet_above_low": min(low, most), "quiet_above_high": max(high, least)}
    return ""


# --- materials, doubts, speeds ----------------------------------------------------------------------------------------


def _fits(materials: Materials, wanted: Wanted) -> list[MaterialFit]:
    if isinstance(materials, Mapping):
        fits = fit_materials(materials)
    else:
        several = [materials] if isinstance(materials, str | os.PathLike) else [*materials]
        fits = [material for material in several if isinstance(material, MaterialFit)]
        paths = [points_path(material) for material in several if not isinstance(material, MaterialFit)]
        fits += fit_materials(paths, wanted, ageing=False)
    if not fits:
        raise ValueError("materials: got none, expected at least one")
    if errors := [ConfigError.of(fit.path, *NO_CURVE) for fit in fits if fit.curve is None]:
        raise ConfigError.of_files(errors)
    return fits


def _curves(fits: Sequence[MaterialFit]) -> list[CurveFit]:
    return [fit.curve for fit in fits if fit.curve is not None]  # `_fits` refuses others


def _slopes(curve: CurveFit) -> list[float]:
    """The coefficients of a curve but its level."""
    return [getattr(curve, name) for name in CURVE[1:]]


def _question(fits: Sequence[MaterialFit], given: Mapping[str, Amounts | None], request: CompareRequest) -> str | None:
    """A question about a system that is implausible with these curves, as a configuration is asked about it, and about
    implausible friction and speeds."""
    curves = _curves(fits)
    questions = [question_of_fit(curve.mu_start, fit.points) for curve, fit in zip(curves, fits, strict=True)]
    plausible = [curve for curve, odd in zip(curves, questions, strict=True) if not odd] or curves
    zipped = {name: [getattr(curve, name) for curve in plausible] for name in CURVE}
    slowest = float(min(curve.searched[0] for curve in plausible))
    system = {**request.system, "belt_speed": request.speeds.values[-1] if request.speeds.values else slowest}
    written = {  # what was given with a unit needs no question about it
        name: value if is_plain(given.get(name)) else f"{value!r} {units.spelled(PARAMETERS[name].units)}"
        for name, value in system.items()
    }
    config = make_config({"system": written, "axes": {"material": {"zip": zipped}}})
    question = unit_question(Document("compare", {"system": written}), config)
    odd = [f"{fit.name}: {question}" for fit, question in zip(fits, questions, strict=True) if question]
    return "\n".join([*([question] if question else []), *odd]) or None


def _scan(known: Sequence[CurveFit], curves: Sequence[CurveFit], request: CompareRequest) -> Scan:
    """The speeds looked at first. Raises ValueError."""
    speeds, system = request.speeds.values, request.system
    if request.between is not None:
        low, high = request.between
        if not 0 < low < high:
            raise ValueError(f"between: got {low:g} to {high:g} m/s, expected two speeds above 0, the slower one first")
        if speeds and not low <= min(speeds) <= max(speeds) <= high:
            raise ValueError(f"between: got {low:g} to {high:g} m/s, expected it to hold the belt speed asked about")
        return Scan(low, high, request.search.scan, "log")
    curves = known or curves
    slowest = min(curve.searched[0] for curve in curves)  # a tenth of the slowest measured speed above 0
    fastest = max(curve.speeds[1] for curve in curves)
    for curve in curves:
        if known and curve.declines:
            slope, drop, decay = _slopes(curve)
            for limit in (loss_of_stability, stick_slip_limit):
                speed = float(limit(slope, drop, decay, system["damping"], system["normal_load"]))
                fastest = max(fastest, speed) if np.isfinite(speed) else fastest
    if speeds:
        slowest, fastest = min(slowest, min(speeds) / _SLOWER), max(fastest, *speeds)
    return Scan(slowest, _FASTER * fastest, request.search.scan, "log")


# --- results ----------------------------------------------------------------------------------------------------------


def _blank(count: int, request: CompareRequest) -> dict[str, Floats]:
    """The results of materials of which nothing is determined, by names of MATERIAL_VARIABLES: over materials, and over
    belt speeds where there are several."""
    at_speeds, others = {"tendency"}, {"rank", "quiet_above", "quiet_state", *end.names_of_scatter(request)}
    if request.speeds.values:
        at_speeds |= {"regime", "frequency", "stick_fraction", "margin"} | (others & {*end.CHANCES})
        others |= {"worst_speed"} if request.speeds.is_range else set()
    shape = (count, len(request.speeds.values)) if request.several_speeds else (count,)
    table = {name: np.full(shape if name in at_speeds else count, np.nan) for name in at_speeds | others}
    table["quiet_state"][:] = NOT_DETERMINED
    return table | ({"draws_used": np.zeros(count)} if request.draws else {})


def _at_speeds(
    curves: Sequence[CurveFit],
    friction: Mapping[str, Floats],
    borders: QuietSpeeds,
    request: CompareRequest,
    scan: Scan,
) -> dict[str, Floats]:
    """The borders of curves, and their motion at the belt speeds of the request; of a range at the speed where one
    vibrates most, its slowest if it is quiet throughout; without any the tendency at the slowest speed searched."""
    places = np.array(request.speeds.values or (scan.low,))
    if request.speeds.is_range:
        low, high = places
        places = np.array([low, *scan.places[(scan.places > low) & (scan.places < high)], high])
    column = {name: values[:, None] for name, values in friction.items()}
    results = end.regimes(as_cells({**request.system, **column, "belt_speed": places}), request.options)
    names = ("regime", "frequency", "stick_fraction", "slip_speed_max", "velocity_amplitude")
    motion = {name: np.asarray(results[name], np.float64).reshape(-1, places.size) for name in names}
    amplitude = motion.pop("velocity_amplitude")
    if request.speeds.is_range:
        vibrates = np.isin(motion["regime"], end.VIBRATING_CODES)
        worst = np.argmax(np.where(vibrates, 1.0 + np.nan_to_num(amplitude), 0.0), axis=1)[:, None]
        motion = {name: np.take_along_axis(values, worst, 1) for name, values in motion.items()}
        motion |= {"worst_speed": places[worst]}
    rows = zip(curves, friction["mu_stop"], motion.pop("slip_speed_max"), strict=True)
    tendencies = np.array([_tendency(curve, stop, fastest) for curve, stop, fastest in rows])
    if request.speeds.values:
        margin = np.array(request.speeds.values) / borders.speed[:, None]
        motion["margin"] = np.where(borders.state[:, None] == QUIET, np.inf, margin)
    else:
        motion = {}
    at = slice(None) if request.several_speeds else 0
    values = {name: array[:, at] for name, array in {"tendency": tendencies, **motion}.items()}
    return {"quiet_above": borders.speed, "quiet_state": np.asarray(borders.state, np.float64)} | values


def _rank(table: dict[str, Floats], quiet: Mapping[int, QuietSpeeds | None], names: Sequence[str]) -> list[int]:
    """The order of materials: quiet throughout first, then by speed, vibrating throughout and not determined last.

    Equal ranks, and the probability that each is better than the next, are filled in. quiet : of curves drawn, by
    position of a material that is determined.
    """
    groups = [{QUIET: 0, VIBRATES: 2, NOT_DETERMINED: 3}.get(int(state), 1) for state in table["quiet_state"]]
    keys = [(group, speed if group == 1 else 0.0) for group, speed in zip(groups, table["quiet_above"], strict=True)]
    order = sorted(range(len(names)), key=lambda i: (keys[i], names[i]))
    for place, i in enumerate(order):
        if i in quiet:
            before = order[place - 1] if place else i
            table["rank"][i] = table["rank"][before] if place and keys[before] == keys[i] else place + 1
            here, there = quiet[i], quiet.get(order[place + 1]) if place + 1 < len(order) else None
            if here is not None and there is not None:
                table["better_than_next"][i] = end.below(here, there)
    return order


def _tendency(curve: CurveFit, mu_stop: float, slip_speed_max: Floats) -> Floats:
    """Eq. (3) of motions that reached a slip speed (m/s).

    The reversal point lies at that speed or at the minimum of the curve. Friction at standstill is that at break-away
    where the curve holds on the way down too (mu_stop is NaN).
    """
    reversal = np.fmin(slip_speed_max, reversal_speed(*_slopes(curve)))
    start = curve.predict(0.0)
    return tendency(start, curve.predict(reversal), start if math.isnan(mu_stop) else mu_stop)


def _attributes(fits: Sequence[MaterialFit], request: CompareRequest, scan: Scan) -> dict[str, Any]:
    """Provenance, the request, and a configuration that finds the same borders, all of them."""
    system, speeds, friction = request.system, request.speeds.values, end.friction_of(_curves(fits))
    zipped = {name: ["none" if math.isnan(value) else value for value in values.tolist()]
              for name, values in friction.items() if not np.isnan(values).all()}  # fmt: skip
    speed = speeds[0] if speeds else scan.low
    title = f"{len(fits)} materials compared"
    data = {
        "title": title,
        "system": {**system, "belt_speed": speed},
        "axes": {"material": {"zip": zipped, "labels": [fit.name for fit in fits]}},
        "border": {"along": "belt_speed", "between": [scan.low, scan.high], "scan": scan.points,
                   "tolerance": request.search.tolerance},
    }  # fmt: skip
    attributes: dict[str, Any] = {
        **provenance(make_config(data).to_yaml(), title=title, action="compare materials"),
        **{f"system_{name}": value for name, value in system.items()},
        "searched_from": scan.low, "searched_to": scan.high, "searched_points": scan.points,
        "tendency_at": speed, "confidence": request.level, "draws": request.draws, "seed": request.seed,
        "vibrating_regimes": " ".join(VIBRATING),
        "files": "\n".join(dict.fromkeys(str(each.path) for fit in fits for each in fit.parts)),
    }  # fmt: skip
    if len(speeds) > 1:
        del attributes["tendency_at"]
    if request.speeds.is_range:
        return attributes | {"speed_range_from": speeds[0], "speed_range_to": speeds[1]}
    return attributes | ({"belt_speed": speed} if len(speeds) == 1 else {})
