"""`advise`: how far a cell is from a border, and which change takes it there."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
)
from stickslip.cli.progress import progress_bar
from stickslip.cli.trajectories import recipe_in

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.config.model import Config
    from stickslip.files.locations import Location

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
@click.option("--into", multiple=True, metavar="REGIME", help="Regime wanted; may be repeated.")
@OUTPUT
@THREADS
@reports_wrong_input
def advise(
    config: Location, at: tuple[str, ...], parameters: tuple[str, ...], costs: tuple[str, ...], within: float,
    into: tuple[str, ...], output: Location | None,
) -> None:  # fmt: skip
    """Say which changes take a cell over a border.

    CONFIG is a YAML file, or a result, which holds its configuration; the axes need a value each (--at). Every proposal
    is simulated 1 % past its border, and one that does not hold there is no cure. From a vibrating regime (stick_slip,
    sustained) borders to quiet ones (damped, creep, stuck) are looked for unless --into names others, from a quiet one
    those to vibrating ones.
    """
    from stickslip import designing
    from stickslip.config.pick import cell_of, config_at
    from stickslip.errors import Interrupted
    from stickslip.files import writing
    from stickslip.vocabulary.flags import REGIMES, flag_label

    one = config_at(recipe_in(config), at)
    if output is not None:
        writing.check_writable(output)
    asked = {"parameters": parameters or None, "costs": _costs(costs), "within": within}
    prepare_kernels(one.friction.law)
    try:
        home = REGIMES[int(_regime(one, cell_of(one)))]
        if home not in VIBRATING + QUIET:
            fail(f"{config}: this cell is {flag_label(home)}: nothing can be said of it\nhint: raise max_steps")
        wanted = into or (QUIET if home in VIBRATING else VIBRATING)
        with progress_bar(1, " searched") as move:
            ds = designing.margins(one, **asked, into=wanted, progress=move)  # type: ignore[arg-type]
    except Interrupted as error:
        incomplete(error)
    except (TypeError, ValueError) as error:  # bad input, said before anything is computed
        fail(f"{config}: {error}")
    _show(ds, one, home, wanted)
    if output is not None:
        writing.write(ds, output)
        click.echo(f"written  {output} ({screen.size_of(output)})")


def _regime(config: Config, cell: dict[str, float]) -> int:
    """The regime of a cell, integrated as the configuration says."""
    from stickslip import api

    solver = config.solver
    found = api.evaluate(
        cell, min(solver.rtol, 1e-9), solver.horizon, law=config.friction.law, max_steps=solver.max_steps
    )
    return int(found["regime"][0])


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


def _show(ds: xr.Dataset, config: Config, home: str, wanted: tuple[str, ...]) -> None:
    """The sentence, the table, and what was looked at."""
    from rich.table import Table

    from stickslip.cli import advice_words as words

    changes = words.single_changes(ds, wanted)
    joint = words.joint_change(ds, lambda cell: _regime(config, cell), wanted)
    click.echo(words.sentence(home, wanted, changes, joint))
    table = Table("change", "border", "by", "into", "1 % past it", box=None, pad_edge=False, header_style="bold")
    for change in changes:
        table.add_row(*change.row())
    if changes:
        screen.print_table(table)
    missing = words.without_border(ds)
    if missing:
        click.echo(f"no border within reach along {', '.join(missing)}")
    if joint is not None:
        click.echo(joint.told())
    click.echo(f"looked   at {ds.attrs['margin_within']}; {ds.attrs['margin_scan']}")
