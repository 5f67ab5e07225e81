"""Materials compared in one system: `stickslip.compare`.

A system is given as people do, in numbers, texts with units and shares of critical damping; the belt speed is one,
several, or the ends of a range.
"""

import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from stickslip.config.describe import unit_question
from stickslip.config.reader import make_config
from stickslip.config.resolve import points_path
from stickslip.config.studies import section_of_call
from stickslip.config.yaml import Document
from stickslip.dataset.build import provenance
from stickslip.engine import Options, Progress
from stickslip.errors import ConfigError, QuantityError, UnitWarning
from stickslip.progress import Watch, watched
from stickslip.studies.border import Border
from stickslip.studies.lines import fine_enough
from stickslip.studies.search import Scan
from stickslip.theory import loss_of_stability, stick_slip_limit
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import as_cells, scales_of
from stickslip.vocabulary.flags import VIBRATING
from stickslip.vocabulary.models import CURVE
from stickslip.vocabulary.quantities import PARAMETERS
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
    speed_range: tuple[Amount, Amount] | None = None,
    between: tuple[Amount, Amount] | None = None,
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
        if several are given; without it they are left out.
    speed_range : instead of it, the ends of a range in which a contact is to be quiet throughout: margin and
        probability are those of its slowest speed, the regime is that at the speed where it vibrates most
        (worst_speed). A text such as "5..60 mm/s" as belt_speed says the same.
    between : belt speeds searched; None takes a tenth of the slowest measured speed to four times the fastest, or to
        four times where theory sees the end of vibration, if that is more.
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
        implausible, or whose curve says other than most of the curves drawn, come last, without a rank (NaN).

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
    given = {"mass": mass, "stiffness": stiffness, "damping": 0.0 if damping is None else damping,
             "normal_load": normal_load}  # fmt: skip
    search, options = fine_enough(
        section_of_call(Border, along="belt_speed", scan=scan, tolerance=tolerance), Options(threads=threads)
    )
    speeds, is_range = _speeds_of(belt_speed, speed_range)
    searched = None if between is None else _ends("between", between)
    comparing = Comparing(_system_of(given), speeds, is_range, searched, level, draws, seed, search, options)
    wanted = columns or Wanted()
    load = normal_load if wanted.load is None else wanted.load  # by which friction forces are divided
    fits = _fits(materials, replace(wanted, unit=unit or wanted.unit, load=load))
    if question := _question(fits, given | {"belt_speed": belt_speed}, comparing):
        warnings.warn(question, UnitWarning, stacklevel=2)
    with watched(progress, "curves", options.law) as move:
        ds = _compared(fits, comparing, move)
    written = {
        f"given_{name}": value for name, value in given.items() if isinstance(value, str) and not units.is_number(value)
    }
    return ds.assign_attrs(written | ({"damping_assumed": 1} if damping is None else {}))


# --- the system, as it is given ---------------------------------------------------------------------------------------


def _system_of(given: Mapping[str, Amount]) -> dict[str, float]:
    """The system, in SI; damping may be in percent of critical. Raises ValueError."""
    damping = given["damping"]
    text = damping.strip().removesuffix("of critical").strip() if isinstance(damping, str) else ""
    if not text.endswith("%"):
        return {name: _quantity(name, value) for name, value in given.items()}
    share = text.removesuffix("%").strip()
    if not (units.is_number(share) and float(share) >= 0.0):
        expected = "expected a share of critical damping such as '3 %', at least 0"
        raise ValueError(f"damping: got {damping!r}, {expected}")
    system = {name: 0.0 if name == "damping" else _quantity(name, value) for name, value in given.items()}
    return system | {"damping": float(share) / 100.0 * float(scales_of(system).critical_damping)}


def _speeds_of(belt_speed: Amounts | None, speed_range: tuple[Amount, Amount] | None) -> tuple[tuple[float, ...], bool]:
    """The belt speeds (m/s), in ascending order, and whether they are the ends of a range."""
    if belt_speed is not None and speed_range is not None:
        raise TypeError("got belt_speed and speed_range, expected one of them")
    if speed_range is not None:
        return _ends("speed_range", speed_range), True
    several = _each(belt_speed)
    if belt_speed is not None and not several:
        raise ValueError("belt_speed: got no value")
    if ranges := [value for value in several if isinstance(value, str) and ".." in value]:
        if len(several) > 1:
            raise ValueError(f"belt_speed: got {several!r}, expected several values or one range, not both")
        return _ends("belt_speed", units.ends_of("belt_speed", ranges[0])), True
    return tuple(sorted({*_speeds("belt_speed", several)})), False


def _ends(called: str, ends: tuple[Amount, Amount]) -> tuple[float, float]:
    """The range between two ends, the lower one first. Raises TypeError or ValueError."""
    if not isinstance(ends, tuple | list) or len(ends) != 2:
        raise TypeError(f"{called}: got {ends!r}, expected the two ends of a range")
    low, high = _speeds(called, ends)
    if not low < high:
        hint = "; swap the ends" if low > high else ""
        raise ValueError(f"{called}: got {ends[0]} to {ends[1]}, expected the lower end first and one above it{hint}")
    return low, high


def _speeds(called: str, given: Sequence[Amount]) -> list[float]:
    """Belt speeds, of which numbers without a unit take that of the others. Raises ValueError."""
    numbers = [float(value) if units.is_number(value) else value for value in given]
    try:
        alike: list[Amount] = [*units.each_with_unit(numbers, PARAMETERS["belt_speed"].units)]
    except QuantityError as error:
        raise ValueError(f"{called}: got {given!r}, expected {error.expected}") from None
    speeds = [_quantity("belt_speed", value, called) for value in alike]
    if speeds and not min(speeds) > 0:
        raise ValueError(f"{called}: got {min(speeds):g}, expected a speed above 0 m/s")
    return speeds


def _quantity(name: str, value: Amount, called: str = "") -> float:
    """A quantity in SI, from a number, also as text, or a text with a unit. Raises ValueError."""
    if not isinstance(value, str | int | float | np.number) or (isinstance(value, str) and ".." in value):
        raise ValueError(f"{called or name}: got {value!r}, expected one value")
    try:
        return PARAMETERS[name].read(float(value) if units.is_number(value) else value)
    except QuantityError as error:
        hint = f"; {error.hint}" if error.hint else ""
        raise ValueError(f"{called or name}: got {value!r}, expected {error.expected}{hint}") from None


def _each(given: Amounts | None) -> list[Amount]:
    """The values that were given."""
    if given is None or isinstance(given, str) or np.ndim(given) == 0:  # type: ignore[arg-type]
        return [] if given is None else [given]  # type: ignore[list-item]
    return [*given]  # type: ignore[misc]


# --- materials, doubts, speeds searched -------------------------------------------------------------------------------


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


def _question(fits: Sequence[MaterialFit], given: Mapping[str, Amounts | None], comparing: Comparing) -> str | None:
    """A question about a system that is implausible with these curves, as a configuration is asked about it, and about
    implausible friction and speeds."""
    curves = _curves(fits)
    questions = [question_of(fit) for fit in fits]
    plausible = [curve for curve, odd in zip(curves, questions, strict=True) if not odd] or curves
    zipped = {name: [getattr(curve, name) for curve in plausible] for name in CURVE}
    slowest = float(min(curve.searched[0] for curve in plausible))
    system = {**comparing.system, "belt_speed": comparing.speeds[-1] if comparing.speeds else slowest}
    plain = [name for name, values in given.items() if any(not str(v).strip("+-.0123456789eE ") for v in _each(values))]
    written = {  # what was given with a unit needs no question about it
        name: value if name in plain else f"{value!r} {units.spelled(PARAMETERS[name].units)}"
        for name, value in system.items()
    }
    config = make_config({"system": written, "axes": {"material": {"zip": zipped}}})
    question = unit_question(Document("compare", {"system": written}), config)
    odd = [f"{fit.name}: {question}" for fit, question in zip(fits, questions, strict=True) if question]
    return "\n".join([*([question] if question else []), *odd]) or None


def _scan(known: Sequence[CurveFit], curves: Sequence[CurveFit], comparing: Comparing) -> Scan:
    """The speeds looked at first. Raises ValueError."""
    speeds, system = comparing.speeds, comparing.system
    if comparing.between is not None:
        low, high = comparing.between
        if speeds and not low <= min(speeds) <= max(speeds) <= high:
            raise ValueError(f"between: got {low:g} to {high:g} m/s, expected it to hold the belt speed asked about")
        return Scan(low, high, comparing.search.scan, "log")
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
    if most == 0.0 and np.ravel(scatter.get("quiet_probability", 1.0))[0] < 0.5:  # at the slowest belt speed
        return "The fitted curve vibrates at no speed; most of the curves that the points allow do at the belt speed."
    if not (least <= high * (1.0 + end.DRAWN_TO) and most * (1.0 + end.DRAWN_TO) >= low):
        return "The border of the fitted curve lies outside of the interval that the points leave."
    scatter |= {"quiet_above_low": min(low, most), "quiet_above_high": max(high, least)}
    return ""


def _blank(count: int, comparing: Comparing) -> dict[str, Floats]:
    """The results of materials of which nothing is determined, by names of MATERIAL_VARIABLES: over materials, and over
    belt speeds where there are several."""
    names = ["rank", "quiet_above", "quiet_state", *(["worst_speed"] if comparing.is_range else [])]
    names += ["quiet_above_low", "quiet_above_high", "draws_falling", "draws_used"] if comparing.draws else []
    at_speeds = ["regime", "frequency", "stick_fraction", "margin", *(end.CHANCES if comparing.draws else ())]
    shape = (count, len(comparing.speeds)) if comparing.several_speeds else (count,)
    table = {name: np.full(shape, np.nan) for name in at_speeds} if comparing.speeds else {}
    return table | {
        name: np.full(count, {"quiet_state": NOT_DETERMINED, "draws_used": 0.0}.get(name, np.nan)) for name in names
    }


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
    if comparing.is_range:
        return attributes | {"speed_range_from": speeds[0], "speed_range_to": speeds[1]}
    return attributes | ({"belt_speed": speeds[0]} if len(speeds) == 1 else {})
