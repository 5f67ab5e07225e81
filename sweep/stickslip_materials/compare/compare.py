"""Materials compared in one system: `stickslip.compare`.

A system is given as in a configuration, in numbers, texts with units and shares of critical damping; the belt speed is
one, several, or the ends of a range.
"""

import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from stickslip.config.reader import make_config
from stickslip.config.resolve import points_path, python_document
from stickslip.config.rules import unit_question
from stickslip.config.studies import section_of_call
from stickslip.dataset.build import provenance
from stickslip.engine import Options, Progress
from stickslip.errors import ConfigError, UnitWarning
from stickslip.progress import Watch, watched
from stickslip.studies.border import Border
from stickslip.studies.lines import fine_enough
from stickslip.studies.search import Scan
from stickslip.theory import loss_of_stability, stick_slip_limit
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import as_cells
from stickslip.vocabulary.models import CURVE
from stickslip.vocabulary.quantities import VIBRATING, listed
from stickslip_materials.compare import stick_slip_end as end
from stickslip_materials.compare.result import material_dataset
from stickslip_materials.compare.stick_slip_end import NOT_DETERMINED, QUIET, VIBRATES, Comparing, Floats, QuietSpeeds
from stickslip_materials.fit import CurveFit, MaterialFit, Wanted, fit_materials
from stickslip_materials.fit.files import NO_CURVE, question_of

Amount = float | str
Amounts = Amount | Iterable[Amount]
Points = tuple[ArrayLike, ArrayLike] | CurveFit
Materials = str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | Mapping[str, Points] | Sequence[MaterialFit]

_SLOWER, _FASTER = 10.0, 4.0  # how far beyond what is measured, and what linear theory says, speeds are searched


def compare(
    materials: Materials,
    *,
    mass: Amount,
    stiffness: Amount,
    normal_load: Amount,
    damping: Amount | None = None,
    belt_speed: Amounts | None = None,
    unit: str | None = None,
    columns: Wanted | None = None,
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
        if several are given; without it they are left out. A range ("5..60 mm/s") is one in which a contact is to be
        quiet throughout: margin and probability are those of its slowest speed, the regime is that at the speed where
        it vibrates most (worst_speed).
    unit : of speeds whose heading names none.
    columns : which columns of the files to take, where headings do not say.
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
        implausible, or whose curve says other than most of the curves drawn, come last, without a rank (NaN). Belt
        speeds are searched from a tenth of the slowest measured speed to four times the fastest, or to four times where
        theory sees the end of vibration, if that is more.

    Raises
    ------
    ConfigError
        For files that will not do.
    TypeError, ValueError
        For other wrong input.
    """
    if not 0 < level < 1:
        raise ValueError(f"level: got {level!r}, expected a share above 0 and below 1, such as 0.95")
    if isinstance(draws, bool) or not isinstance(draws, int) or draws < 0:
        raise ValueError(f"draws: got {draws!r}, expected a whole number of at least 0")
    given: dict[str, Amount] = {"mass": mass, "stiffness": stiffness, "normal_load": normal_load}
    given |= {} if damping is None else {"damping": damping}
    wanted = columns or Wanted()
    load = normal_load if wanted.load is None else wanted.load  # by which friction forces are divided
    fits = _fits(materials, replace(wanted, unit=unit or wanted.unit, load=load))
    system, speeds, is_range, question = _conditions(given, _belt_speeds(belt_speed), fits)
    if question:
        warnings.warn(question, UnitWarning, stacklevel=2)
    search, options = fine_enough(
        section_of_call(Border, along="belt_speed", scan=scan, tolerance=tolerance), Options(threads=threads)
    )
    comparing = Comparing(system, speeds, is_range, level, draws, seed, search, options)
    with watched(progress, "curves", options.law) as move:
        ds = _compared(fits, comparing, move)
    written = {f"given_{name}": value for name, value in given.items()
               if isinstance(value, str) and not units.is_number(value)}  # fmt: skip
    return ds.assign_attrs(written | ({"damping_assumed": 1} if damping is None else {}))


# --- the system and the belt speeds, as they are given ----------------------------------------------------------------


def _belt_speeds(given: Amounts | None) -> Any:
    """An axis of belt speeds, as a configuration has it, of a range its two ends; empty without any."""
    several = [given] if isinstance(given, str) or np.ndim(given) == 0 else [*given]  # type: ignore[arg-type, misc]
    if given is None:
        return []
    if not several:
        raise ValueError("belt_speed: got no value")
    numbers = [units.number_or_text(value) if isinstance(value, str) else value for value in several]
    ranges = [value for value in numbers if isinstance(value, str) and ".." in value]
    if not ranges:
        return numbers
    if len(several) > 1:
        raise ValueError(f"belt_speed: got {several!r}, expected several values or one range, not both")
    low, high = units.ends_of("belt_speed", ranges[0])
    return {"start": low, "stop": high, "num": 2}


def _conditions(
    given: Mapping[str, Amount], belt_speeds: Any, fits: Sequence[MaterialFit]
) -> tuple[dict[str, float], tuple[float, ...], bool, str | None]:
    """The system in SI, the belt speeds (m/s) in ascending order, whether they are the ends of a range, and a question
    about what is implausible: about the system with these curves, as of a configuration, or about friction and speeds.
    Raises ConfigError."""
    curves, questions = _curves(fits), [question_of(fit) for fit in fits]
    plausible = [curve for curve, odd in zip(curves, questions, strict=True) if not odd] or curves
    zipped = {name: [getattr(curve, name) for curve in plausible] for name in CURVE}
    system = {name: units.number_or_text(value) if isinstance(value, str) else value for name, value in given.items()}
    axes = {"belt_speed": belt_speeds} if belt_speeds else {}
    written: dict[str, Any] = {"system": system, "axes": axes}
    if not belt_speeds:
        written["system"] = system | {"belt_speed": min(curve.searched[0] for curve in plausible)}
    config = make_config({**written, "axes": {**axes, "material": {"zip": zipped}}}, "compare")
    points = {member.name: member.points().tolist() for axis in config.axes for member in axis.members}
    speeds = tuple(sorted({*points.get("belt_speed", ())}))
    if speeds and not speeds[0] > 0.0:
        raise ValueError(f"belt_speed: got {speeds[0]:g}, expected a speed above 0 m/s")
    known = config.fixed()
    doubts = [unit_question(python_document(written, "compare"), config)]
    doubts += [f"{fit.name}: {question}" for fit, question in zip(fits, questions, strict=True) if question]
    system_in_si = {name: float(known[name]) for name in ("mass", "stiffness", "damping", "normal_load")}
    return system_in_si, speeds, isinstance(belt_speeds, dict), "\n".join(filter(None, doubts)) or None


# --- materials, speeds searched ---------------------------------------------------------------------------------------


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


def _scan(known: Sequence[CurveFit], curves: Sequence[CurveFit], comparing: Comparing) -> Scan:
    """The speeds looked at first."""
    speeds, system = comparing.speeds, comparing.system
    slowest = min(curve.searched[0] for curve in known or curves)  # a tenth of the slowest measured speed above 0
    fastest = max(curve.speeds[1] for curve in known or curves)
    for curve in known:
        if curve.declines:
            for limit in (loss_of_stability, stick_slip_limit):
                speed = float(limit(curve.a2, curve.a3, curve.a4, system["damping"], system["normal_load"]))
                fastest = max(fastest, speed) if np.isfinite(speed) else fastest
    if speeds:
        slowest, fastest = min(slowest, min(speeds) / _SLOWER), max(fastest, *speeds)
    return Scan(slowest, _FASTER * fastest, comparing.search.scan, "log")


# --- results ----------------------------------------------------------------------------------------------------------


def _compared(fits: Sequence[MaterialFit], comparing: Comparing, progress: Progress | None) -> xr.Dataset:
    """As `compare`, of fitted curves. progress : called with curves done, and in all."""
    curves = _curves(fits)
    doubts = [question_of(fit) or "" for fit in fits]
    drawn = {i: comparing.draw(curve) for i, curve in enumerate(curves) if curve.determined and not doubts[i]}
    known = [i for i, allowed in drawn.items() if allowed or not curves[i].has_intervals]
    for i in drawn.keys() - {*known}:
        doubts[i] = "No curve can be drawn from what its fit leaves open."
    scan = _scan([curves[i] for i in known], curves, comparing)
    table = _blank(len(fits), comparing)
    if known:
        friction = end.friction_of([curves[i] for i in known])
        borders = end.quiet_above(friction, comparing.system, scan, comparing.search.tolerance, comparing.options)
        for name, of_known in _at_speeds(friction, borders, comparing, scan).items():
            table[name][known] = of_known
        for place, (i, ends) in enumerate(zip(known, zip(*borders.between(), strict=True), strict=True)):
            draws = drawn[i]
            scatter = end.scatter_of(draws, comparing, scan) if comparing.draws and draws else {}
            if doubt := _contradiction(scatter, ends):
                doubts[i], scatter = doubt, {name: values[0] for name, values in _blank(1, comparing).items()}
            for name, value in scatter.items():
                table[name][i] = value
            if progress:
                progress(len(known) + (place + 1) * comparing.draws, len(known) * (1 + comparing.draws))
    order = _rank(table, [fit.name for fit in fits])
    ordered = {name: values[order] for name, values in table.items()}
    fits, doubts = [fits[i] for i in order], [doubts[i] for i in order]
    return material_dataset(fits, ordered, doubts, _attributes(fits, comparing, scan), comparing.speeds)


def _contradiction(scatter: dict[str, float | Floats], ends: tuple[float, float]) -> str:
    """Why a border, whose ends these are, cannot stand beside what curves drawn say; empty where it can. An interval
    that misses it by no more than the tolerance of the borders of drawn curves is widened to it."""
    if not scatter:
        return ""
    (least, most), (low, high) = ends, (float(scatter[f"quiet_above_{which}"]) for which in ("low", "high"))
    is_outside = least > high * (1.0 + end.DRAWN_TO) or most * (1.0 + end.DRAWN_TO) < low
    chance = np.ravel(scatter.get("quiet_probability", 1.0))[0]  # at the slowest belt speed
    if is_outside or most == 0.0 and chance < 0.5:
        return "The border of the fitted curve is none of those that most of the curves drawn have."
    scatter |= {"quiet_above_low": min(low, most), "quiet_above_high": max(high, least)}
    return ""


def _blank(count: int, comparing: Comparing) -> dict[str, Floats]:
    """The results of materials of which nothing is determined, by names of MATERIAL_VARIABLES: over materials, and over
    belt speeds where there are several."""
    names = ["rank", "quiet_above", "quiet_state", *(["worst_speed"] if comparing.is_range else [])]
    names += ["quiet_above_low", "quiet_above_high"] if comparing.draws else []
    at_speeds = ["regime", "frequency", "stick_fraction", "margin", *(["quiet_probability"] if comparing.draws else ())]
    shape = (count, len(comparing.speeds)) if comparing.several_speeds else (count,)
    table = {name: np.full(shape, np.nan) for name in at_speeds} if comparing.speeds else {}
    return table | {name: np.full(count, NOT_DETERMINED if name == "quiet_state" else np.nan) for name in names}


def _at_speeds(
    friction: Mapping[str, Floats], borders: QuietSpeeds, comparing: Comparing, scan: Scan
) -> dict[str, Floats]:
    """The borders of curves, and their motion at the belt speeds; of a range at the speed where one vibrates most, its
    slowest if it is quiet throughout."""
    values = {"quiet_above": borders.speed, "quiet_state": np.asarray(borders.state, np.float64)}
    if not comparing.speeds:
        return values
    places = np.array(comparing.speeds)
    if comparing.is_range:
        low, high = places
        places = np.array([low, *scan.places[(scan.places > low) & (scan.places < high)], high])
    column = {name: values[:, None] for name, values in friction.items()}
    results = end.regimes(as_cells({**comparing.system, **column, "belt_speed": places}), comparing.options)
    names = ("regime", "frequency", "stick_fraction", "velocity_amplitude")
    motion = {name: np.asarray(results[name], np.float64).reshape(-1, places.size) for name in names}
    amplitude = motion.pop("velocity_amplitude")
    if comparing.is_range:
        vibrates = np.isin(motion["regime"], end.VIBRATING_CODES)
        worst = np.argmax(np.where(vibrates, 1.0 + np.nan_to_num(amplitude), 0.0), axis=1)[:, None]
        motion = {name: np.take_along_axis(values, worst, 1) for name, values in motion.items()}
        motion["worst_speed"] = places[worst]
    margin = np.array(comparing.speeds) / borders.speed[:, None]
    motion["margin"] = np.where(borders.state[:, None] == QUIET, np.inf, margin)
    at = slice(None) if comparing.several_speeds else 0
    return values | {name: array[:, at] for name, array in motion.items()}


def _rank(table: dict[str, Floats], names: Sequence[str]) -> list[int]:
    """The order of materials: quiet throughout first, then by speed, vibrating throughout and not determined last.
    Ranks, which may be equal, are filled in."""
    groups = [{QUIET: 0, VIBRATES: 2, NOT_DETERMINED: 3}.get(int(state), 1) for state in table["quiet_state"]]
    keys = [(group, speed if group == 1 else 0.0) for group, speed in zip(groups, table["quiet_above"], strict=True)]
    order = sorted(range(len(names)), key=lambda i: (keys[i], names[i]))
    for i in order:
        if groups[i] < 3:
            table["rank"][i] = 1 + sum(key < keys[i] for key in keys)
    return order


def _attributes(fits: Sequence[MaterialFit], comparing: Comparing, scan: Scan) -> dict[str, Any]:
    """Provenance, what was asked, and a configuration that finds the same borders, all of them."""
    system, speeds, friction = comparing.system, comparing.speeds, end.friction_of(_curves(fits))
    zipped = {name: ["none" if np.isnan(value) else value for value in values.tolist()]
              for name, values in friction.items() if not np.isnan(values).all()}  # fmt: skip
    title = f"{len(fits)} materials compared"
    data = {
        "title": title,
        "system": {**system, "belt_speed": speeds[0] if speeds else scan.low},
        "axes": {"material": {"zip": zipped, "labels": [fit.name for fit in fits]}},
        "border": {"along": "belt_speed", "between": [scan.low, scan.high], "scan": scan.points,
                   "tolerance": comparing.search.tolerance},
    }  # fmt: skip
    attributes: dict[str, Any] = {
        **provenance(make_config(data).to_yaml(), title=title, action="compare materials"),
        **{f"system_{name}": value for name, value in system.items()},
        "searched_from": scan.low, "searched_to": scan.high, "searched_points": scan.points,
        "confidence": comparing.level, "draws": comparing.draws, "seed": comparing.seed,
        "vibrating_regimes": " ".join(VIBRATING),
        "files": "\n".join(dict.fromkeys(str(fit.path) for fit in fits)),
    }  # fmt: skip
    if synthetic := [fit.name for fit in fits if fit.points.are_synthetic]:
        attributes["synthetic"] = listed(synthetic, "and")
    if comparing.is_range:
        return attributes | {"speed_range_from": speeds[0], "speed_range_to": speeds[1]}
    return attributes | ({"belt_speed": speeds[0]} if len(speeds) == 1 else {})
