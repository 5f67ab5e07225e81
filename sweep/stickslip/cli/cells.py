"""`simulate`: one cell, in words and over time."""

from __future__ import annotations

from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import save_plot, save_result, show_result
from stickslip.cli.screen import JSON, fail, refuses_bad_input, reports_errors
from stickslip.vocabulary.display_units import quantity
from stickslip.vocabulary.quantities import (
    REGIME_MESSAGES,
    REGIMES,
    STATUS_MESSAGES,
    STATUSES,
    UNDECIDED,
    VARIABLES,
    flag_label,
)

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location

_LABELS = {  # by variable, in the order of the rows
    "frequency": "frequency", "period": "period", "stick_fraction": "sticking", "displacement_amplitude": "amplitude",
    "velocity_amplitude": "velocity amplitude", "spring_force_max": "peak spring force",
    "spring_force_min": "least spring force", "acceleration_max": "peak acceleration",
    "slip_speed_max": "peak slip speed", "breakaway_time": "first break-away", "settling_time": "settling time",
    "settled_displacement": "settles at", "damping_ratio": "damping ratio",
    "critical_stiffness": "critical stiffness",
}  # fmt: skip
_OF_CYCLES = ("displacement_amplitude", "velocity_amplitude")  # 0 elsewhere, which says nothing
_FORCES = ("spring_force_max", "spring_force_min")
_ROUNDING = 1e-9  # of the largest force; less is none


@click.command(
    epilog="""\b
Examples:
  stickslip simulate configs/quickstart.yaml --at stiffness="5 N/mm" --at belt_speed="20 mm/s"
  stickslip simulate configs/quickstart.yaml \\
      --at stiffness="5 N/m" --at belt_speed="10 cm/s" -t "1 min" -o trace.nc
  stickslip simulate configs/lubricants.yaml \\
      --at lubricant=grease --at belt_speed=0.1 --plot trace.png"""
)
@params.CONFIG
@params.AT
@click.option(
    "-t", "--duration", metavar="TIME",
    help='How long: seconds, or with a unit ("2 min").  [default: eight cycles, or until it has settled]',
)  # fmt: skip
@params.OUTPUT
@params.plot_option()
@JSON
@reports_errors
def simulate(
    config: Location, at: tuple[str, ...], duration: str | None, output: Location | None,
    plot: Path | None,
) -> dict[str, Any]:  # fmt: skip
    """Compute one cell of a configuration, over time.

    CONFIG is a YAML file, or a result (.nc, .zarr), which holds its configuration. The axes need a value each (--at);
    everything else is as in the file. Says the regime, the frequency, the forces and more; -o writes the motion over
    time, --plot draws it.
    """
    from stickslip.api import cells
    from stickslip.config.grid import cell_of, config_at, seconds
    from stickslip.dataset.display import with_units
    from stickslip.vocabulary.quantities import QUANTITIES

    loaded = config_at(params.recipe_in(config), at)
    given = None if duration is None else seconds(duration)
    law, solver, cell = loaded.friction.law, loaded.solver, cell_of(loaded)
    result = cells.evaluate(cell, solver.rtol, solver.horizon, law=law, max_steps=solver.max_steps)
    span = cells.time_span(result, given)
    screen.print_rows(_rows(result))
    answer = _answer(result)
    if output is None and plot is None:
        screen.echo("over time: -o trace.nc, --plot trace.png")
        return answer
    ds = cells.simulate(
        cell, duration=span.duration, samples=span.samples, law=law, rtol=solver.rtol,
        max_steps=solver.max_steps,
    )  # fmt: skip
    ds = with_units(ds, {name: unit for name, unit in loaded.written_in.items() if name in ds.coords})
    over = ", ".join(filter(None, [quantity(span.duration, "s"), span.why]))
    save_result(ds, output, "trajectory", over)
    labels = [text for text in at if text.partition("=")[0].strip() not in QUANTITIES]
    shown = ds.assign_attrs(title=", ".join(filter(None, (loaded.title, *labels))))
    save_plot(lambda plots: plots.plot_trace(shown), plot, over if output is None else "")
    return answer | {"duration": span.duration, "output": output, "plot": plot}


def _values(result: xr.Dataset, *names: str) -> dict[str, float]:
    return {name: float(result[name].values[0]) for name in names}


def _rows(result: xr.Dataset) -> list[tuple[str, str]]:
    """Labels and values of a cell as texts; only what is finite."""
    regime, status = REGIMES[int(result["regime"].values[0])], STATUSES[int(result["status"].values[0])]
    rows = [("regime", f"{flag_label(regime)}: {REGIME_MESSAGES[regime]}"), ("", STATUS_MESSAGES[status])]
    values = _values(result, *(name for name in _LABELS if name in result))
    largest = max(abs(values[name]) for name in _FORCES)
    values |= {name: 0.0 for name in _FORCES if abs(values[name]) < _ROUNDING * largest}
    if regime not in ("stick_slip", "sustained"):
        values |= dict.fromkeys(_OF_CYCLES, nan)
    texts = {name: quantity(value, VARIABLES[name].units) for name, value in values.items() if isfinite(value)}
    if regime == "stick_slip" and "stick_fraction" in texts:
        texts["stick_fraction"] = f"{values['stick_fraction']:.1%} of the period"
    else:
        texts.pop("stick_fraction", "")
    return rows + [(_LABELS[name], text) for name, text in texts.items()]


def _answer(result: xr.Dataset) -> dict[str, Any]:
    """Every variable of the cell, in SI, flags by their names."""
    values = {name: result[name].values[0].item() for name in VARIABLES if name in result}
    return values | {"regime": REGIMES[values["regime"]], "status": STATUSES[values["status"]]}


@click.command(
    epilog="""\b
Examples:
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5 \\
      --parameter belt_speed --parameter stiffness \\
      --set margins.costs.stiffness=2 --set margins.within=20
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5 \\
      --parameter mu_start --parameter v_reversal      # friction as the lever"""
)
@params.CONFIG
@params.AT
@click.option("--parameter", "parameters", multiple=True, metavar="NAME", help="What may change; may be repeated.")
@click.option("--speed-range", metavar="RANGE", help='Belt speeds to be quiet throughout, as in "5..60 mm/s".')
@click.option("--into", multiple=True, metavar="REGIME", help="Regime wanted; may be repeated.")
@params.OUTPUT
@reports_errors
def advise(
    config: Location, at: tuple[str, ...], parameters: tuple[str, ...], speed_range: str | None,
    into: tuple[str, ...], output: Location | None,
) -> None:  # fmt: skip
    """Say which changes take a cell over a border.

    CONFIG is a YAML file, or a result, which holds its configuration; the axes need a value each (--at). From a
    vibrating regime (stick_slip, sustained) borders to quiet ones (damped, creep, stuck) are looked for unless --into
    names others, from a quiet one those to vibrating ones. Every proposal is simulated 1 % past its border, and one
    that does not hold there is no cure. Costs of changes (1), and how far to look (10 times), are those of a section
    `margins` or of --set. In Python: `margins(...).stickslip.report()`.
    """
    from stickslip.api.studies import margins
    from stickslip.config.grid import config_at
    from stickslip.config.studies import section_of_call
    from stickslip.studies.changes import OPPOSITE
    from stickslip.studies.margins import Margins
    from stickslip.vocabulary.units import ends_of

    with refuses_bad_input(""):
        ends = None if speed_range is None else ends_of("--speed-range", speed_range)
        speeds = section_of_call(Margins, speed_range=ends).speeds
    if speeds and any(setting.partition("=")[0].strip() == "belt_speed" for setting in at):
        fail("--speed-range: got one and --at belt_speed, expected one of them")
    recipe = params.recipe_in(config)
    loaded = config_at(recipe, at if ends is None else (*at, f"belt_speed={ends[0]}"))
    own = getattr(recipe, "study", None)
    own = own if isinstance(own, Margins) else section_of_call(Margins)
    with refuses_bad_input(config), screen.progress_bar(doing=" searched") as move:
        ds = margins(
            loaded, parameters or None, own.costs, own.within, into=into or (OPPOSITE,), speed_range=ends,
            progress=move,
        )  # fmt: skip
    if (home := int(ds["regime"])) in UNDECIDED:
        fail(f"{config}: this cell is {flag_label(REGIMES[home])}: nothing can be said of it\nhint: raise max_steps")
    show_result(ds)
    save_result(ds, output)
