"""`advise`: how far a cell is from a border, and which change takes it there."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import inf, isfinite, isnan, log
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import fail, refuses_bad_input, reports_errors
from stickslip.cli.outputs import save_result
from stickslip.vocabulary.display_units import spoken
from stickslip.vocabulary.flags import REGIMES, flag_label
from stickslip.vocabulary.models import model_with
from stickslip.vocabulary.quantities import MEASURED

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.config.model import Config
    from stickslip.files.locations import Location
    from stickslip.vocabulary.display_units import Unit

# Another material may be the cheaper change.
_FRICTION = tuple(name for name, row in MEASURED.items() if row.units == "1")
VIBRATING, QUIET = ("stick_slip", "sustained"), ("damped", "creep", "stuck")
_AS_PERCENT = 0.8  # changes up to this share of the value are told in percent, larger ones as a factor
_SMALL = 0.01  # of the square of the cost: what changes by less is left out of a joint proposal, if it holds without
_DIGITS = 4


@click.command(
    epilog="""\b
Examples:
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5 \\
      --parameter belt_speed --parameter stiffness --cost stiffness=2 --within 20"""
)
@params.CONFIG
@params.AT
@click.option("--parameter", "parameters", multiple=True, metavar="NAME", help="What may change; may be repeated.")
@click.option("--cost", "costs", multiple=True, metavar="NAME=NUMBER", help="Cost of a change; 1 unless given.")
@click.option("--within", type=float, default=10.0, show_default=True, help="How far to look, as a factor.")
@click.option("--speed-range", metavar="RANGE", help='Belt speeds to be quiet throughout, as in "5..60 mm/s".')
@click.option("--into", multiple=True, metavar="REGIME", help="Regime wanted; may be repeated.")
@params.OUTPUT
@params.THREADS
@reports_errors
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
    from stickslip.api.studies import margins
    from stickslip.config.select import cell_of, config_at
    from stickslip.config.studies import section_of_call
    from stickslip.studies.margins import Margins
    from stickslip.vocabulary.units import ends_of

    with refuses_bad_input(""):
        ends = None if speed_range is None else ends_of("--speed-range", speed_range)
        speeds = section_of_call(Margins, speed_range=ends).speeds
    if speeds and any(setting.partition("=")[0].strip() == "belt_speed" for setting in at):
        fail("--speed-range: got one and --at belt_speed, expected one of them")
    loaded = config_at(params.recipe_in(config), at if ends is None else (*at, f"belt_speed={ends[0]}"))
    weights = params.numbers("--cost", costs)
    with refuses_bad_input(config):
        home = REGIMES[_regime(loaded, cell_of(loaded), speeds)]
        if home not in VIBRATING + QUIET:
            fail(f"{config}: this cell is {flag_label(home)}: nothing can be said of it\nhint: raise max_steps")
        goals = into or (QUIET if home in VIBRATING else VIBRATING)
        how: dict[str, Any] = {"within": within, "into": goals, "speed_range": ends}
        with screen.progress_bar(doing=" searched") as move:
            ds = margins(loaded, parameters or None, costs=weights, progress=move, **how)
        friction = None
        if not parameters and home in VIBRATING:
            with suppress(ValueError):  # a law whose curve has no such quantities
                friction = margins(loaded, _FRICTION, joint=False, **how)
    ranges = () if speed_range is None else ("--speed-range", speed_range)
    options = [*(word for setting in at for word in ("--at", setting)), *ranges, *params.settings_again()]
    if speeds:
        screen.echo(f"range    {ds.attrs['margin_speeds']} counts")
    changes = _single_changes(ds, goals)
    joint = _joint_change(ds, lambda cell: _regime(loaded, cell, speeds), goals)
    levers = [] if friction is None else [change for change in _single_changes(friction, goals) if change.holds]
    lever = next((change for change in levers if change.size() < _least_cost(changes, joint)), None)
    which = "cheapest without friction" if lever else "cheapest"
    screen.echo(_sentence(home, goals, changes, joint, which))
    if lever is not None:
        closer = shlex.join(["stickslip", "advise", str(config), *options, "--parameter", lever.name])
        screen.echo(
            f"friction is the cheaper lever: {lever.words()}, cost {lever.size():.3g}; look closer with {closer}"
        )
    _show_table(ds, changes, within)
    if joint is not None:
        screen.echo(f"{which} {joint.words()}, simulated: {joint.outcome()}; cost {joint.cost:.3g}")
    if "joint_ended" in ds.attrs:
        screen.echo(ds.attrs["joint_ended"])
    screen.echo(f"looked   at {ds.attrs['margin_within']}; {ds.attrs['margin_scan']}")
    save_result(ds, output)


def _regime(config: Config, cell: Mapping[str, float], speeds: Sequence[float]) -> int:
    """The regime of a cell, integrated as the configuration says; of several belt speeds the worst."""
    from stickslip.api.cells import evaluate
    from stickslip.studies.margins import worst

    solver = config.solver
    cells: dict[str, Any] = {**cell, **({"belt_speed": speeds} if speeds else {})}
    how = {"law": config.friction.law, "max_steps": solver.max_steps}
    result = evaluate(cells, min(solver.rtol, 1e-9), solver.horizon, **how)
    return int(worst(result["regime"].values[None])[0])


# --- changes ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Change:
    """A border along one parameter: on which side, where, what lies past it, and what was simulated there."""

    name: str
    side: str
    value: float
    border: float
    width: float
    beyond: str
    checked: str
    holds: bool
    unit: Unit

    def size(self) -> float:
        """The logarithm of the factor; infinite where there is none."""
        ratio = self.border / self.value if self.value else 0.0
        return abs(log(ratio)) if ratio > 0 else inf

    def words(self) -> str:
        """`belt speed above 0.83 m/s (+66 %)`; parameters without unit by name."""
        text = f"{spoken(self.name)} {self.side} {self.unit.text(self.border, _DIGITS)}"
        return f"{text} ({_by(self.value, self.border, self.unit)})"

    def row(self) -> tuple[str, ...]:
        """The change as a row of a table."""
        border = f"{self.side} {self.unit.text(self.border, 9)}"
        if self.width > 1e-6 * abs(self.border):
            border += f" (undecided over {self.unit.of(self.width):.2g})"
        past = self.checked if self.holds else f"{self.checked}: does not hold"
        return self.name, border, _by(self.value, self.border, self.unit), self.beyond, past


@dataclass(frozen=True)
class JointChange:
    """The cheapest joint change as it is shown, rounded: parameters with old and new values in SI, and its simulation.

    units : in which the values are shown.
    """

    values: dict[str, tuple[float, float]]
    units: dict[str, Unit]
    cost: float
    checked: str
    holds: bool

    def words(self) -> str:
        """`belt_speed 0.6 m/s (+20 %) and damping 0.1 N s/m`."""
        *texts, last = [
            f"{spoken(name)} {self.units[name].text(new, _DIGITS)} ({_by(old, new, self.units[name])})"
            for name, (old, new) in self.values.items()
        ]
        return f"{', '.join(texts)} and {last}" if texts else last

    def outcome(self) -> str:
        """The regime that the simulation showed."""
        return self.checked if self.holds else f"{self.checked}: does not hold, and is no cure"


def _by(value: float, border: float, unit: Unit) -> str:
    """A change: in percent, as a factor, or, from 0, as the amount."""
    if value == 0 or border / value <= 0:
        return f"{unit.of(border - value):+.{_DIGITS}g} {unit.name}".rstrip()
    ratio = border / value
    return f"{100 * (ratio - 1):+.3g} %" if abs(ratio - 1) <= _AS_PERCENT else f"x {ratio:.3g}"


def _single_changes(ds: xr.Dataset, goals: Sequence[str]) -> list[Change]:
    """Every border along a single parameter, by how large the change is; those of parameters at 0 last."""
    from stickslip.dataset.display import unit_of
    from stickslip.studies.margins import SIDES

    cell, changes = _cell(ds), []
    for name in _parameters(ds):
        for side in SIDES:
            place = cell.sel(side=side)
            border, width = (float(place[f"{kind}_{name}"]) for kind in ("border", "border_width"))
            if not isnan(border):
                beyond, checked = (REGIMES[int(place[f"{kind}_{name}"])] for kind in ("beyond", "checked"))
                unit, holds = unit_of(cell[name]), checked in goals
                changes.append(Change(name, side, _value(cell, name), border, width, beyond, checked, holds, unit))
    return sorted(changes, key=Change.size)


def _joint_change(
    ds: xr.Dataset, regime: Callable[[dict[str, float]], int], goals: Sequence[str]
) -> JointChange | None:
    """The cheapest joint change, rounded, without what changes next to nothing; simulated as it is shown."""
    import numpy as np

    from stickslip.dataset.display import unit_of
    from stickslip.vocabulary.quantities import SEARCHABLE

    if "joint_cost" not in ds or isnan(float(ds["joint_cost"].values.ravel()[0])):
        return None
    cell = _cell(ds)
    before = {name: np.array(float(cell[name])) for name in SEARCHABLE if name in cell.coords}
    for least in (_SMALL, 0.0):
        values = {
            name: (_value(cell, name), float(f"{float(cell[f'joint_proposed_{name}']):.{_DIGITS}g}"))
            for name in _parameters(ds)
            if float(cell[f"joint_share_{name}"]) > least
        }
        changed = model_with(before).without_measured(
            before | {name: np.array(new) for name, (_, new) in values.items()}
        )
        there = {name: float(value) for name, value in changed.items()}
        checked = (
            "failed" if any(map(isnan, model_with(there).curve_of(there))) else REGIMES[regime(there)]
        )  # NaN: rounded to what no curve has
        if checked in goals:
            break
    shown = {name: unit_of(cell[name]) for name in values}
    return JointChange(values, shown, float(cell["joint_cost"]), checked, checked in goals)


def _least_cost(changes: Sequence[Change], joint: JointChange | None) -> float:
    """The cost of the cheapest change that holds; infinite where none does."""
    costs = [change.size() for change in changes if change.holds]
    return min([*costs, *([joint.cost] if joint is not None and joint.holds else [])], default=inf)


def _sentence(home: str, goals: Sequence[str], changes: Sequence[Change], joint: JointChange | None, which: str) -> str:
    """`in stick_slip; leaves it above 0.83 m/s (+66 %), ...; cheapest: ...`. What does not hold is no cure."""
    cures = [change.words() for change in changes if change.holds]
    verb = "leaves it" if home in VIBRATING else f"enters {' or '.join(goals)}"
    text = f"in {home}; {verb} with {', '.join(cures)}" if cures else f"in {home}; no single change within reach {verb}"
    return text + (f"; {which}: {joint.words()}" if joint is not None and joint.holds else "")


def _show_table(ds: xr.Dataset, changes: Sequence[Change], within: float) -> None:
    """Print the changes, and the parameters along which there is no border."""
    if changes:
        table = screen.new_table("change", "border", "by", "into", "1 % past it")
        for change in changes:
            table.add_row(*change.row())
        screen.print_table(table)
    cell, missing = _cell(ds), []
    for name in (name for name in _parameters(ds) if isnan(float(ds[f"margin_{name}"].values.ravel()[0]))):
        if name == "mu_stop" and isnan(float(cell[name])):
            screen.echo("mu_stop is not given, so that friction stops as it starts; give the pair a mu_stop")
        elif name in MEASURED and not isfinite(float(cell[name])):
            screen.echo(f"{name} is no property of this curve, which has no minimum")
        else:
            missing.append(name)
    if missing:
        screen.echo(f"no border within reach along {', '.join(missing)}: look further with --within {10 * within:g}")


def _cell(ds: xr.Dataset) -> xr.Dataset:
    return ds if "cell" not in ds.dims else ds.isel(cell=0)


def _parameters(ds: xr.Dataset) -> list[str]:
    from stickslip.vocabulary.quantities import SEARCHABLE

    return [name for name in SEARCHABLE if f"margin_{name}" in ds]


def _value(cell: xr.Dataset, name: str) -> float:
    """The value of a parameter; static friction that is not given is that at break-away."""
    value = float(cell[name])
    model = model_with(cell.coords)
    return float(sum(cell[level] for level in model.levels)) if isnan(value) and name == model.static else value
