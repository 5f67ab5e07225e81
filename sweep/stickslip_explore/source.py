"""The source of an explorer: a configuration, or a map that was computed from one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr

from stickslip.config.grid import options_of, quantity_of, recipe_of
from stickslip.config.model import Axis, Config
from stickslip.config.reader import load_config
from stickslip.config.sections import OUTPUT_SUFFIXES, Output
from stickslip.config.studies import study_class
from stickslip.config.yaml import Setting
from stickslip.engine import Options
from stickslip.errors import ConfigError
from stickslip.files import reading
from stickslip.files.locations import location
from stickslip.vocabulary.display_units import quantity, units_shown
from stickslip.vocabulary.quantities import QUANTITIES

_DRIVEN = "a test rig, whose cells have no regime"


@dataclass(frozen=True, eq=False)
class Source:
    """A configuration of a map, and the map if it was computed.

    name : of the file, as it was given. notes : what is left out of it here, for people. computed : the dataset of a
    result, whose data variables are read when they are used. assumed : values of what the file says no value of.
    """

    name: str
    config: Config
    notes: tuple[str, ...] = ()
    computed: xr.Dataset | None = None
    assumed: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def written_in(self) -> Mapping[str, str]:
        """By quantity, the unit in which it was written, of a result that its file shows it in."""
        of_file = {} if self.computed is None else units_shown(self.computed)
        return self.config.written_in | {quantity_of(name): unit for name, unit in of_file.items()}

    @cached_property
    def bare(self) -> Config:
        """The configuration without files to write."""
        return self.config.model_copy(update={"output": Output.model_construct(file=None, plot=None)})

    @cached_property
    def axes(self) -> Mapping[str, Axis]:
        """The axes of the configuration by name."""
        return {axis.name: axis for axis in self.config.axes}

    @cached_property
    def fixed(self) -> dict[str, float]:
        """The quantities that do not vary, in SI; NaN for words."""
        fixed = self.config.fixed()
        return {name: fixed[name] for name in QUANTITIES if name in fixed}

    @cached_property
    def typical(self) -> dict[str, float]:
        """Values of all quantities, in SI: what does not vary, and the middles of the axes, of lists without words."""
        numbers = {row.name: row.points()[~np.isnan(row.points())] for axis in self.config.axes for row in axis.members}
        return self.fixed | {name: float(v[v.size // 2]) if v.size else np.nan for name, v in numbers.items()}

    @cached_property
    def options(self) -> Options:
        """Options of the integration: until the regime is decided."""
        return replace(options_of(self.config), early_stop=True)


def open_source(path: str | Path, settings: Sequence[Setting] = ()) -> Source:
    """The source in a file, YAML or a result. Raises ConfigError for what is no map, StoreError for what is unreadable.

    settings : of a command line, which are put into the configuration; the map of a file is no more that of it then.
    """
    name, where = str(path), location(path)
    if where.suffix.lower() not in OUTPUT_SUFFIXES:
        return _of_config(name, load_config(path, settings))
    ds = reading.look_into(where)
    if "direction" in ds.dims:
        raise ConfigError.of(name, "a ramp, up and down, and no map", f"`stickslip plot {name}` draws it")
    recipe = recipe_of(ds, name, settings)
    if not isinstance(recipe, Config):
        raise ConfigError.of(name, "cells that were computed one by one, and no map", "a map has axes: `stickslip run`")
    source = _of_config(name, recipe)
    if recipe.uncertain is not None or settings:  # its cells are draws, or those of another configuration
        return source
    return replace(source, computed=ds)


def _of_config(file: str, config: Config) -> Source:
    """The map behind a configuration; studies of it are left out."""
    if not config.has_cells:
        raise ConfigError.of(file, f"got the configuration of {_DRIVEN}", f"stickslip rig {file}")
    notes, medians = [], dict[str, float]()
    if (uncertain := config.uncertain) is not None:
        drawn = uncertain.values(np.zeros((1, len(uncertain.names))))
        medians = {name: float(drawn[name][0]) for name in uncertain.names}
        if config.study is not None and (seen := study_class(config.study.key).conditions(config.study)):
            along = {member.name for axis in config.axes for member in axis.members}  # which hold where both are given
            config = config.at(**{name: value for name, value in seen.items() if name not in along})
            medians = {name: value for name, value in medians.items() if name not in along}
        config = config.at(**medians)
        words = (f"{name} {quantity(value, QUANTITIES[name].units)}" for name, value in medians.items())
        notes.append(f"what is uncertain has its median here: {', '.join(words)}")
    if config.study is not None:
        notes.append(f"not shown here: what the section {config.study.key} asks for")
    return Source(file, config.plain_map(), tuple(notes), assumed=medians)
