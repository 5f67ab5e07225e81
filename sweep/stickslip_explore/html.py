"""Words of the page: legend, numbers of a cell, and the command that reproduces them."""

import shlex
from collections.abc import Collection, Mapping
from math import isfinite, isnan, nan
from typing import Any

from jinja2 import Environment, PackageLoader

from stickslip.plots.palette import BLUE, FLAG_COLOURS, ORANGE
from stickslip.vocabulary.display_units import Unit, number, quantity, spoken, unit_for
from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.quantities import PARAMETERS, REGIME_MESSAGES, STATUS_MESSAGES, VARIABLES, flag_label
from stickslip_explore.maps import MapPicture
from stickslip_explore.motions import CellMotions, Motion
from stickslip_explore.view import At, Source, View, settings

LINES: dict[str, tuple[str, str, float]] = {  # by motion: colour, dash, width
    "stick": (BLUE, "solid", 1.6),
    "sliding": (ORANGE, "dashed", 1.6),
}
_NUMBERS = (
    "frequency", "period", "stick_fraction", "breakaway_time", "velocity_amplitude", "displacement_amplitude",
    "cycle_force_max", "cycle_force_min", "spring_force_max", "slip_speed_max", "acceleration_max", "energy_per_cycle",
    "settling_time", "restick_margin", *(row.name for model in MODELS for row in model.results), "damping_ratio",
)  # fmt: skip
_RARE = ("delta", "ageing_rate", "ageing_time", "contact_time", "displacement", "velocity", "mu_static", "mu_stop")
_PARTS = Environment(loader=PackageLoader("stickslip_explore", ""), autoescape=True, trim_blocks=True).get_template(
    "parts.html"
)


def part(name: str, *arguments: Any) -> str:
    """A part of the page as the template `parts.html` has it, all text in it escaped."""
    return str(getattr(_PARTS.module, name)(*arguments)).strip()


STYLE = part("style", LINES, FLAG_COLOURS["regime"])  # of all words


def legend_html(shown: MapPicture) -> str:
    """The legend: meanings of the colours of a map."""
    return part("legend", shown, ", ".join(shown.palette[::16]))


def place_words(shown: MapPicture, at: At) -> str:
    """The place of a cell: `stiffness 50 N/m, belt speed 0.4 m/s`."""
    return ", ".join(f"{spoken(side.name)} {side.text(at[side.name])}" for side in (shown.y, shown.x))


def numbers_html(motions: Mapping[str, Motion], units: Mapping[str, Unit] | None = None) -> str:
    """Regime and key numbers of motions side by side, by names of `LINES`, in the units that a map has by variable."""
    columns = [
        {"line": line, "label": motion.label, "style": motion.regime,
         "regime": flag_label(motion.regime).replace("_", "-"),
         "meaning": f"{REGIME_MESSAGES[motion.regime]}: {STATUS_MESSAGES[motion.status]}"}
        for line, motion in motions.items()
    ]  # fmt: skip
    rows = []
    for name in _NUMBERS:
        values = [motion.results.get(name, nan) for motion in motions.values()]
        if any(map(isfinite, values)):
            row = VARIABLES[name]
            unit = (units or {}).get(name) or unit_for(row.units, values)
            texts = ["–" if isnan(value) else f"{number(unit.of(value))} {unit.name}".rstrip() for value in values]
            rows.append((name.replace("_", " "), row.long_name, texts))
    return part("numbers", columns, rows, sorted({motion.why for motion in motions.values() if motion.why}))


def cell_html(motions: CellMotions, where: str, sides: Collection[str] = (), remark: str = "") -> str:
    """The place of a cell, its parameters, and what is known of its unstable cycle. sides : what `where` says."""
    parameters = ", ".join(
        f"{spoken(name)} {quantity(value, PARAMETERS[name].units)}"
        for name, value in motions.cell.items()
        if name not in sides and isfinite(value) and (name not in _RARE or value != PARAMETERS[name].default)
    )
    speed = None if motions.cycle is None else quantity(motions.cycle.velocity_amplitude, "m s-1")
    return part("cell", where, parameters, speed, any(motion.late for motion in motions.motions.values()), remark)


def simulate_command(source: Source, view: View, at: At, motions: CellMotions) -> str:
    """The line for the shell that computes the motion of a cell from stick, to the last bit."""
    given = [word for setting in settings(source, view, at) for word in ("--at", setting)]
    times, away = motions.stick.time, motions.stick.results["breakaway_time"]
    duration = times[-1] if times.size else 1.0
    if isfinite(away) and isnan(motions.cell["velocity"]):
        duration += away
    return shlex.join(["stickslip", "simulate", source.name, *given, "-t", f"{duration:.4g}", "--plot", "cell.png"])
