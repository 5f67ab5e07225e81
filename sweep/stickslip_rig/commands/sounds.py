"""Sounds of tests and records: an option of commands, where an extension brings `stickslip.sound`."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import click
import xarray as xr

from stickslip import extensions
from stickslip.cli import params, screen
from stickslip.cli.screen import fail
from stickslip.files.targets import Kind

_WAV = Kind("sounds", (".wav",))


def sound_option(each: str) -> Callable[[params.Command], params.Command]:
    """The option `--sound` of a command that has an `each`; none where nothing makes sounds."""
    if "sound" not in extensions.brought("calls"):
        return lambda command: command
    text = f"Folder for the sounds, a WAV file for each {each}."
    return click.option("--sound", type=params.Target(_WAV, "folder"), help=text)


def check_sounds(target: Path | None, count: int) -> None:
    """End if so many sounds cannot be written there."""
    if target is not None and target.suffix.lower() == ".wav" and count != 1:
        fail(f"{target}: {count:,} tests have a WAV file each: name a folder")


def maker() -> Any:
    """The module `stickslip.sound`."""
    return extensions.call("sound", "stickslip")


def save_sounds(target: Path, records: Iterable[tuple[str, str, xr.Dataset]]) -> None:
    """Write what is heard of records, a file each, into a folder; or the one there is.

    records : the names of their files, titles, and the records.
    """
    from stickslip.files.targets import NO_FILE_NAME
    from stickslip_rig.signals import evenly, sample_rate

    def sounds() -> Iterator[tuple[str, Any]]:
        for name, title, record in records:
            if "acceleration" not in record:
                fail(f"{name}: no column of acceleration, which is what is heard")
            even = evenly(record)
            rate = sample_rate(even["time"].values)
            yield NO_FILE_NAME.sub("_", name), maker().of_record(even["acceleration"].values, rate, title=title)

    files, *remarks = maker().save_all(target, sounds())
    screen.row("sounds", files)
    for remark in remarks:
        screen.echo(remark)
