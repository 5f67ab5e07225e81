"""What the page says in words: legend, numbers of a cell, what reproduces them, tables to download."""

from __future__ import annotations

import csv
import shlex
from collections.abc import Collection, Iterable, Mapping, Sequence
from html import escape
from io import StringIO
from math import isfinite

import numpy as np

from stickslip.dataset.axis import spoken
from stickslip.explore.maps import Picture, Side
from stickslip.explore.motions import CellMotions, Motion
from stickslip.explore.readable import quantity
from stickslip.explore.subject import Subject
from stickslip.explore.view import View, settings
from stickslip.vocabulary import units
from stickslip.vocabulary.flags import REGIME_MESSAGES, STATUS_MESSAGES, flag_label
from stickslip.vocabulary.quantities import PARAMETERS, SEARCHABLE
from stickslip.vocabulary.results import TRACE_VARIABLES, VARIABLES

_NUMBERS = (
    "frequency", "period", "stick_fraction", "breakaway_time", "velocity_amplitude", "displacement_amplitude",
    "cycle_force_max", "cycle_force_min", "spring_force_max", "slip_speed_max", "acceleration_max", "energy_per_cycle",
    "settling_time", "restick_margin", "mu_reversal", "tendency", "damping_ratio",
)  # fmt: skip
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


def numbers_html(columns: Sequence[tuple[str, str, Motion]]) -> str:
    """Regime and key numbers of motions side by side: names of styles, headings, motions."""
    if not columns:
        return '<p class="hint">Click a cell of the map: its motion appears here.</p>'
    heads = "".join(f'<th><i class="line {style}"></i>{escape(head)}</th>' for style, head, _ in columns)
    rows = [f"<tr><th></th>{heads}</tr>", _regimes([motion for *_, motion in columns])]
    for name in _NUMBERS:
        values = [motion.results[name] for *_, motion in columns]
        if any(map(isfinite, values)):
            row = VARIABLES[name]
            cells = "".join(f"<td>{escape(quantity(value, row.units))}</td>" for value in values)
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
            f"unstable cycle (dotted): vibration with less than about {escape(speed)} dies out, with more it grows"
        )
    if any(motion.late for motion in motions.motions):
        said.append("the slow growth from near sliding is left out; its end is shown")
    return "<br>".join(said)


# --- what reproduces it -----------------------------------------------------------------------------------------------


def simulate_command(subject: Subject, view: View, at: Mapping[str, float | int], motions: CellMotions) -> str:
    """The line for the shell that computes the motion of a cell from stick."""
    given = [word for setting in settings(subject, view, at) for word in ("--at", setting)]
    shown = motions.stick.time
    away = motions.stick.results["breakaway_time"]
    duration = (shown[-1] if shown.size else 1.0) + (away if isfinite(away) and not _is_from_start(motions) else 0.0)
    words = ["stickslip", "simulate", subject.source, *given, "-t", f"{duration:.4g}", "--plot", "cell.png"]
    return shlex.join(words)


def _is_from_start(motions: CellMotions) -> bool:
    return not np.isnan(motions.cell["velocity"])


# --- tables -----------------------------------------------------------------------------------------------------------


def map_csv(shown: Picture) -> str:
    """The pixels of a picture as comma-separated values: both sides and all its columns, in SI."""
    out = StringIO()
    rows = csv.writer(out, lineterminator="\n")
    heads = [_side_head(shown.y), _side_head(shown.x)]
    rows.writerow([*heads, *(_head(column.name) for column in shown.columns)])
    for i in range(shown.shades.shape[0]):
        for j in range(shown.shades.shape[1]):
            rows.writerow([_side_value(shown.y, i), _side_value(shown.x, j), *_values(shown, i, j)])
    return out.getvalue()


def _values(shown: Picture, i: int, j: int) -> list[str]:
    found = []
    for column in shown.columns:
        value = float(column.values[i, j])
        found.append(column.names[int(value)] if column.names else f"{value * column.unit.factor:.7g}")
    return found


def _side_head(side: Side) -> str:
    unit = "" if side.kind == "listed" else units.spelled(SEARCHABLE[side.name].units)
    return f"{side.name} [{unit}]" if unit else side.name


def _side_value(side: Side, i: int) -> str:
    return side.labels[i] if side.labels else repr(float(side.values[i]))


def _head(name: str) -> str:
    unit = units.spelled(VARIABLES[name].units) if name in VARIABLES else ""
    return f"{name} [{unit}]" if unit else name


def motions_csv(columns: Sequence[tuple[str, Motion]]) -> str:
    """Samples of motions as comma-separated values, in SI: which motion, time since break-away, all that is known."""
    out = StringIO()
    rows = csv.writer(out, lineterminator="\n")
    names = [name for name in TRACE_VARIABLES if any(name in motion.samples for _, motion in columns)]
    said = [f"{name} [{u}]" if (u := units.spelled(TRACE_VARIABLES[name].units)) else name for name in names]
    rows.writerow(["motion", "time [s]", *said])
    for label, motion in columns:
        if not motion.samples:
            continue
        for i, time in enumerate(motion.time):
            rows.writerow([label, f"{time:.10g}", *(f"{float(motion.samples[name][i]):.10g}" for name in names)])
    return out.getvalue()
