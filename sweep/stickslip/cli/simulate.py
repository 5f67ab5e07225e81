"""`simulate`: one cell, in words and over time."""

from __future__ import annotations

from collections.abc import Iterable
from math import ceil, floor, isfinite, log10, pi, sqrt
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import JSON, reports_errors
from stickslip.cli.outputs import save_plot, save_result
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import customary
from stickslip.vocabulary.flags import REGIME_MESSAGES, REGIMES, STATUS_MESSAGES, STATUSES, flag_label
from stickslip.vocabulary.results import VARIABLES

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location

CYCLES = 8.0  # shown after the first break-away
_SETTLED = 1.1  # settling times shown
_SLOW = 30.0  # natural periods, for what neither sticks nor settles
_PER_PERIOD = 60  # samples a natural period
_MOST_SAMPLES = 40_001
_LONGEST = 1e3  # natural periods, of what does not stick
_WIDTH = 90  # characters of a title
_LABELS = {  # by variable, in the order of the rows
    "frequency": "frequency", "period": "period", "stick_fraction": "sticking", "displacement_amplitude": "amplitude",
    "velocity_amplitude": "velocity amplitude", "spring_force_max": "peak spring force",
    "spring_force_min": "least spring force", "acceleration_max": "peak acceleration",
    "slip_speed_max": "peak slip speed", "breakaway_time": "first break-away", "settling_time": "settling time",
    "settled_displacement": "settles at", "damping_ratio": "damping ratio",
}  # fmt: skip
_OF_CYCLES = ("displacement_amplitude", "velocity_amplitude")  # 0 elsewhere, which says nothing
_FORCES = ("spring_force_max", "spring_force_min")
_ROUNDING = 1e-9  # of the largest force; less is none


@click.command(
    epilog="""\b
Examples:
  stickslip simulate configs/quickstart.yaml --at stiffness="5 N/mm" --at belt_speed="20 mm/s"
  stickslip simulate configs/quickstart.yaml \\
      --at stiffness=5 --at belt_speed="10 cm/s" -t "1 min" -o trace.nc
  stickslip simulate configs/lubricants.yaml \\
      --at lubricant=grease --at belt_speed=0.1 --plot trace.png"""
)
@params.CONFIG_OR_RESULT
@params.AT
@click.option(
    "-t",
    "--duration",
    metavar="TIME",
    help='How long: seconds, or with a unit ("2 min").  [default: eight cycles, or until it has settled]',
)
@click.option("--samples", type=click.IntRange(2), help="Number of points in time.  [default: 2001, or 60 a vibration]")
@params.OUTPUT
@params.plot_option()
@JSON
@reports_errors
def simulate(
    config: Location, at: tuple[str, ...], duration: str | None, samples: int | None, output: Location | None,
    plot: Path | None,
) -> dict[str, Any]:  # fmt: skip
    """Compute one cell of a configuration, over time.

    CONFIG is a YAML file, or a result (.nc, .zarr), which holds its configuration. The axes need a value each (--at);
    everything else is as in the file. Says the regime, the frequency, the forces and more; -o writes the motion over
    time, --plot draws it, `stickslip listen` makes it heard.
    """
    from stickslip.api import cells
    from stickslip.config.select import cell_of, config_at, seconds
    from stickslip.dataset.display import shown_as_written

    loaded = config_at(params.recipe_in(config), at)
    given = None if duration is None else seconds(duration)
    law, solver, cell = loaded.friction.law, loaded.solver, cell_of(loaded)
    result = cells.evaluate(cell, solver.rtol, solver.horizon, law=law, max_steps=solver.max_steps)
    span = time_span(result, given)
    screen.print_rows(_rows(result))
    answer = _answer(result)
    if output is None and plot is None:
        screen.echo("over time: -o trace.nc, --plot trace.png; as sound: stickslip listen")
        return answer
    ds = cells.simulate(
        duration=span.duration, samples=samples or span.samples, law=law, rtol=solver.rtol,
        max_steps=solver.max_steps, options=None, **cell,
    )  # fmt: skip
    ds = shown_as_written(ds, loaded.written_in)
    over = f"{customary('s', span.duration) or f'{span.duration:.4g} s'}{f', {span.why}' if span.why else ''}"
    save_result(ds, output, "trajectory", over)
    if plot is not None:
        from stickslip import plots

        save_plot(plots.plot_trace(ds, title=cell_title(loaded.title, at)), plot, note=over if output is None else "")
    return answer | {"duration": span.duration, "output": output, "plot": plot}


class TimeSpan(NamedTuple):
    """Duration of a trajectory (s), its number of samples, and the reason in words."""

    duration: float
    samples: int
    why: str


def time_span(result: xr.Dataset, duration: float | None = None) -> TimeSpan:
    """The time that shows what becomes of a cell, or the one that is given.

    result : what `evaluate` says of it: eight cycles after the first break-away; a decay until it has settled.
    """
    natural, why = _natural_period(result), ""
    if duration is None:
        values = {name: float(result[name].values[0]) for name in ("breakaway_time", "period", "settling_time")}
        regime = REGIMES[int(result["regime"].values[0])]
        began = values["breakaway_time"] if isfinite(values["breakaway_time"]) else 0.0
        after, why = _SLOW * natural, f"{_SLOW:g} natural periods"
        if regime == "stick_slip":
            after, why = CYCLES * values["period"], f"{CYCLES:g} cycles"
        elif regime == "sustained":
            after = max(_SLOW * natural, CYCLES * values["period"])
        elif regime in ("damped", "creep") and isfinite(values["settling_time"]):
            after, why = max(_SETTLED * values["settling_time"], natural), "until it has settled"
        if regime != "stick_slip" and after > _LONGEST * natural:
            after, why = _LONGEST * natural, f"{_LONGEST:g} natural periods, no more"
        duration = _rounded_up(began + after)
    return TimeSpan(duration, min(max(2001, ceil(_PER_PERIOD * duration / natural) + 1), _MOST_SAMPLES), why)


def _rounded_up(seconds: float) -> float:
    """A duration with two digits, no shorter."""
    scale = 10.0 ** (floor(log10(seconds)) - 1)
    return float(f"{ceil(seconds / scale * (1.0 - 1e-12)) * scale:.12g}")


def _natural_period(result: xr.Dataset) -> float:
    """Of the mass on its spring, s."""
    return 2.0 * pi * sqrt(float(result["mass"].values[0]) / float(result["stiffness"].values[0]))


def _rows(result: xr.Dataset) -> list[tuple[str, str]]:
    """Labels and values of a cell as texts; only what is finite."""
    regime, status = REGIMES[int(result["regime"].values[0])], STATUSES[int(result["status"].values[0])]
    rows = [("regime", f"{flag_label(regime)}: {REGIME_MESSAGES[regime]}"), ("", STATUS_MESSAGES[status])]
    values = {name: float(result[name].values[0]) for name in _LABELS}
    largest = max(abs(values[name]) for name in _FORCES)
    values |= {name: 0.0 for name in _FORCES if abs(values[name]) < _ROUNDING * largest}
    hidden = set() if regime in ("stick_slip", "sustained") else set(_OF_CYCLES)
    hidden |= set() if regime == "stick_slip" else {"stick_fraction"}
    if regime == "damped" and abs(values["damping_ratio"]) < 1.0:
        decay = sqrt(1.0 - values["damping_ratio"] ** 2) / _natural_period(result)
        rows.append(("vibrates at", f"{_text('frequency', decay)} while it decays, by linear theory"))
    shown = [name for name in _LABELS if isfinite(values[name]) and name not in hidden]
    return rows + [(_LABELS[name], _text(name, values[name])) for name in shown]


def _text(name: str, value: float) -> str:
    """A variable of a cell in a customary unit: ``81.2 ms``."""
    if name == "stick_fraction":
        return f"{value:.1%} of the period"
    unit = VARIABLES[name].units
    if unit == "s-1":
        return f"{value / 1e3:.4g} kHz" if value >= 1e3 else f"{value:.4g} Hz"
    return customary(unit, value) or f"{value:.4g} {units.spelled(unit)}".rstrip()


def _answer(result: xr.Dataset) -> dict[str, Any]:
    """Every variable of the cell, in SI, flags by their names."""
    values = {name: result[name].values[0].item() for name in VARIABLES if name in result}
    return values | {"regime": REGIMES[values["regime"]], "status": STATUSES[values["status"]]}


def cell_title(title: str, at: Iterable[str]) -> str:
    """The title of a picture of one cell: that of the configuration, and below it what was set."""
    from stickslip.dataset.display import spoken

    pairs = (text.partition("=") for text in at)
    named = [f"{spoken(name.strip())} = {value.strip()}" for name, _, value in pairs]
    return "\n".join([*wrap(title, _WIDTH), *wrap(", ".join(named), _WIDTH)])
