"""What goes with borders on the command line: the map behind them, and a table of their points."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli.common import WHERE

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.config.model import Axis, Config
    from stickslip.files.locations import Location

MAP = click.option(
    "--map", "map_file", type=WHERE,
    help="Map to draw the borders over, of the same cells.  [default: a coarse one is computed]",
)  # fmt: skip
_COARSE = 160  # points of an axis of the map that is computed to be drawn


@dataclass(frozen=True)
class Extras:
    """What is wanted besides a result and its plot: the file of the map behind it, a table to write, a page."""

    map: Location | None = None
    table: Path | None = None
    page: Path | None = None

    @property
    def any(self) -> bool:
        """Whether there is something to write."""
        return self.table is not None or self.page is not None

    def write_table(self, ds: xr.Dataset) -> None:
        """Write the table, if one is wanted, and say so."""
        if self.table is None:
            return
        from stickslip.cli.tables import tell_table, write_table

        tell_table(write_table(ds, self.table), self.table)

    def map_behind(self, ds: xr.Dataset) -> xr.Dataset:
        """The map over which the borders of a dataset are drawn. Raises StoreError for a file that is none."""
        if self.map is not None:
            from stickslip.files import reading

            return reading.look_into(self.map)
        from stickslip import api
        from stickslip.config.reader import parse_config
        from stickslip.config.written import units_shown

        asked = parse_config(str(ds.attrs["configuration"]), "the configuration of the borders")
        return api.run(coarse_map(asked).shown_in(units_shown(ds)))


def coarse_map(config: Config) -> Config:
    """The configuration of a map in which the borders that a configuration asks for lie, with few cells."""
    from stickslip.config.lines import line_along
    from stickslip.config.planes import plane_along

    if config.border is not None:
        found = {config.border.along: line_along(config, config.border.along, config.border.between)}
    elif config.contours is not None:
        found = plane_along(config, config.contours.axes, config.contours.between or {})
    else:
        return config
    axes: list[Axis] = []
    for axis in config.axes:
        name = next((name for name, line in found.items() if line.axis is axis), None)
        axes.append(_coarse(axis) if name is None else _over(name, *found.pop(name)[1:]))
    axes += [_over(name, *line[1:]) for name, line in found.items()]
    if config.contours is not None:
        names = plane_along(config, config.contours.axes, config.contours.between or {})
        axes.sort(key=lambda axis: [*names].index(axis.name) if axis.name in names else -1)
    return _without_fixed(config, axes)


def _without_fixed(config: Config, axes: list[Axis]) -> Config:
    """The configuration of a map over these axes; what they vary is fixed no longer."""
    from stickslip.config.studies import STUDIES
    from stickslip.vocabulary.quantities import QUANTITIES

    changed: dict[str, Any] = {**dict.fromkeys(STUDIES), "axes": tuple(axes)}
    for axis in axes:
        if axis.name in QUANTITIES:
            section = QUANTITIES[axis.name].section
            changed[section] = changed.get(section, getattr(config, section)).model_copy(update={axis.name: None})
    return config.model_copy(update=changed)


def _coarse(axis: Axis) -> Axis:
    from stickslip.config.model import Range

    return axis.model_copy(update={"num": min(axis.num, _COARSE)}) if isinstance(axis, Range) else axis


def _over(name: str, between: tuple[float, float], spacing: str | None) -> Axis:
    """An axis over a range; by ratio where that is how it is searched."""
    from stickslip.borders import Scan
    from stickslip.config.model import Range

    spacing = spacing or Scan.over(*between, 2).spacing
    return Range.model_construct(name=name, spacing=spacing, start=between[0], stop=between[1], num=_COARSE)
