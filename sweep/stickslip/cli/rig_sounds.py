"""`rig --sound`: the acceleration of the specimen in each test, as a WAV file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli.common import fail
from stickslip.cli.listen import save_sound

if TYPE_CHECKING:
    from stickslip.rig.simulate.config import RigConfig
    from stickslip.rig.simulate.simulation import RigTests
    from stickslip.sound import Sound

_FINE, _COARSE = 8, 2  # samples computed per sample of sound: of short tests, and of long ones, which take much memory
_SHORT = 20.0  # s


def check(target: Path, tests: RigTests) -> None:
    """End if no sounds can be written there."""
    if target.suffix.lower() == ".wav":
        if tests.grid.size != 1:
            fail(f"{target}: {tests.grid.size:,} tests have a WAV file each: name a folder")
        if not target.absolute().parent.is_dir():
            fail(f"{target}: no folder {target.parent}")
        return
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        fail(f"{target}: expected a folder, or a name for a new one ({error.strerror})")


def write(target: Path, asked: RigConfig) -> None:
    """The sound of every test that was integrated to its end, from the first stroke on."""
    from stickslip.rig.simulate.simulation import RigTests

    size, loudest, full_scale = RigTests(asked).grid.size, 0.0, 0.0
    single = target.suffix.lower() == ".wav"
    clipping = 0
    for number, heard in _sounds(asked):
        save_sound(heard, target if single else target / f"test{number:0{len(str(size - 1))}d}.wav")
        full_scale, loudest = heard.full_scale, max(loudest, heard.peak)
        clipping += heard.clips
    click.echo(f"sounds    {target if single else target / 'test*.wav'} (full scale {full_scale:g} m/s2)")
    if clipping:
        click.echo(f"{clipping:,} of {size:,} tests clip, with peaks of up to {loudest:.3g} m/s2: softly compressed")


def _sounds(asked: RigConfig) -> Iterator[tuple[int, Sound]]:
    """Numbers of tests, and their sounds: of the acceleration itself, not of what a sensor shows."""
    from stickslip import sound
    from stickslip.rig.simulate.simulation import RigTests

    tests = RigTests(asked)
    for number in range(tests.grid.size):
        cell = {name: float(values[0]) for name, values in tests.grid.cells(number, number + 1).items()}
        seconds = float(tests.drive(cell)[:, 0].sum()) - cell["waiting_time"]
        changes = {
            "rate": float(sound.RATE), "bandwidth": None, "force_noise": 0.0, "acceleration_noise": 0.0,
            "oversampling": _FINE if seconds <= _SHORT else _COARSE,
        }  # fmt: skip
        sensor = asked.sensor.model_copy(update=changes)
        ideal = replace(asked, config=asked.config.model_copy(update={"sensor": sensor}))
        (test,) = RigTests(ideal).tests([number])
        if test.record is not None:
            values = test.record["acceleration"].values
            yield number, sound.of_record(values, sensor.rate, title=f"{asked.config.title}: {test.name}")
