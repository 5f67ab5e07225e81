"""What may be asked of a picture on the command line: title, size, units, scales, marks; and its default name."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.cli import screen
from stickslip.cli.common import fail, prepare_kernels

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from stickslip.plots import Look, Mark

_INCH = 0.0254  # m
_PIXELS = re.compile(r"(\d+)\s*px")
_SMALLEST, _LARGEST = 1.0, 100.0  # inches of a side
_NO_FILE_NAME = re.compile(r"[^\w.+-]+")


@dataclass(frozen=True)
class Picture:
    """The options of `plot` that shape a picture, as texts."""

    title: str | None = None
    size: str | None = None
    dpi: int | None = None
    units: tuple[str, ...] = ()
    log: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()
    marks_file: Path | None = None
    no_hatch: bool = False
    no_note: bool = False

    def prepared(self, ds: xr.Dataset) -> xr.Dataset:
        """The dataset, to be shown in the units that are asked for, or that limits have. Raises PlotError."""
        from stickslip.dataset.display import with_units
        from stickslip.plots.options import pairs
        from stickslip.vocabulary import units

        ends = [end for text in self.limits for end in pairs(text, "LOW..HIGH with a unit")]
        wanted = {name: unit for name, text in ends if (unit := units.unit_in(text.rpartition("..")[2]))}
        wanted |= {name: unit for text in self.units for name, unit in pairs(text, "UNIT")}
        return with_units(ds, wanted) if wanted else ds

    def look(self, ds: xr.Dataset) -> Look:
        """What a map is to look like. Raises PlotError."""
        from stickslip.plots import Look

        look = Look.of(ds, log=self.log, limits=self.limits, marks=self.marks, hatched=not self.no_hatch,
                       held=not self.no_note)  # fmt: skip
        return look if self.marks_file is None else replace(look, marks=(*look.marks, *_points(ds, self.marks_file)))

    def save(self, figure: Figure, target: Path, request: str = "") -> None:
        """Write a figure in the size and at the resolution that are asked for. Raises PlotError."""
        from stickslip import plots
        from stickslip.plots.layout import resize

        if self.size is not None:
            resize(figure, *inches(self.size, self.dpi or plots.DPI))
        plots.save(figure, target, self.dpi or plots.DPI, request)

    def request(self) -> dict[str, Any]:
        """Those options that are given."""
        return {name: value for name, value in vars(self).items() if value}


def _points(ds: xr.Dataset, path: Path) -> list[Mark]:
    """The operating points of a file, which say their regimes: computed there, not those of the cells around."""
    from stickslip import api
    from stickslip.config.select import shared_by
    from stickslip.dataset.selection import one_cell
    from stickslip.plots.options import marks_in
    from stickslip.vocabulary.flags import REGIMES, flag_label

    points = [*marks_in(ds, path)]
    if "regime" not in ds or "configuration" not in ds.attrs:
        return points
    try:
        cells, how = [one_cell(ds, {str(name): at for name, at in mark.at.items()}) for mark in points], shared_by(ds)
    except ValueError:  # a point does not say where it is along each axis, which whoever draws it will say
        return points
    prepare_kernels(how["law"])
    regimes = api.evaluate({name: [cell[name] for cell in cells] for name in cells[0]}, **how)["regime"].values
    points = [replace(mark, regime=REGIMES[int(code)]) for mark, code in zip(points, regimes, strict=True)]
    for mark in points:
        screen.echo(f"mark     {mark.label}: {flag_label(mark.regime)}")
    return points


def inches(text: str, dpi: int) -> tuple[float, float]:
    """`16 cm x 9 cm` or `1920 px x 1080 px` as width and height; a width without a unit has that of the height."""
    from stickslip.errors import QuantityError
    from stickslip.vocabulary import units

    sides = [side.strip() for side in re.split(r"\s*[x×]\s*(?=[\d.])", text)]
    if len(sides) == 2 and (unit := _PIXELS.fullmatch(sides[1]) and "px" or units.unit_in(sides[1])):
        sides[0] += "" if re.search(r"[a-zµ]", sides[0]) else f" {unit}"
    found = []
    for side in sides:
        try:
            pixels = _PIXELS.fullmatch(side)
            found.append(int(pixels[1]) / dpi if pixels else _length(side) / _INCH)
        except QuantityError:
            fail(f"--size: got {text!r}, expected a width and a height such as '16 cm x 9 cm' or '1920 px x 1080 px'")
    if len(found) != 2 or not all(_SMALLEST <= one <= _LARGEST for one in found):
        fail(f"--size: got {text!r}, expected a width and a height between 2.54 cm and 2.54 m, such as '16 cm x 9 cm'")
    return found[0], found[1]


def _length(text: str) -> float:
    from stickslip.errors import QuantityError
    from stickslip.vocabulary import units

    if not units.unit_in(text):
        raise QuantityError("a length")
    return units.si_value(text, "m")


def free_name(stem: Path, variable: str | None, places: Mapping[str, str], request: str) -> Path:
    """The name of a picture nobody named: FILE.png, FILE-VARIABLE.png, FILE-VARIABLE-DIM=VALUE.png.

    stem : FILE, without suffix. variable : unless it is what the file shows by itself. Where another picture has the
    name, one made for another request or by somebody else, it gets a number: FILE-2.png.
    """
    from stickslip.plots import request_of

    words = [stem.name, *filter(None, [variable]), *(f"{name}={value}" for name, value in places.items())]
    base = _NO_FILE_NAME.sub("_", "-".join(words).replace("=", "-")) if len(words) > 1 else stem.name
    number = 1
    while True:
        target = stem.with_name(f"{base}-{number}.png" if number > 1 else f"{base}.png")
        if not target.exists() or request_of(target) == request:
            return target
        number += 1
