"""`advise`: how far a cell is from a border, and which change takes it there."""

from __future__ import annotations

import shlex
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import screen
from stickslip.cli.common import (
    CONFIG_OR_RESULT,
    OUTPUT,
    THREADS,
    fail,
    incomplete,
    prepare_kernels,
    reports_wrong_input,
    settings_again,
)
from stickslip.cli.progress import progress_bar
from stickslip.cli.trajectories import recipe_in

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray as xr

    from stickslip.config.model import Config
    from stickslip.files.locations import Location

_FRICTION = ("mu_start", "mu_reversal")  # another material may be the cheaper change
VIBRATING, QUIET = ("stick_slip", "sustained"), ("damped", "creep", "stuck")


@click.command(
    epilog="""\b
Examples:
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5 \\
      --parameter belt_speed --parameter stiffness --cost stiffness=2 --within 20"""
)
@CONFIG_OR_RESULT
@click.option("--at", multiple=True, metavar="NAME=VALUE", help="Value of an axis, or of any other quantity.")
@click.option("--parameter", "parameters", multiple=True, metavar="NAME", help="What may change; may be repeated.")
@click.option("--cost", "costs", multiple=True, metavar="NAME=NUMBER", help="Cost of a change; 1 unless given.")
@click.option("--within", type=float, default=10.0, show_default=True, help="How far to look, as a factor.")
@click.option("--speed-range", metavar="RANGE", help='Belt speeds to be quiet throughout, as in "5..60 mm/s".')
@click.option("--into", multiple=True, metavar="REGIME", help="Regime wanted; may be repeated.")
@OUTPUT
@THREADS
@reports_wrong_input
def advise(
    config: Location, at: tuple[str, ...], parameters: tuple[str, ...], costs: tuple[str, ...], within: float,
    speed_range: str | None, into: tuple[str, ...], output: Location | None,
) -> None:  # fmt: skip
    """Say which changes take a cell over a border.

    CONFIG is a YAML file, or a result, which holds its configuration; the axes need a value each (--at). Every proposal
    is simulated 1 % past its border, and one that does not hold there is no cure. From a vibrating regime (stick_slip,
    sustained) borders to quiet ones (damped, creep, stuck) are looked for unless --into names others, from a quiet one
    those to vibrating ones.
    """
    from stickslip import studies
    from stickslip.config.select import cell_of, config_at
    from stickslip.errors import Interrupted
    from stickslip.files import writing
    from stickslip.materials.system import ends_of
    from stickslip.vocabulary.flags import REGIMES, flag_label

    try:
        ends = None if speed_range is None else ends_of("--speed-range", speed_range)
        speeds = studies.speeds_in(ends)
    except ValueError as error:
        fail(error)
    if speeds and any(setting.partition("=")[0].strip() == "belt_speed" for setting in at):
        fail("--speed-range: got one and --at belt_speed, expected one of them")
    one = config_at(recipe_in(config), at if ends is None else (*at, f"belt_speed={ends[0]}"))
    asked = {"parameters": parameters or None, "costs": _costs(costs), "within": within, "speed_range": ends}
    prepare_kernels(one.friction.law)
    try:
        home = REGIMES[_regime(one, cell_of(one), speeds)]
        if home not in VIBRATING + QUIET:
            fail(f"{config}: this cell is {flag_label(home)}: nothing can be said of it\nhint: raise max_steps")
        wanted = into or (QUIET if home in VIBRATING else VIBRATING)
        with progress_bar(1, " searched") as move:
            ds = studies.margins(one, **asked, into=wanted, progress=move)  # type: ignore[arg-type]
        friction = None
        if not parameters and home in VIBRATING:
            with suppress(ValueError):  # a law whose curve has no such quantities
                friction = studies.margins(one, _FRICTION, within=within, into=wanted, speed_range=ends, joint=False)
    except Interrupted as error:
        incomplete(error)
    except (TypeError, ValueError) as error:  # bad input, said before anything is computed
        fail(f"{config}: {error}")
    ranges = () if speed_range is None else ("--speed-range", speed_range)
    options = [*(word for setting in at for word in ("--at", setting)), *ranges, *settings_again()]
    _show(ds, one, home, wanted, within, speeds, friction, ["stickslip", "advise", str(config), *options])
    if output is not None:
        writing.write(ds, output)
        screen.echo(f"written  {output} ({screen.size_of(output)})")


def _regime(config: Config, cell: Mapping[str, float], speeds: Sequence[float]) -> int:
    """The regime of a cell, integrated as the configuration says; of several belt speeds the worst."""
    from stickslip import api
    from stickslip.distances import worst

    solver = config.solver
    asked: dict[str, Any] = {**cell, **({"belt_speed": speeds} if speeds else {})}
    found = api.evaluate(
        asked, min(solver.rtol, 1e-9), solver.horizon, law=config.friction.law, max_steps=solver.max_steps
    )
    return int(worst(found["regime"].values[None])[0])


def _costs(texts: tuple[str, ...]) -> dict[str, float]:
    """NAME=NUMBER texts as a mapping."""
    found = {}
    for text in texts:
        name, equals, number = text.partition("=")
        try:
            found[name.strip()] = float(number)
        except ValueError:
            equals = ""
        if not equals:
            fail(f"--cost: got {text!r}, expected NAME=NUMBER")
    return found


def _show(
    ds: xr.Dataset,
    config: Config,
    home: str,
    wanted: tuple[str, ...],
    within: float,
    speeds: Sequence[float],
    friction: xr.Dataset | None,
    command: list[str],
) -> None:
    """The sentence, the table, and what was looked at. friction : what changes of friction alone do, if they count too.
    command : that of this call, to which a line adds what to look at more closely."""
    from rich.table import Table

    from stickslip.cli import advice_words as words

    if speeds:
        screen.echo(f"range    {ds.attrs['margin_speeds']} counts")
    changes = words.single_changes(ds, wanted)
    joint = words.joint_change(ds, lambda cell: _regime(config, cell, speeds), wanted)
    levers = [] if friction is None else [change for change in words.single_changes(friction, wanted) if change.holds]
    cheaper = next((change for change in levers if change.size() < words.least_cost(changes, joint)), None)
    screen.echo(words.sentence(home, wanted, changes, joint, "cheapest without friction" if cheaper else "cheapest"))
    if cheaper is not None:
        screen.echo(f"friction is the cheaper lever: {cheaper.words()}, cost {cheaper.size():.3g}; look closer with "
                   f"{shlex.join([*command, '--parameter', cheaper.name])}")  # fmt: skip
    table = Table("change", "border", "by", "into", "1 % past it", box=None, pad_edge=False, header_style="bold")
    for change in changes:
        table.add_row(*change.row())
    if changes:
        screen.print_table(table)
    absent = words.absent(ds)
    for name, why in absent.items():
        screen.echo(f"{name} {why}")
    if missing := [name for name in words.without_border(ds) if name not in absent]:
        screen.echo(f"no border within reach along {', '.join(missing)}: look further with --within {10 * within:g}")
    if joint is not None:
        screen.echo(joint.told("cheapest without friction" if cheaper else "cheapest"))
    if "joint_ended" in ds.attrs:
        screen.echo(ds.attrs["joint_ended"])
    screen.echo(f"looked   at {ds.attrs['margin_within']}; {ds.attrs['margin_scan']}")
