"""What the page says in words: legend, numbers of a cell, what reproduces them, tables to download."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from html import escape
from math import isfinite
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray as xr

from stickslip.config.select import cell_of
from stickslip.dataset.axis import spoken
from stickslip.dataset.build import variable_of
from stickslip.dataset.export import write_table
from stickslip.errors import ConfigError
from stickslip.explore.maps import Picture
from stickslip.explore.motions import CellMotions, Motion, regime_of
from stickslip.explore.readable import Unit, quantity, unit_for
from stickslip.explore.subject import Subject
from stickslip.explore.view import View, cell_config, settings
from stickslip.vocabulary.flags import REGIME_MESSAGES, STATUS_MESSAGES, flag_label
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import TRACE_VARIABLES, VARIABLES

_NUMBERS = (
    "frequency", "period", "stick_fraction", "breakaway_time", "velocity_amplitude", "displacement_amplitude",
    "cycle_force_max", "cycle_force_min", "spring_force_max", "slip_speed_max", "acceleration_max", "energy_per_cycle",
    "settling_time", "restick_margin", "mu_reversal", "tendency", "damping_ratio",
)  # fmt: skip
_DIGITS = 6  # of what a command says
_RARE = ("delta", "ageing_rate", "ageing_time", "contact_time", "displacement", "velocity", "mu_static", "mu_stop")


def legend_html(shown: Picture) -> str:
    """What the colours of a map mean."""
    if shown.ticks:
        stops = ", ".join(shown.palette[:: max(1, len(shown.palette) // 16)][:16])
        words = "".join(f"<span>{escape(text)}</span>" for _, text in shown.ticks)
        bar = f'<div class="scale"><div class="bar" style="background:linear-gradient(to right, {stops})"></div>'
        found = f'{bar}<div class="ticks">{words}</div></div>'
    else:
        found = ""
    entries = "".join(
        f'<span class="entry">{"".join(_swatch(colour) for colour in colours)}{escape(label)}</span>'
        for label, colours in shown.legend
    )
    note = f'<span class="note">{escape(shown.note)}</span>' if shown.note else ""
    return f'<div class="legend"><b>{escape(shown.title)}</b> {found}{entries}{note}</div>'


def _swatch(colour: str) -> str:
    return f'<i style="background:{colour}"></i>'


def place_words(shown: Picture, at: Mapping[str, float | int]) -> str:
    """Where a cell lies: `stiffness 50 N/m, belt speed 0.4 m/s`."""
    words = []
    for side in (shown.y, shown.x):
        value = at[side.name]
        text = side.labels[int(value)] if side.kind == "listed" else side.unit.text(float(value))
        words.append(f"{spoken(side.name)} {text}")
    return ", ".join(words)


def numbers_html(columns: Sequence[tuple[str, str, Motion]], units: Mapping[str, Unit] | None = None) -> str:
    """Regime and key numbers of motions side by side: names of styles, headings, motions.

    units : by variable, those in which the map tells it; others have what suits their largest value.
    """
    if not columns:
        return '<p class="hint">Click a cell of the map: its motion appears here.</p>'
    heads = "".join(f'<th><i class="line {style}"></i>{escape(head)}</th>' for style, head, _ in columns)
    rows = [f"<tr><th></th>{heads}</tr>", _regimes([motion for *_, motion in columns])]
    for name in _NUMBERS:
        values = [motion.results[name] for *_, motion in columns]
        if any(map(isfinite, values)):
            row = VARIABLES[name]
            unit = (units or {}).get(name) or unit_for(row.units, values)
            cells = "".join(f"<td>{escape(unit.text(value))}</td>" for value in values)
            rows.append(f'<tr><th title="{escape(row.long_name)}">{escape(name.replace("_", " "))}</th>{cells}</tr>')
    faults = {motion.why for *_, motion in columns if motion.why}
    said = "".join(f'<p class="hint">{escape(why)}</p>' for why in sorted(faults))
    return f'<table class="numbers">{"".join(rows)}</table>{said}'


def _regimes(motions: Iterable[Motion]) -> str:
    cells = "".join(
        f'<td title="{escape(REGIME_MESSAGES[motion.regime])}: {escape(STATUS_MESSAGES[motion.status])}">'
        f'<b class="regime {motion.regime}">{escape(flag_label(motion.regime).replace("_", "-"))}</b></td>'
        for motion in motions
    )
    return f"<tr><th>regime</th>{cells}</tr>"


def cell_html(motions: CellMotions, where: str, sides: Collection[str] = ()) -> str:
    """Which cell it is, and what is known of its unstable cycle. sides : what `where` says already."""
    parameters = ", ".join(
        f"{spoken(name)} {quantity(value, PARAMETERS[name].units)}"
        for name, value in motions.cell.items()
        if name not in sides and isfinite(value) and (name not in _RARE or value != PARAMETERS[name].default)
    )
    said = [f"<b>{escape(where)}</b>", f'<span class="note">{escape(parameters)}</span>']
    if motions.cycle is not None:
        speed = quantity(motions.cycle.velocity_amplitude, "m s-1")
        said.append(
            f"unstable cycle (dotted), velocity amplitude {escape(speed)}: vibration inside dies out, outside grows"
        )
    if any(motion.late for motion in motions.motions):
        said.append("the slow growth from near sliding is left out; its end is shown")
    return "<br>".join(said)


# --- what reproduces it -----------------------------------------------------------------------------------------------


def simulate_command(subject: Subject, view: View, at: Mapping[str, float | int], motions: CellMotions) -> str:
    """The line for the shell that computes the motion of a cell from stick."""
    given = [word for setting in _short(subject, view, at, motions) for word in ("--at", setting)]
    shown = motions.stick.time
    away = motions.stick.results["breakaway_time"]
    duration = (shown[-1] if shown.size else 1.0) + (away if isfinite(away) and not _is_from_start(motions) else 0.0)
    words = ["stickslip", "simulate", subject.source, *given, "-t", f"{duration:.4g}", "--plot", "cell.png"]
    return shlex.join(words)


def _short(subject: Subject, view: View, at: Mapping[str, float | int], motions: CellMotions) -> list[str]:
    """The settings of a cell in few digits, unless that makes it a cell of another regime."""
    rounded = settings(subject, view, at, _DIGITS)
    nearby = {name: value if isinstance(value, int) else _few(value) for name, value in at.items()}
    values = {name: _few(value) for name, value in view.values.items()}
    try:
        config = cell_config(subject, replace(view, values=values), nearby)
        regime = regime_of(cell_of(config), subject.options)
    except ConfigError:  # what is rounded may be beyond a bound
        regime = ""
    return rounded if regime == motions.stick.regime else settings(subject, view, at)


def _few(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def _is_from_start(motions: CellMotions) -> bool:
    return not np.isnan(motions.cell["velocity"])


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
