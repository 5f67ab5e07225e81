"""What is explored: a configuration, or a map that was computed from one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.grid import quantity_of
from stickslip.config.model import Axis, Config
from stickslip.config.options import options_of
from stickslip.config.overrides import Setting
from stickslip.config.reader import load_config
from stickslip.config.sections import OUTPUT_SUFFIXES, Output
from stickslip.config.select import recipe_of
from stickslip.config.studies import STUDIES
from stickslip.engine import Options
from stickslip.errors import ConfigError, Problem
from stickslip.explore.readable import quantity
from stickslip.files import reading
from stickslip.files.locations import Location, location
from stickslip.vocabulary.display_units import units_shown
from stickslip.vocabulary.quantities import QUANTITIES

_DRIVEN = "a test rig, whose cells have no regime"


@dataclass(frozen=True, eq=False)
class Subject:
    """A configuration of a map, and the map if it was computed.

    source : the file, as it was named. notes : what is left out of it here, for people. computed : the dataset of a
    result, whose data variables are read when they are used. assumed : values of what the file says no value of.
    """

    source: str
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
    def plain(self) -> dict[str, Any]:
        """The configuration as plain data, without files to write."""
        return self.config.model_copy(update={"output": Output.model_construct(file=None, plot=None)}).resolved()

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
    def options(self) -> Options:
        """How cells are integrated: until the regime is decided."""
        return replace(options_of(self.config), early_stop=True)


def open_subject(path: str | Path, settings: Sequence[Setting] = ()) -> Subject:
    """What a file holds, YAML or a result. Raises ConfigError for what is no map, StoreError for what is unreadable.

    settings : of a command line, which are put into the configuration; the map of a file is no more that of it then.
    """
    where = location(path)
    if where.suffix.lower() not in OUTPUT_SUFFIXES:
        return _of_config(str(path), load_config(path, settings))
    return _of_result(str(path), where, settings)


def _of_result(source: str, where: Location, settings: Sequence[Setting]) -> Subject:
    """The map in a file, with the configuration it was computed from."""
    ds = reading.look_into(where)
    if "direction" in ds.dims:
        raise _no_map(source, "a ramp, up and down, and no map", f"`stickslip plot {source}` draws it")
    recipe = recipe_of(ds, source, settings)
    if not isinstance(recipe, Config):
        raise _no_map(source, "cells that were computed one by one, and no map", "a map has axes: `stickslip run`")
    subject = _of_config(source, recipe)
    if recipe.uncertain is not None or settings:  # its cells are draws, or those of another configuration
        return subject
    return replace(subject, computed=ds)


def _of_config(source: str, config: Config) -> Subject:
    """The map behind a configuration, whatever is asked of it."""
    if config.drive is not None or config.sensor is not None:
        raise _no_map(source, f"got the configuration of {_DRIVEN}", f"stickslip rig {source}")
    notes, medians = [], dict[str, float]()
    asked = {name: None for name in STUDIES if getattr(config, name, None) is not None}
    if config.uncertain is not None:
        config, medians = _at_medians(config)
        words = ", ".join(f"{name} {quantity(value, QUANTITIES[name].units)}" for name, value in medians.items())
        notes.append(f"what is uncertain has its median here: {words}")
    others = [name for name in asked if name != "uncertain"]
    if others:
        notes.append(f"not shown here: what the section {', '.join(others)} asks for")
    return Subject(source, config.model_copy(update=asked), tuple(notes), assumed=medians)


def _at_medians(config: Config) -> tuple[Config, dict[str, float]]:
    """The configuration with the medians of what is uncertain, and these."""
    assert config.uncertain is not None
    names = config.uncertain.names
    drawn = config.uncertain.values(np.zeros((1, len(names))))
    medians = {name: float(drawn[name][0]) for name in names}
    sections: dict[str, Any] = {}
    for name in names:
        section = QUANTITIES[name].section
        sections[section] = sections.get(section, getattr(config, section)).model_copy(update={name: medians[name]})
    return config.model_copy(update={**sections, "uncertain": None}), medians


def _no_map(source: str, message: str, hint: str) -> ConfigError:
    return ConfigError(source, [Problem((), message, hint=hint)])
