"""`rig run --sound` and `rig features --sound`: the acceleration of the specimen, a WAV file a test."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.cli import screen
from stickslip.cli.common import fail
from stickslip.cli.listen import save_sound

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.rig.config import RigConfig
    from stickslip.sound import Sound

_FINE, _COARSE = 8, 2  # samples computed per sample of sound: of short tests, and of long ones, which take much memory
_SHORT = 20.0  # s
_NO_FILE_NAME = re.compile(r"[^\w.+-]+")


def check(target: Path, size: int) -> None:
    """End if no sounds of so many tests can be written there."""
    if target.suffix.lower() == ".wav":
        if size != 1:
            fail(f"{target}: {size:,} tests have a WAV file each: name a folder")


def write_tests(target: Path, asked: RigConfig) -> None:
    """The sound of every test that was integrated to its end, from the first stroke on."""
    from stickslip.rig.simulation import RigTests

    digits = len(str(RigTests(asked).grid.size - 1))
    _write(target, ((f"test{number:0{digits}d}", heard) for number, heard in _sounds(asked)))


def write_records(target: Path, records: Mapping[str, xr.Dataset]) -> None:
    """The sound of every record, as its sensor shows it."""
    from stickslip import sound
    from stickslip.rig.signals import evenly, sample_rate

    def each() -> Iterator[tuple[str, Sound]]:
        for name, record in records.items():
            even = evenly(record)
            yield (
                _NO_FILE_NAME.sub("_", name),
                sound.of_record(even["acceleration"].values, sample_rate(even["time"].values), title=name),
            )

    _write(target, each())


def _write(target: Path, sounds: Iterable[tuple[str, Sound]]) -> None:
    """A file each, in the folder; or the one there is."""
    single = target.suffix.lower() == ".wav"
    written, clipping, loudest, full_scale = 0, 0, 0.0, 0.0
    for name, heard in sounds:
        save_sound(heard, target if single else target / f"{name}.wav")
        full_scale, loudest = heard.full_scale, max(loudest, heard.peak)
        written, clipping = written + 1, clipping + heard.clips
    if not written:
        screen.echo("sounds    none: no test was integrated to its end")
        return
    screen.echo(f"sounds    {target if single else target / '*.wav'} (full scale {full_scale:g} m/s2)")
    if clipping:
        screen.echo(f"{clipping:,} of {written:,} clip, with peaks of up to {loudest:.3g} m/s2: softly compressed")


def _sounds(asked: RigConfig) -> Iterator[tuple[int, Sound]]:
    """Numbers of tests, and their sounds: of the acceleration itself, not of what a sensor shows."""
    from stickslip import sound
    from stickslip.rig.simulation import RigTests

    tests = RigTests(asked)
    for number in range(tests.grid.size):
        cell = {name: float(values[0]) for name, values in tests.grid[number : number + 1].items()}
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
