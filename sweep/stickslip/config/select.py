"""One cell out of a configuration: its axes, and any other quantity, at chosen values.

A result holds the configuration it was computed from, so a cell can be picked out of a file as well.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import xarray as xr

from stickslip.config.grid import build_grid
from stickslip.config.model import Axis, Config, Group
from stickslip.config.reader import make_config, parse_config
from stickslip.config.resolve import with_table
from stickslip.config.unit_warnings import warn_of_units
from stickslip.config.yaml import Document, Setting, overridden, parse_yaml
from stickslip.errors import ConfigError, Problem, QuantityError
from stickslip.vocabulary.display_units import units_shown
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import QUANTITIES, SEARCHABLE
from stickslip.vocabulary.settings import SOLVER
from stickslip.vocabulary.studies import STUDIES
from stickslip.vocabulary.suggest import did_you_mean, listed
from stickslip.vocabulary.units import number_or_text

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
    given = dict(_split(setting, option) for setting in settings)
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
        raise ConfigError(option, [_missing(axis, option) for axis in left.values()])
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


def _split(setting: str, option: str) -> tuple[str, str]:
    name, equals, value = setting.partition("=")
    if not equals:
        raise ConfigError.of(option, f"got {setting!r}, expected NAME=VALUE")
    return name.strip(), value.strip()


def _position(group: Group, text: str, option: str) -> int:
    """The point of a group that a setting names, by its label or counted from 0."""
    labels = group.labels or ()
    if text in labels:
        return labels.index(text)
    if text.isdecimal() and int(text) < group.size:
        return int(text)
    expected = listed([*labels, f"a position from 0 to {group.size - 1}"])
    raise ConfigError.of(option, f"got {text!r}, expected {expected}", path=(group.name,))


def _missing(axis: Axis, option: str) -> Problem:
    expected = "one of the points of the group" if isinstance(axis, Group) else "a value for this axis"
    hint = f"{option} {axis.name}={point_text(axis, 0)}"
    return Problem((axis.name,), f"missing, expected {expected}", hint=hint)
