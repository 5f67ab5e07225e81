"""What the engine is to compute for a configuration: the cells of its grid, and how they are integrated."""

import math
from dataclasses import replace

from stickslip.config.model import Config, Group, Range, Values
from stickslip.engine import Options
from stickslip.vocabulary.cells import Cells, Coordinate, Floats
from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.quantities import MEASURED, OF_EXTENSIONS, PARAMETERS, QUANTITIES
from stickslip.vocabulary.results import VARIABLES

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
