"""Words of the page: legend, numbers of a cell, the command that reproduces them, and tables to download."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from math import isfinite, isnan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import xarray as xr
from jinja2 import Environment, PackageLoader

from stickslip.config.select import cell_of
from stickslip.dataset.axis import spoken
from stickslip.dataset.build import variable_of
from stickslip.dataset.export import write_table
from stickslip.errors import ConfigError
from stickslip.explore.maps import Picture
from stickslip.explore.motions import CellMotions, Motion, regime_of
from stickslip.explore.source import Source
from stickslip.explore.view import View, cell_config, settings
from stickslip.vocabulary.display_units import Unit, number, quantity, unit_for
from stickslip.vocabulary.flags import REGIME_MESSAGES, STATUS_MESSAGES, flag_label
from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import TRACE_VARIABLES, VARIABLES

_NUMBERS = (
    "frequency", "period", "stick_fraction", "breakaway_time", "velocity_amplitude", "displacement_amplitude",
    "cycle_force_max", "cycle_force_min", "spring_force_max", "slip_speed_max", "acceleration_max", "energy_per_cycle",
    "settling_time", "restick_margin", *(row.name for model in MODELS for row in model.results), "damping_ratio",
)  # fmt: skip
_DIGITS = 6  # of what a command says
_RARE = ("delta", "ageing_rate", "ageing_time", "contact_time", "displacement", "velocity", "mu_static", "mu_stop")
_PARTS = Environment(loader=PackageLoader("stickslip", "explore"), autoescape=True, trim_blocks=True).get_template(
    "parts.html"
)


def part(name: str, *arguments: Any) -> str:
    """A part of the page as the template `parts.html` has it, all text in it escaped."""
    return str(getattr(_PARTS.module, name)(*arguments)).strip()


def legend_html(shown: Picture) -> str:
    """The legend: meanings of the colours of a map."""
    stops = ", ".join(shown.palette[:: max(1, len(shown.palette) // 16)][:16])
    return part("legend", shown, stops)


def place_words(shown: Picture, at: Mapping[str, float | int]) -> str:
    """The place of a cell: `stiffness 50 N/m, belt speed 0.4 m/s`."""
    words = []
    for side in (shown.y, shown.x):
        value = at[side.name]
        text = side.labels[int(value)] if side.kind == "listed" else side.unit.text(float(value), 4)
        words.append(f"{spoken(side.name)} {text}")
    return ", ".join(words)


def numbers_html(columns: Sequence[tuple[str, str, Motion]], units: Mapping[str, Unit] | None = None) -> str:
    """Regime and key numbers of motions side by side: names of styles, headings, motions.

    units : by variable, those in which the map tells it; others have what suits their largest value.
    """
    motions = [motion for *_, motion in columns]
    regimes = [
        (motion.regime, flag_label(motion.regime).replace("_", "-"),
         f"{REGIME_MESSAGES[motion.regime]}: {STATUS_MESSAGES[motion.status]}") for motion in motions
    ]  # fmt: skip
    rows = []
    for name in _NUMBERS:
        values = [motion.results[name] for motion in motions]
        if any(map(isfinite, values)):
            row = VARIABLES[name]
            unit = (units or {}).get(name) or unit_for(row.units, values)
            rows.append((name.replace("_", " "), row.long_name, [_text(unit, value) for value in values]))
    return part("numbers", columns, regimes, rows, sorted({motion.why for motion in motions if motion.why}))


def _text(unit: Unit, value: float) -> str:
    return "–" if isnan(value) else f"{number(unit.of(value))} {unit.name}".rstrip()


def cell_html(motions: CellMotions, where: str, sides: Collection[str] = ()) -> str:
    """Return which cell it is, and what is known of its unstable cycle. sides : what `where` says already."""
    parameters = ", ".join(
        f"{spoken(name)} {quantity(value, PARAMETERS[name].units)}"
        for name, value in motions.cell.items()
        if name not in sides and isfinite(value) and (name not in _RARE or value != PARAMETERS[name].default)
    )
    speed = None if motions.cycle is None else quantity(motions.cycle.velocity_amplitude, "m s-1")
    return part("cell", where, parameters, speed, any(motion.late for motion in motions.motions))


def simulate_command(source: Source, view: View, at: Mapping[str, float | int], motions: CellMotions) -> str:
    """The line for the shell that computes the motion of a cell from stick."""
    given = [word for setting in _short(source, view, at, motions) for word in ("--at", setting)]
    times, away = motions.stick.time, motions.stick.results["breakaway_time"]
    duration = times[-1] if times.size else 1.0
    if isfinite(away) and isnan(motions.cell["velocity"]):
        duration += away
    return shlex.join(["stickslip", "simulate", source.name, *given, "-t", f"{duration:.4g}", "--plot", "cell.png"])


def _short(source: Source, view: View, at: Mapping[str, float | int], motions: CellMotions) -> list[str]:
    """The settings of a cell in few digits, unless that makes it a cell of another regime."""

    def few(values: Mapping[str, float | int]) -> dict[str, Any]:
        return {name: v if isinstance(v, int) else float(f"{v:.{_DIGITS}g}") for name, v in values.items()}

    try:
        config = cell_config(source, replace(view, values=few(view.values)), few(at))
        same = regime_of(cell_of(config), source.options) == motions.stick.regime
    except ConfigError:  # what is rounded may be beyond a bound
        same = False
    return settings(source, view, at, _DIGITS if same else None)


# --- tables -----------------------------------------------------------------------------------------------------------


def map_csv(shown: Picture) -> str:
    """The cells behind a picture as comma-separated values, in SI, as `stickslip export` writes them."""
    return _csv(shown.cells)


def motions_csv(columns: Sequence[tuple[str, Motion]]) -> str:
    """Samples of motions as comma-separated values: which motion, time since break-away, all that is known."""
    known = [(head, motion) for head, motion in columns if motion.samples]
    heads = np.concatenate([np.full(motion.time.size, head) for head, motion in known])
    time = np.concatenate([motion.time for _, motion in known])
    about = {"units": "s", "long_name": "time since the first break-away, or since the start"}
    variables = {
        name: variable_of(row, ("sample",), np.concatenate([motion.samples[name] for _, motion in known]))
        for name, row in TRACE_VARIABLES.items()
        if all(name in motion.samples for _, motion in known)
    }
    along = {"motion": ("sample", heads), "time": ("sample", time, about)}
    return _csv(xr.Dataset(variables, along))


def _csv(ds: xr.Dataset) -> str:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        write_table(ds, path)
        return path.read_text(encoding="utf-8")
