"""`listen`: the sound of a cell as a WAV file, and how loud cells are."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import save_plot, save_result, show_file
from stickslip.cli.screen import JSON, fail, fields, refuses_bad_input, reports_errors
from stickslip.files.targets import Kind

if TYPE_CHECKING:
    from stickslip.files.locations import Location

WAV = Kind("sounds", (".wav",))
_ANSWER = ("regime", "frequency", "repeats", "seconds", "slow", "rate", "full_scale", "clips")  # of a sound


@click.command(
    epilog="""\b
Examples:
  stickslip listen configs/quickstart.yaml \\
      --at stiffness="5 N/mm" --at belt_speed="20 mm/s" -o squeak.wav --plot squeak.png
  stickslip listen configs/lubricants.yaml --level -o levels.nc   # how loud every cell is"""
)
@params.CONFIG
@params.AT
@click.option("-o", "--output", type=params.Target(WAV, "result"),
              help="Sound to write, .wav; with --level the levels, .nc or .zarr.")  # fmt: skip
@click.option("--seconds", default="3", show_default=True, metavar="TIME", help='How long: seconds, or "500 ms".')
@click.option("--slow", type=click.FloatRange(1e-6, 1e6), default=1.0, show_default=True,
              help="So many times slower; 0.1 is faster.")  # fmt: skip
@click.option("--full-scale", default="100 m/s2", show_default=True, metavar="ACCELERATION",
              help="The loudest a sound can be; those of one scale can be compared.")  # fmt: skip
@click.option("--rate", type=click.IntRange(8000, 192_000), default=44_100, show_default=True, help="Samples a second.")
@params.plot_option("Spectrogram to write: .png, .svg or .pdf.")
@click.option("--level", is_flag=True, help="How loud every cell is, instead of a sound.")
@JSON
@reports_errors
def listen(
    config: Location, at: tuple[str, ...], output: Location | None, seconds: str, slow: float, full_scale: str,
    rate: int, plot: Path | None, level: bool,
) -> dict[str, Any]:  # fmt: skip
    """Hear a cell: its acceleration as a sound file.

    CONFIG is a YAML file, or a result (.nc, .zarr), which holds its configuration. The axes need a value each (--at).
    Of a cycle one hears the cycle, of all other motions the decay from the first break-away on; what is louder than
    full scale is softly compressed. With --level it says how loud all cells are, A-weighted, in dB.
    """
    if output is not None and (output.suffix.lower() == ".wav") == level:
        fail(f"{output}: sounds end in .wav, levels (--level) in .nc or .zarr")
    if level:
        if at or plot is not None:
            fail("--level gives numbers of all cells: leave out --at and --plot")
        return _levels(config, output)
    from stickslip.config import grid
    from stickslip_sound import sounds as sound
    from stickslip_sound.plots import plot_sound

    loudest = params.si_quantity("--full-scale", full_scale, "m s-2", "an acceleration > 0, such as '100 m/s2'")
    loaded, length = grid.config_at(params.recipe_in(config), at), grid.seconds(seconds, "--seconds")
    if length > 600.0:
        fail(f"--seconds: got {seconds!r}, expected at most 600 s")
    cell, law, title = grid.cell_of(loaded), loaded.friction.law, "\n".join((loaded.title, *at))
    with refuses_bad_input(config.name):
        made = sound.of(
            cell, length, rate=rate, slow=slow, full_scale=loudest, law=law, max_steps=loaded.solver.max_steps
        )  # fmt: skip
    cell_level = float(sound.levels(cell, law=law)["acceleration_level_a"][0])
    screen.echo(made.described())
    screen.row("level", f"{cell_level:.1f} dB(A) re 1e-6 m/s2")
    if isinstance(output, Path):
        made.save(output)
        show_file("sound", output, f"{made.seconds:.3g} s, full scale {made.full_scale:g} m/s2")
    with refuses_bad_input(plot):
        save_plot(lambda _: plot_sound(made.acceleration, made.rate, title=title, slow=made.slow), plot)
    if output is None and plot is None:
        screen.echo("nothing was written: name a file (-o squeak.wav), a plot (--plot spectrogram.png), or both")
    answer = fields(made, *_ANSWER, acceleration_max="peak")
    return answer | {"acceleration_level_a": cell_level, "output": output, "plot": plot}


def _levels(config: Location, output: Location | None) -> dict[str, Any]:
    """The levels of all cells of a configuration."""
    import numpy as np

    from stickslip.config.studies import ReportTable
    from stickslip_sound.loudness import LEVEL, levels

    loaded: Any = params.recipe_in(config)
    if not hasattr(loaded, "friction"):  # the recipe of a list of cells
        fail(f"{config}: a list of cells: in Python, stickslip.sound.levels takes it")
    with refuses_bad_input(config), screen.progress_bar() as move:
        ds = levels(loaded, progress=move, max_steps=loaded.solver.max_steps, threads=loaded.execution.threads)
    level, about = ds[LEVEL.name].values, ds[LEVEL.name].attrs["long_name"]
    known = level[np.isfinite(level)]
    counts = {"cells": level.size, "without_cycle": int(np.isnan(level).sum()),
              "not_heard": int(np.isneginf(level).sum()), "with_level": known.size}  # fmt: skip
    if known.size:
        counts |= {"lowest": known.min(), "median": np.median(known), "highest": known.max()}
    numbers = [f"{number:.6g}" for number in counts.values()]
    screen.echo(f"{about}:\n{ReportTable('', (), list(counts), [numbers]).text()}")
    save_result(ds, output, "levels")
    if output is not None:
        screen.echo(f"next:    stickslip plot {output}")
    return counts | {"long_name": about, "output": output}
