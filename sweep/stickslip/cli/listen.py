"""`listen`: the sound of a cell as a WAV file, and how loud cells are."""

from __future__ import annotations

import re
from contextlib import nullcontext
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import screen
from stickslip.cli.common import (
    CONFIG_OR_RESULT,
    JSON,
    THREADS,
    Target,
    fail,
    incomplete,
    prepare_kernels,
    reports_wrong_input,
    tell_json,
)
from stickslip.cli.progress import progress_bar
from stickslip.cli.trajectories import recipe_in
from stickslip.cli.trajectory_words import titled

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location
    from stickslip.sound import Sound

_BETWEEN = re.compile(r",\s*(?=[^,=]+=)")  # of several NAME=VALUE in a text
_ALIKE = 0.05  # dB
LONGEST = 600.0  # s of sound
FASTEST = 1e6  # times slower, or faster


@click.command(
    epilog="""\b
Examples:
  stickslip listen configs/quickstart.yaml \\
      --at stiffness="5 N/mm" --at belt_speed="20 mm/s" -o squeak.wav --plot squeak.png
  stickslip listen configs/quickstart.yaml \\
      --at stiffness=5 --at belt_speed="20 mm/s" --slow 0.01 -o faster.wav
  stickslip listen quickstart.nc --at stiffness="5 N/mm" --at belt_speed=1 -o decay.wav
  stickslip listen configs/lubricants.yaml --level -o levels.nc   # how loud every cell is"""
)
@CONFIG_OR_RESULT
@click.option("--at", multiple=True, metavar="NAME=VALUE", help="Value of an axis, or of any other quantity.")
@click.option(
    "-o",
    "--output",
    type=Target("sound", "result"),
    help="Sound to write, .wav; with --level the levels, .nc or .zarr.",
)
@click.option("--seconds", default="3", show_default=True, metavar="TIME", help='How long: seconds, or "500 ms".')
@click.option("--slow", type=float, default=1.0, show_default=True, help="So many times slower; 0.1 is faster.")
@click.option(
    "--full-scale", default="100 m/s2", show_default=True, metavar="ACCELERATION",
    help="The loudest a sound can be; those of one scale can be compared.",
)  # fmt: skip
@click.option("--transient", is_flag=True, help="The motion from its start, where it has a cycle as well.")
@click.option("--rate", type=click.IntRange(8000, 192_000), default=44_100, show_default=True, help="Samples a second.")
@click.option("--float", "floating", is_flag=True, help="32-bit numbers in the file instead of 16-bit integers.")
@click.option("--plot", type=Target("plot"), help="Spectrogram to write: .png, .svg or .pdf.")
@click.option("--level", is_flag=True, help="How loud every cell is, or the one at --at, instead of a sound.")
@click.option(
    "--reference", multiple=True, metavar="NAME=VALUE,...",
    help="With --level: the cell that has 0 dB, by what differs from --at.",
)  # fmt: skip
@THREADS
@JSON
@reports_wrong_input
def listen(
    config: Location, at: tuple[str, ...], output: Location | None, seconds: str, slow: float, full_scale: str,
    transient: bool, rate: int, floating: bool, plot: Path | None, level: bool, reference: tuple[str, ...],
    as_json: bool,
) -> None:  # fmt: skip
    """Hear a cell: its acceleration as a sound file.

    CONFIG is a YAML file, or a result (.nc, .zarr), which holds its configuration. The axes need a value each (--at).
    Of a cycle one hears the cycle, of all other motions the decay from the first break-away on. All sounds of one full
    scale are equally loud for equal accelerations; what is louder is softly compressed, and that is said. With --level
    it says how loud cells are, A-weighted, in dB re 1e-6 m/s2 or re a cell.
    """
    if level:
        if plot is not None or transient or floating:
            fail("--level gives numbers: leave out --plot, --transient and --float")
        return _levels(config, at, output, reference, as_json)
    if reference:
        fail("--reference is the cell that has 0 dB: give --level as well")
    _check(output, slow)
    heard, cell_level, title = _sound(config, at, seconds, slow, full_scale, transient, rate)
    if output is not None:
        save_sound(heard, Path(str(output)), floating)
    if plot is not None:
        _draw(heard, title, plot)
    if as_json:
        return tell_json(_as_json(heard, cell_level, output, plot))
    screen.echo(heard.told())
    if not isfinite(heard.frequency) or cell_level == cell_level:
        screen.echo(f"level    {level_text(cell_level)}")
    for line in heard.remarks():
        screen.echo(line)
    if output is not None:
        tell_file(heard, Path(str(output)), floating)
    if plot is not None:
        screen.echo(f"plot     {plot}")
    if output is None and plot is None:
        screen.echo("nothing was written: name a file (-o squeak.wav), a plot (--plot spectrogram.png), or both")


def _check(output: Location | None, slow: float) -> None:
    """End before anything is computed if the file is no sound, or the pace is none."""
    if output is not None and output.suffix.lower() != ".wav":
        fail(f"{output}: sounds end in .wav")
    if not 1.0 / FASTEST <= slow <= FASTEST:
        fail(f"--slow: got {slow:g}, expected a number from 1e-6 to 1e6, such as 10, or 0.1 for ten times faster")


def save_sound(heard: Sound, path: Path, floating: bool = False) -> None:
    """Write a WAV file, whole or not at all. Raises StoreError."""
    from stickslip.files import atomic

    with atomic.replaced(path) as temporary:
        temporary.write_bytes(heard.wav(floating))


def tell_file(heard: Sound, path: Path, floating: bool = False) -> None:
    """What was written where."""
    kind = f"{heard.seconds:.3g} s, {'32-bit floating' if floating else '16 bit'}, full scale {heard.full_scale:g} m/s2"
    screen.echo(f"sound    {path} ({kind}, {screen.size_of(path)})")


def level_text(level: float) -> str:
    """A level in words."""
    if level != level:
        return "none: there is no cycle"
    return f"{level:.1f} dB(A) re 1e-6 m/s2" if isfinite(level) else "none: nothing of it is heard"


def acceleration(text: str, option: str) -> float:
    """An acceleration > 0 on the command line, in SI. Raises ConfigError."""
    from stickslip.errors import ConfigError, Problem, QuantityError
    from stickslip.vocabulary import units

    try:
        try:
            value = float(text)
        except ValueError:
            value = units.si_value(text, "m s-2")
        if value > 0.0 and isfinite(value):
            return value
        raise QuantityError("an acceleration > 0, such as '100 m/s2'")
    except QuantityError as error:
        raise ConfigError(option, [Problem((), f"got {text!r}, {error}")]) from None


def _sound(
    config: Location, at: tuple[str, ...], seconds: str, slow: float, full_scale: str, transient: bool, rate: int
) -> tuple[Sound, float, str]:
    """The sound of the cell, its level (dB), and its title."""
    from stickslip import sound
    from stickslip.config.select import cell_of, config_at
    from stickslip.config.select import seconds as time_of
    from stickslip.vocabulary.results import LEVEL

    one = config_at(recipe_in(config), at)
    loudest, length, law = acceleration(full_scale, "--full-scale"), time_of(seconds, "--seconds"), one.friction.law
    if length > LONGEST:
        fail(f"--seconds: got {seconds!r}, expected at most {LONGEST:g} s")
    prepare_kernels(law)
    prepare_kernels(law, signals=True)
    cell, title = cell_of(one), titled(one.title, at)
    heard = sound.of(
        cell, length, law=law, rate=rate, slow=slow, full_scale=loudest, transient=transient,
        max_steps=one.solver.max_steps, title=title,
    )  # fmt: skip
    return heard, float(sound.levels(cell, law=law)[LEVEL.name][0]), title


def _draw(heard: Sound, title: str, plot: Path) -> None:
    from stickslip import plots
    from stickslip.errors import PlotError

    try:
        plots.save(plots.plot_sound(heard.acceleration, heard.rate, title=title, slow=heard.slow), plot)
    except PlotError as error:
        fail(f"{plot}: {error}")


def _as_json(heard: Sound, level: float, output: Location | None, plot: Path | None) -> dict[str, Any]:
    return {
        "regime": heard.regime, "frequency": heard.frequency, "repeats": heard.repeats, "acceleration_max": heard.peak,
        "acceleration_level_a": level, "seconds": heard.seconds, "slow": heard.slow, "rate": heard.rate,
        "full_scale": heard.full_scale, "clips": heard.clips, "remarks": heard.remarks(), "output": output,
        "plot": plot,
    }  # fmt: skip


# --- levels -----------------------------------------------------------------------------------------------------------


def _levels(
    config: Location, at: tuple[str, ...], output: Location | None, reference: tuple[str, ...], as_json: bool
) -> None:
    """The levels of all cells of a configuration, or of the one at `at`."""
    from stickslip import sound
    from stickslip.config.grid import build_grid
    from stickslip.config.select import cell_of, config_at
    from stickslip.errors import ConfigError
    from stickslip.files import writing

    recipe = recipe_in(config)
    one: Any = config_at(recipe, at) if at else recipe
    if not hasattr(one, "friction"):  # the recipe of a list of cells
        fail(f"{config}: a list of cells: in Python, stickslip.sound.levels takes it; here name a cell (--at)")
    if output is not None and output.suffix.lower() == ".wav":
        fail(f"{output}: levels are results, which end in .nc or .zarr")
    asked = [one for text in reference for one in _BETWEEN.split(text)]
    zero = cell_of(config_at(recipe, [*at, *asked], "--reference")) if asked else None
    law, threads, size = one.friction.law, one.execution.threads, build_grid(one).size
    prepare_kernels(law)
    prepare_kernels(law, signals=True)
    try:
        with progress_bar(size) if size > 1 else nullcontext() as moved:
            ds = sound.levels(one, zero, max_steps=one.solver.max_steps, threads=threads, progress=moved)
    except KeyboardInterrupt:
        incomplete("interrupted: nothing was written")
    except ConfigError:
        raise
    except ValueError as error:
        fail(f"{config}: {error}")
    if output is not None:
        writing.write(ds, output)
    if as_json:
        return tell_json(_summary(ds) | {"output": output})
    _tell_levels(ds)
    if asked and ds["regime"].size == 1:
        screen.echo(_compared(float(ds["acceleration_level_a"].values.item()), ", ".join(asked)))
    if output is not None:
        screen.echo(f"levels   {output} ({screen.size_of(output)})")
        screen.echo(f"next:    stickslip plot {output}")
    elif ds["regime"].ndim:
        screen.echo("nothing was written: name a file (-o levels.nc)")


def _summary(ds: xr.Dataset) -> dict[str, Any]:
    """How many cells have a level, and between which values."""
    import numpy as np

    level = ds["acceleration_level_a"]
    heard = level.values[np.isfinite(level.values)]
    ends = (float(heard.min()), float(np.median(heard)), float(heard.max())) if heard.size else (None, None, None)
    return {
        "cells": level.size, "without_cycle": int(np.isnan(level.values).sum()),
        "not_heard": int(np.isneginf(level.values).sum()), "with_level": int(heard.size),
        "lowest": ends[0], "median": ends[1], "highest": ends[2], "long_name": level.attrs["long_name"],
    }  # fmt: skip


def _tell_levels(ds: xr.Dataset) -> None:
    found = _summary(ds)
    if found["cells"] == 1:
        screen.echo(f"level    {_one_level(ds)}")
        return
    screen.echo(f"{found['long_name']}:")
    if found["with_level"]:
        screen.echo(
            f"{found['with_level']:,} of {found['cells']:,} cells: {found['lowest']:.1f} to {found['highest']:.1f}, "
            f"half of them above {found['median']:.1f}"
        )
    if found["without_cycle"]:
        screen.echo(f"{_cells(found['without_cycle'])} no cycle, and no level: settled, stuck, or undecided")
    if found["not_heard"]:
        screen.echo(f"{_cells(found['not_heard'])} a cycle of which nothing is heard")


def _compared(level: float, reference: str) -> str:
    """`2.6 dB louder than the reference: stiffness=12 N/mm`."""
    if not isfinite(level):
        return f"nothing to compare with the reference: {reference}"
    if abs(level) < _ALIKE:
        return f"as loud as the reference: {reference}"
    return f"{abs(level):.1f} dB {'louder' if level > 0.0 else 'quieter'} than the reference: {reference}"


def _cells(number: int) -> str:
    return "1 cell has" if number == 1 else f"{number:,} cells have"


def _one_level(ds: xr.Dataset) -> str:
    level = ds["acceleration_level_a"]
    text = level_text(float(level.values.item()))
    return text.replace("re 1e-6 m/s2", "re the reference") if "reference_cell" in level.attrs else text
