"""What the engine is to compute for a configuration: the cells of its grid, or one of them, and the options.

A result holds the configuration it was computed from, so a cell can be picked out of a file as well.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import xarray as xr

from stickslip.config.model import Axis, Config, Group, Range, Values
from stickslip.config.reader import make_config, parse_config
from stickslip.config.resolve import with_table
from stickslip.config.rules import warn_of_units
from stickslip.config.yaml import Document, Setting, overridden, parse_yaml
from stickslip.engine import Options
from stickslip.errors import ConfigError, Problem, QuantityError
from stickslip.vocabulary.cells import Cells, Coordinate, Floats
from stickslip.vocabulary.display_units import units_shown
from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import (
    MEASURED,
    OF_EXTENSIONS,
    PARAMETERS,
    QUANTITIES,
    SEARCHABLE,
    SOLVER,
    STUDIES,
    VARIABLES,
    did_you_mean,
    listed,
)
from stickslip.vocabulary.units import number_or_text

_OF_CURVE = "_of_curve"


def build_grid(config: Config) -> Cells:
    """The cells of a configuration; nothing in them is as long as the grid."""
    fixed = config.fixed()
    dims: list[str] = []
    coords: list[Coordinate] = []
    along: dict[str, tuple[int, Floats]] = {}
    for number, axis in enumerate(config.axes):
        labels, name = axis.labels if isinstance(axis, Group) else None, axis.name
        if isinstance(axis, Values) and any(map(math.isnan, axis.values)):  # words, which are no index of numbers
            labels, name = tuple(map(QUANTITIES[name].setting, axis.values)), f"{name}_case"
        dims.append(name if isinstance(axis, Group) or labels else _coordinate_name(name))
        for member in axis.members:
            row, spacing = QUANTITIES[member.name], member.spacing if isinstance(member, Range) else "values"
            values = member.points()
            name = _coordinate_name(member.name)
            coords.append(Coordinate(name, dims[-1], values, row.units, row.long_name, spacing, labels))
            along[member.name] = (number, values)
    measured = {name: fixed.pop(name) for name in MEASURED if name in fixed}
    for model in MODELS:
        whole = model.completed({**fixed, **measured})
        if measured and all(name in whole for name in model.needed):
            fixed |= {name: float(whole[name]) for name in model.replaced}
            measured = {}
    return Cells(
        dims=tuple(dims),
        shape=tuple(axis.size for axis in config.axes),
        fixed={name: fixed[name] for name in (*PARAMETERS, *OF_EXTENSIONS) if name in fixed},
        along=along,
        measured=measured,
        coords=tuple(coords),
        written_in=config.written_in,
    )


def _coordinate_name(name: str) -> str:
    """Name of a quantity in a dataset, where a result may have the plain name (as it occurred)."""
    return name + _OF_CURVE if name in VARIABLES else name


def quantity_of(coordinate: str) -> str:
    """The quantity behind the name of a coordinate: the opposite of `_coordinate_name`."""
    return coordinate.removesuffix(_OF_CURVE)


def options_of(config: Config) -> Options:
    """The options with which cells of a configuration are integrated."""
    solver, execution = config.solver, config.execution
    return Options(
        law=config.friction.law,
        rtol=solver.rtol,
        horizon=math.inf if solver.horizon is None else solver.horizon,
        max_steps=solver.max_steps,
        early_stop=solver.early_stop,
        threads=execution.threads,
        block=execution.block,
    )


def map_options_of(config: Config) -> Options:
    """The options of a map, of which some variables may be all that is kept."""
    return replace(options_of(config), variables=config.output.variables)


# --- one cell ---------------------------------------------------------------------------------------------------------

Recipe = Config | Mapping[str, Any]  # a configuration, or what cells computed one by one share: friction law and solver


def cell_of(config: Config) -> dict[str, float]:
    """Parameters of the cell of a configuration without axes, in SI, by names of `PARAMETERS`."""
    return {name: float(values[0]) for name, values in build_grid(config)[:1].items()}


def config_at(recipe: Recipe, settings: Iterable[str], option: str = "--at", in_part: bool = False) -> Config:
    """The configuration of one cell; in_part : or of fewer axes, those that have no setting.

    settings : texts like ``stiffness=5 N/mm``, ``velocity=sticking`` or, for quantities that vary together,
        ``lubricant=grease`` (a label, or a position counted from 0). Every axis needs one, other quantities may have
        one. Numbers without a unit that are implausible in SI are asked about, as in files (UnitWarning).
    option : of the command line, that problems name.
    Raises ConfigError.
    """
    config = recipe if isinstance(recipe, Config) else None
    data = _sections(recipe)
    axes: dict[str, Axis] = {axis.name: axis for axis in config.axes} if config else {}
    given = {}
    for name, equals, text in (setting.partition("=") for setting in settings):
        if not equals:
            raise ConfigError.of(option, f"got {name!r}, expected NAME=VALUE")
        given[name.strip()] = text.strip()
    picked: dict[str, dict[str, Any]] = {}  # without groups, which have their values from the file
    for name, text in given.items():
        if isinstance(axis := axes.get(name), Group):
            i = _position(axis, text, option)
            values = {m.name: QUANTITIES[m.name].written(m.values[i]) for m in axis.members}
        elif name in axes or name in QUANTITIES:
            values = {name: number_or_text(text)}
            picked.setdefault(QUANTITIES[name].section, {}).update(values)
        else:
            known = [*axes, *(quantity for quantity in QUANTITIES if quantity not in axes)]
            message = f"unknown quantity, expected {listed(known)}"
            raise ConfigError.of(option, message, did_you_mean(name, known), path=(name,))
        for quantity, value in values.items():
            data[QUANTITIES[quantity].section][quantity] = value
    left = {name: axis for name, axis in axes.items()
            if name not in given and not all(member.name in given for member in axis.members)}  # fmt: skip
    if left and not in_part:
        expected = ("a value for this axis", "one of the points of the group")
        raise ConfigError(option, [
            Problem((name,), f"missing, expected {expected[isinstance(axis, Group)]}",
                    hint=f"{option} {name}={point_text(axis, 0)}") for name, axis in left.items()
        ])  # fmt: skip
    data = {key: value for key, value in data.items() if key not in STUDIES}
    made = make_config(data | {"axes": {name: data["axes"][name] for name in left}}, option)
    warn_of_units(Document(option, picked), made)
    return made.shown_in(config.written_in | made.written_in) if config else made


def recipe_of(ds: xr.Dataset, name: str, settings: Iterable[Setting] = ()) -> Recipe:
    """The configuration, or less, that a result was computed from; `name` is that of its file. Raises ConfigError.

    settings : of a command line, which are put into it.
    """
    if "regime" not in ds.data_vars:
        raise ConfigError.of(name, "holds no regimes, expected a map or a list of cells")
    text, source, settings = str(ds.attrs.get("configuration", "")), f"{name} (configuration)", tuple(settings)
    shared = with_table(overridden(parse_yaml(text, source), settings)).data
    if isinstance(shared, dict) and "system" not in shared and "axes" not in shared:  # `evaluate` wrote it
        return shared
    return parse_config(text, source, settings, apart="").shown_in(units_shown(ds))


def shared_by(ds: xr.Dataset) -> dict[str, Any]:
    """The law, rtol and max_steps that all cells of a result have in common, as `simulate` takes them.

    Raises ConfigError.
    """
    recipe = recipe_of(ds, "this dataset")
    plain = recipe.resolved() if isinstance(recipe, Config) else recipe
    solver = plain.get("solver", {})
    shared = {name: solver[name] for name in ("rtol", "max_steps") if name in solver}
    return {"law": plain.get("friction", {}).get("law", "stribeck")} | shared


def seconds(text: str, option: str = "--duration") -> float:
    """A time on the command line: a number of seconds, or a text with a unit. Raises ConfigError."""
    return in_si(SOLVER["horizon"], text, option)


def in_si(row: Parameter, text: str, option: str, *path: str) -> float:
    """A value of a row of the vocabulary on the command line, in SI. Raises ConfigError."""
    try:
        return row.read(number_or_text(text))
    except QuantityError as error:
        raise ConfigError.of(option, f"got {text!r}, {error}", path=path) from None


def _sections(recipe: Recipe) -> dict[str, Any]:
    """The recipe as plain data with every section that holds quantities."""
    if isinstance(recipe, Config):
        return recipe.model_copy(update={"uncertain": None}).resolved()  # its quantities need values as axes do
    sections: dict[str, Any] = {quantity.section: {} for quantity in SEARCHABLE.values()}
    given = {name: {key: value for key, value in keys.items() if value is not None} for name, keys in recipe.items()}
    return sections | {"axes": {}} | given


def point_text(axis: Axis, i: int) -> str:
    """Point `i` of an axis as a setting."""
    if isinstance(axis, Group):
        label = axis.labels[i] if axis.labels else ""
        return label if label and label == label.strip() else str(i)
    return QUANTITIES[axis.name].setting(float(axis.points()[i]))


def _position(group: Group, text: str, option: str) -> int:
    """The point of a group that a setting names, by its label or counted from 0."""
    labels = group.labels or ()
    if text in labels:
        return labels.index(text)
    if text.isdecimal() and int(text) < group.size:
        return int(text)
    expected = listed([*labels, f"a position from 0 to {group.size - 1}"])
    raise ConfigError.of(option, f"got {text!r}, expected {expected}", path=(group.name,))
