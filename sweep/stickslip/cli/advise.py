"""`advise`: how far a cell is from a border, and which change takes it there: the report of the study of margins."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import fail, refuses_bad_input, reports_errors
from stickslip.cli.outputs import save_result, show_result
from stickslip.vocabulary.flags import REGIMES, UNDECIDED, flag_label

if TYPE_CHECKING:
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5 \\
      --parameter belt_speed --parameter stiffness --cost stiffness=2 --within 20
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5 \\
      --parameter mu_start --parameter v_reversal      # friction as the lever"""
)
@params.CONFIG
@params.AT
@click.option("--parameter", "parameters", multiple=True, metavar="NAME", help="What may change; may be repeated.")
@click.option("--cost", "costs", multiple=True, metavar="NAME=NUMBER", help="Cost of a change; 1 unless given.")
@click.option("--within", type=float, default=10.0, show_default=True, help="How far to look, as a factor.")
@click.option("--speed-range", metavar="RANGE", help='Belt speeds to be quiet throughout, as in "5..60 mm/s".')
@click.option("--into", multiple=True, metavar="REGIME", help="Regime wanted; may be repeated.")
@params.OUTPUT
@reports_errors
def advise(
    config: Location, at: tuple[str, ...], parameters: tuple[str, ...], costs: tuple[str, ...], within: float,
    speed_range: str | None, into: tuple[str, ...], output: Location | None,
) -> None:  # fmt: skip
    """Say which changes take a cell over a border.

    CONFIG is a YAML file, or a result, which holds its configuration; the axes need a value each (--at). From a
    vibrating regime (stick_slip, sustained) borders to quiet ones (damped, creep, stuck) are looked for unless --into
    names others, from a quiet one those to vibrating ones. Every proposal is simulated 1 % past its border, and one
    that does not hold there is no cure. In Python: `margins(...).stickslip.report()`.
    """
    from stickslip.api.studies import margins
    from stickslip.config.select import config_at
    from stickslip.config.studies import section_of_call
    from stickslip.studies.changes import OPPOSITE, Margins
    from stickslip.vocabulary.units import ends_of

    with refuses_bad_input(""):
        ends = None if speed_range is None else ends_of("--speed-range", speed_range)
        speeds = section_of_call(Margins, speed_range=ends).speeds
    if speeds and any(setting.partition("=")[0].strip() == "belt_speed" for setting in at):
        fail("--speed-range: got one and --at belt_speed, expected one of them")
    loaded = config_at(params.recipe_in(config), at if ends is None else (*at, f"belt_speed={ends[0]}"))
    weights = params.numbers("--cost", costs)
    with refuses_bad_input(config), screen.progress_bar(doing=" searched") as move:
        ds = margins(
            loaded, parameters or None, weights, within, into=into or (OPPOSITE,), speed_range=ends, progress=move
        )
    if (home := int(ds["regime"])) in UNDECIDED:
        fail(f"{config}: this cell is {flag_label(REGIMES[home])}: nothing can be said of it\nhint: raise max_steps")
    show_result(ds)
    save_result(ds, output)
