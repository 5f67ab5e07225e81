"""Materials compared in one system: `stickslip.compare`."""

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from stickslip.config.examples import points_path
from stickslip.config.reader import make_config
from stickslip.config.studies import section_of_call
from stickslip.config.unit_warnings import friction_question_of_fit, unit_question
from stickslip.config.yaml import Document
from stickslip.dataset.materials import material_dataset
from stickslip.dataset.provenance import provenance
from stickslip.engine import Options, Progress
from stickslip.errors import ConfigError, Problem, UnitWarning
from stickslip.fit import CurveFit, MaterialFit, Wanted, fit_materials, join_repeats
from stickslip.materials.stick_slip_end import (
    CHANCES,
    NOT_DETERMINED,
    QUIET,
    VIBRATES,
    VIBRATING_CODES,
    QuietSpeeds,
    below,
    cells_of,
    drawn_of,
    names_of_scatter,
    quiet_above,
    regimes,
    scatter_of,
    watcher,
)
from stickslip.materials.system import Amount, Amounts, Request, in_percent, is_plain, quantity, speeds_of, system_of
from stickslip.progress import Watch, watched
from stickslip.studies.borders import Border, Scan, fine_enough
from stickslip.theory import loss_of_stability, reversal_speed, stick_slip_limit, tendency
from stickslip.vocabulary import units
from stickslip.vocabulary.flags import VIBRATING
from stickslip.vocabulary.models import CURVE
from stickslip.vocabulary.quantities import PARAMETERS

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
    friction_scale : by which all friction is multiplied, where a part has another than the rig that measured it.
        Of normal_load, damping and friction_scale several values may be given, or a range ("0.5..5 %": five values):
        ranks are those with the largest load and scale and the least damping, and quiet_above_over_damping and so on
        have the border at each value.
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
        number it is (quiet_state), the coefficients, the two speeds at which more points would narrow the interval
        most, and over `slip_speed` the curves with their 95 % bands, over `point` what was measured. Materials whose
        points do not tell where vibration ends, or have implausible friction, come last, without a rank (NaN).

    Raises
    ------
    ConfigError
        For files that will not do.
    TypeError, ValueError
        For other wrong input.
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
    search, options = fine_enough(
        section_of_call(Border, along="belt_speed", scan=scan, tolerance=tolerance), Options(threads=threads)
    )
    low, high = (None, None) if between is None else (quantity("belt_speed", end, "between") for end in between)
    system, over = system_of(given)
    request = Request(
        system, over, speeds_of(belt_speed, speed_range), None if low is None or high is None else (low, high),
        level, draws, seed, search, options,
    )  # fmt: skip
    if question := _question(fits, given | {"belt_speed": belt_speed}, request):
        warnings.warn(question, UnitWarning, stacklevel=2)
    with watched(progress, "curves", request.options.law) as move:
        ds = compare_fits(fits, request, move)
    attributes: dict[str, Any] = {f"written_{name}": value for name, value in given.items()
                                  if isinstance(value, str) and name not in over and not is_plain(value)}  # fmt: skip
    attributes |= {"damping_assumed": 1} if damping is None else {}
    return ds.assign_attrs(attributes | ({"damping_in_percent": 1} if in_percent(damping) else {}))


def compare_fits(fits: Sequence[MaterialFit], request: Request, progress: Progress | None = None) -> xr.Dataset:
    """As `compare`, of fitted curves. progress : called with curves done, in part too, and in all."""
    curves = _curves(fits)
    doubts = [_doubt(fit) for fit in fits]
    drawn = {i: drawn_of(curve, request) for i, curve in enumerate(curves) if curve.determined and not doubts[i]}
    known = [i for i, some in drawn.items() if some or not curves[i].has_intervals]
    scan = _scan([curves[i] for i in known], curves, request)
    table, quiet = _blank(len(fits), request), dict[int, QuietSpeeds | None]()
    total = max(len(known), 1) * (1 + request.draws)
    watch = watcher(request.search, total, progress)
    if known:
        coefficients = {name: np.array([getattr(curves[i], name) for i in known]) for name in (*CURVE, "mu_stop")}
        borders = quiet_above(
            coefficients, request.system, scan, request.search.tolerance, request.options, watch(0, len(known))
        )
        values = _at_speeds([curves[i] for i in known], coefficients, borders, request, scan)
        values |= {f"quiet_above_over_{name}": _over(name, coefficients, request, scan) for name in request.over}
        for name, of_known in values.items():
            table[name][known] = of_known
        for i, border in zip(known, borders.speed.tolist(), strict=True):
            moved = watch(len(quiet) + 1, request.draws)
            scatter, quiet[i] = scatter_of(curves[i], drawn[i], request, scan, border, moved)
            for name, value in scatter.items():
                table[name][i] = value
    if progress:
        progress(total, total)
    order = _rank(table, quiet, [fit.name for fit in fits])
    reasons = [doubts[i] or (_NO_CURVES if curves[i].determined and i not in known else "") for i in order]
    fits = [fits[i] for i in order]
    ordered = {name: values[order] for name, values in table.items()}
    return material_dataset(
        fits, ordered, reasons, _attributes(fits, request, scan), request.speeds.values, request.over
    )


# --- materials, doubts, speeds ----------------------------------------------------------------------------------------


def _fits(materials: Materials, wanted: Wanted) -> list[MaterialFit]:
    if isinstance(materials, Mapping):
        fits = fit_materials(materials)
    else:
        several = [materials] if isinstance(materials, str | os.PathLike) else [*materials]
        fits = [one for one in several if isinstance(one, MaterialFit)]
        paths = [points_path(one) for one in several if not isinstance(one, MaterialFit)]
        fits += fit_materials(paths, wanted)
    if not fits:
        raise ValueError("materials: got none, expected at least one")
    for fit in fits:
        if fit.curve is None:
            hint = "stickslip fit ranks lubricants by their ageing"
            problem = Problem((), "friction over waiting time, expected it over speed", hint=hint)
            raise ConfigError(str(fit.path), [problem])
    return fits


def _curves(fits: Sequence[MaterialFit]) -> list[CurveFit]:
    return [fit.curve for fit in fits if fit.curve is not None]  # `_fits` refuses others


def _slopes(curve: CurveFit) -> list[float]:
    """The coefficients of a curve but its level."""
    return [getattr(curve, name) for name in CURVE[1:]]


def _doubt(fit: MaterialFit) -> str | None:
    (curve,) = _curves([fit])
    return friction_question_of_fit(float(curve.predict(0.0)), fit.points.get("mu"))


def _question(fits: Sequence[MaterialFit], given: Mapping[str, Amounts | None], request: Request) -> str | None:
    """A question about a system that is implausible with these curves, as a configuration is asked about it, and about
    implausible friction."""
    doubts = {fit.name: doubt for fit in fits if (doubt := _doubt(fit))}
    curves = _curves([fit for fit in fits if len(doubts) == len(fits) or fit.name not in doubts])
    zipped = {name: [getattr(curve, name) for curve in curves] for name in CURVE}
    speeds = request.speeds.values
    system = {**request.system, "belt_speed": speeds[-1] if speeds else float(min(one.searched[0] for one in curves))}
    del system["friction_scale"]
    config = make_config({"system": system, "axes": {"material": {"zip": zipped}}})
    written = {  # what was given with a unit needs no question about it
        name: value if is_plain(given.get(name)) else f"{value!r} {units.spelled(PARAMETERS[name].units)}"
        for name, value in system.items()
    }
    question = unit_question(Document("compare", {"system": written}), config)
    odd = [f"{name}: {doubt}" for name, doubt in doubts.items()]
    return "\n".join([*([question] if question else []), *odd]) or None


def _scan(known: Sequence[CurveFit], curves: Sequence[CurveFit], request: Request) -> Scan:
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
            for end in (loss_of_stability, stick_slip_limit):
                speed = float(end(slope, drop, decay, system["damping"], request.load))
                fastest = max(fastest, speed) if np.isfinite(speed) else fastest
    if speeds:
        slowest, fastest = min(slowest, min(speeds) / _SLOWER), max(fastest, *speeds)
    return Scan(slowest, _FASTER * fastest, request.search.scan, "log")


# --- results ----------------------------------------------------------------------------------------------------------


def _blank(count: int, request: Request) -> dict[str, Floats]:
    """The results of materials of which nothing is determined, by names of MATERIAL_VARIABLES: over materials, and over
    belt speeds where there are several."""
    at_speeds, others = {"tendency"}, {"rank", "quiet_above", "quiet_state", *names_of_scatter(request)}
    if request.speeds.values:
        at_speeds |= {"regime", "frequency", "stick_fraction", "margin"} | (others & {*CHANCES})
        others |= {"worst_speed", "vibrating_share"} if request.speeds.is_range else set()
    shape = (count, len(request.speeds.values)) if request.several_speeds else (count,)
    table = {name: np.full(shape if name in at_speeds else count, np.nan) for name in at_speeds | others}
    table |= {f"quiet_above_over_{name}": np.full((count, len(v)), np.nan) for name, v in request.over.items()}
    table["quiet_state"][:] = NOT_DETERMINED
    return table | ({"draws_used": np.zeros(count)} if request.draws else {})


def _at_speeds(
    curves: Sequence[CurveFit], coefficients: Mapping[str, Floats], borders: QuietSpeeds, request: Request, scan: Scan
) -> dict[str, Floats]:
    """The borders of curves, and their motion at the belt speeds of the request; of a range at the speed where one
    vibrates most, its slowest if it is quiet throughout; without any the tendency at the slowest speed searched."""
    places = np.array(request.speeds.values or (scan.low,))
    if request.speeds.is_range:
        low, high = places
        places = np.array([low, *scan.places[(scan.places > low) & (scan.places < high)], high])
    column = {name: values[:, None] for name, values in coefficients.items()}
    results = regimes(cells_of(column, request.system, places), request.options)
    names = ("regime", "frequency", "stick_fraction", "slip_speed_max", "velocity_amplitude")
    motion = {name: np.asarray(results[name], np.float64).reshape(-1, places.size) for name in names}
    amplitude = motion.pop("velocity_amplitude")
    if request.speeds.is_range:
        vibrates = np.isin(motion["regime"], VIBRATING_CODES)
        worst = np.argmax(np.where(vibrates, 1.0 + np.nan_to_num(amplitude), 0.0), axis=1)[:, None]
        motion = {name: np.take_along_axis(values, worst, 1) for name, values in motion.items()}
        motion |= {"worst_speed": places[worst], "vibrating_share": vibrates.mean(axis=1, keepdims=True)}
    rows = zip(curves, motion.pop("slip_speed_max"), strict=True)
    tendencies = np.array([_tendency(curve, fastest, request.system["friction_scale"]) for curve, fastest in rows])
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
                table["better_than_next"][i] = below(here, there)
    return order


def _tendency(curve: CurveFit, slip_speed_max: Floats, scale: float) -> Floats:
    """Eq. (3) of motions that reached a slip speed (m/s).

    The reversal point lies at that speed or at the minimum; without hysteresis friction stops as it starts.
    """
    reversal = np.fmin(slip_speed_max, reversal_speed(*_slopes(curve)))
    stop = curve.predict(0.0) if np.isnan(curve.mu_stop) else curve.mu_stop
    return scale * tendency(curve.predict(0.0), curve.predict(reversal), stop)


def _over(name: str, curves: Mapping[str, Floats], request: Request, scan: Scan) -> Floats:
    """The borders of curves (n, values) at the values of a quantity that varies: 0 where a curve is quiet throughout,
    inf where it vibrates up to the fastest speed searched."""
    values, size = np.array(request.over[name]), curves[CURVE.level].size
    repeated = {key: np.repeat(coefficients, values.size) for key, coefficients in curves.items()}
    system: dict[str, ArrayLike] = {**request.system, name: np.tile(values, size)}
    borders = quiet_above(repeated, system, scan, request.search.tolerance, request.options)
    return borders.between()[1].reshape(size, values.size)


def _attributes(fits: Sequence[MaterialFit], request: Request, scan: Scan) -> dict[str, Any]:
    """Provenance, the request, and a configuration that finds the same borders, all of them."""
    system, speeds = {**request.system}, request.speeds.values
    scale = system.pop("friction_scale")
    zipped: dict[str, list[Any]] = {name: [getattr(fit.curve, name) * (1.0 if name == CURVE.decay else scale)
                                           for fit in fits] for name in CURVE}  # fmt: skip
    stops = [fit.curve.mu_stop * scale for fit in fits if fit.curve is not None]
    if not np.isnan(stops).all():
        zipped["mu_stop"] = ["none" if np.isnan(stop) else stop for stop in stops]
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
    if scale != 1.0 or "friction_scale" in request.over:
        attributes["friction_scale"] = scale
    if request.speeds.is_range:
        return attributes | {"speed_range_from": speeds[0], "speed_range_to": speeds[1]}
    return attributes | ({"belt_speed": speed} if len(speeds) == 1 else {})
