"""Borders in planes of two parameters as lines with loops, every node solved along a side of a fine grid."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar

import numpy as np
import xarray as xr
from pydantic import Field

from stickslip.config.model import Config, Group
from stickslip.config.sections import RANGE, Read, StudySection, choice, interval, of_row, refused
from stickslip.config.studies import Moved, Regime, ReportTable, search_attributes, search_settings, shown
from stickslip.dataset.build import NO_FILL, attributes_of, grid_coordinates, shown_in, variable_of
from stickslip.dataset.display import CONTAINER, plane_names, polylines, unit_of
from stickslip.engine import Options, Results, StopFlag, joined
from stickslip.errors import ArgumentError
from stickslip.studies.lines import (
    PARAMETER,
    CellsOrConfig,
    OpenSection,
    OpenStudy,
    Ranges,
    Side,
    by_model,
    fine_enough,
    limits,
    opened,
    search_options,
)
from stickslip.studies.plane import PlaneSearch
from stickslip.studies.search import Integers
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.models import STRIBECK
from stickslip.vocabulary.models.memory import CONTOUR_POINTS
from stickslip.vocabulary.parameter import Parameter, Variable, table
from stickslip.vocabulary.quantities import QUANTITIES, REGIMES, SEARCHABLE

_PER_POINT = 40  # cells a border takes per grid point along one side of the plane, about
_PANEL, _PER_CELL = 4096, 64  # panels weigh as a block of a map, or more; grid points per cell that a block may hold

_POINTS = by_model(STRIBECK.contour_points, CONTOUR_POINTS)
_LINE, _NODE = ("line",), ("node",)
VARIABLES = table(
    Variable("node_count", "1", "nodes of the line", dims=_LINE),
    Variable("regime_left", "1", "regime to the left of the line", dims=_LINE),
    Variable("regime_right", "1", "regime to the right of the line", dims=_LINE),
    Variable("closed", "1", "whether the line is a loop", comment="its last node is its first", dims=_LINE),
    Variable("node_width", "1", "width of the last bracket, over the side of the grid cell it lies on",
             dims=_NODE),
    Variable(
        "node_along", "1", "parameter that was searched along at the node",
        comment="the other one has the value of a grid point; junction: three or more regimes meet inside a grid cell",
        dims=_NODE,
    ),
)  # fmt: skip


def _two_axes(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 2 or value[0] == value[1]:
        raise refused("a list of the names of two different parameters, y and x")
    return value


def _ranges(value: object) -> object:
    """Ranges by parameter."""
    if not isinstance(value, Mapping):
        raise refused("a range for each of the two parameters: {belt_speed: [0.1, 1]}")
    names = [choice(name, SEARCHABLE, "a parameter of a cell", inside=True) for name in value]
    return {name: interval(QUANTITIES[name], value[name]) for name in names}


class Contours(OpenSection):
    """Borders of the regimes in planes of two parameters, as lines; the other axes are the panels."""

    key, options = "contours", {"axes": "--over"}
    rows = limits(
        "contours",
        "a node",
        Parameter("points", "1", "points of the grid along both parameters, whose sides are crossed; "
                  f"unless given {_POINTS}", key, at_least=2, at_most=8192, whole=True, absent=_POINTS),
        Parameter("scan", "1", "points of the grid along both parameters that are looked at first, at least", key,
                  default=64, at_least=2, at_most=8192, whole=True),
    )  # fmt: skip
    axes: Annotated[
        tuple[Annotated[str, PARAMETER], Annotated[str, PARAMETER]] | None,
        Read(_two_axes, {"type": "array", "minItems": 2, "maxItems": 2, "uniqueItems": True,
                         "items": PARAMETER.schema}),
    ] = Field(None, description="the two parameters, y and x; the last two axes unless given")  # fmt: skip
    between: Annotated[
        dict[str, tuple[float, float]] | None,
        Read(_ranges, {"type": "object", "propertyNames": PARAMETER.schema, "additionalProperties": RANGE}),
    ] = Field(
        None, description="by parameter, both ends of its range, the lower one first; those of its axis unless given"
    )
    points: int = of_row(rows["points"])  # None until `fine_enough`
    tolerance: float = of_row(rows["tolerance"])  # None until `fine_enough`
    scan: int = of_row(rows["scan"])
    rtol: float | None = of_row(rows["rtol"])

    def ranges(self, given: CellsOrConfig) -> Ranges:
        """The parameters of the plane, by default the last two axes of a configuration, with their ranges."""
        axes, between = self.axes, self.between or {}
        if axes is None:
            if not isinstance(given, Config):
                raise ArgumentError("axes", "missing; cells need the names of the two parameters that vary, (y, x)")
            names = [axis.name for axis in given.axes[-2:] if not isinstance(axis, Group)]
            if len(names) < 2:
                message = "missing; the last two axes of the configuration are not two single parameters"
                raise ArgumentError("axes", message)
            axes = names[0], names[1]
        if other := [name for name in between if name not in axes]:
            raise ArgumentError("between", f"got a range for {other[0]!r}, expected {axes[0]} or {axes[1]}")
        return {name: between.get(name) for name in axes}


class ContourStudy(OpenStudy):
    """The lines of all panels of a plane; its items are the panels.

    Columns: by panel how many lines; by line and by node the variables; `node_along` is 0 on a side along x, 1 along y,
    2 at a junction.
    """

    section: ClassVar[type[StudySection]] = Contours
    variables: ClassVar[Mapping[str, Variable]] = VARIABLES
    title, subject, over_map = "Contours of regimes", "node_count", True
    about = (
        "Lines, loops among them, whose points are found one by one to the tolerance. Only the surroundings of a line "
        "are computed, so that a fine grid costs no more than its lines are long. Other axes of CONFIG become panels."
    )
    examples = (
        "configs/quickstart.yaml --plot borders.png",
        "configs/quickstart.yaml -o borders.csv",
        "configs/start_state.yaml --set contours.points=1024 --plot basins.svg",
    )
    name, counted, ragged = "contours", "panels", True
    columns: Mapping[str, np.dtype[Any]] = (
        dict.fromkeys(("lines", "node_count"), np.dtype(np.int32))
        | dict.fromkeys(("closed", "regime_left", "regime_right", "node_along"), np.dtype(np.int8))
        | dict.fromkeys(("x", "y", "node_width"), np.dtype(np.float64))
    )

    def __init__(self, cells: Cells, y: Side, x: Side, section: Contours, options: Options) -> None:
        self._cells, self._y, self._x, self._section = cells, y, x, section
        self.dims, self.shape = cells.dims, cells.shape
        self.cells_each = section.scan**2 + _PER_POINT * (x.points + y.points)
        self.weight = max(_PANEL, x.points * y.points // _PER_CELL)
        self.options = search_options(options)

    @classmethod
    def of(cls, given: CellsOrConfig, section: Contours, options: Options) -> ContourStudy:
        """The lines in the plane of the section."""
        section, options = fine_enough(section, options)
        cells, (y, x) = opened(given, section.ranges(given), section.points, options)
        return cls(cells, y, x, section, options)

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | ReportTable]:
        """The first lines, how many there are, and how they were looked for."""
        yield from shown(_table(ds))
        yield f"lines    {ds.sizes['line']:,}, {int((ds['closed'] != 0).sum()):,} of them closed"
        yield search_settings(ds, "contour")

    @classmethod
    def is_drawn(cls, ds: xr.Dataset) -> bool:
        """Lines always are."""
        return True

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The lines of a range of panels."""
        parts = [self._searched(panel, stop, moved) for panel in items]
        whole = joined(parts) if parts else self.blank(items)
        return {name: whole[name].astype(dtype) for name, dtype in self.columns.items()}

    def _searched(self, panel: int, stop: StopFlag, moved: Moved | None) -> Results:
        """The columns of a panel; a study of other labels has its own."""
        how = self._section.scan, self._section.tolerance, self.options, stop, moved
        return PlaneSearch(self._cells, self._y, self._x, panel, *how).columns()

    def blank(self, items: range) -> Results:
        """Panels without lines."""
        blank = {name: np.zeros(0, dtype) for name, dtype in self.columns.items()}
        return blank | {"lines": np.zeros(len(items), np.int32)}

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The lines of all panels (`lines_dataset`)."""
        whole, y, x = joined(parts), self._y, self._x
        panel = np.repeat(np.arange(self._cells.size), whole["lines"])
        attributes = {**attributes, **search_attributes(self._section, self.options), "result": "contours"}
        return lines_dataset(whole, VARIABLES, y, x).assign_attrs(attributes).assign_coords(self._panels(panel))

    def _panels(self, panel: Integers) -> dict[str, xr.Variable]:
        """The coordinates of the panels, by line; those that are equal in all of them stay single numbers."""
        several, by_line = self._cells.size > 1, dict[str, xr.Variable]()
        places = dict(zip(self.dims, np.unravel_index(panel, self.shape), strict=True)) if several else {}
        for name, one in grid_coordinates(self._cells).items():
            if one.size == 1:
                by_line[name] = one.isel(dict.fromkeys(one.dims, 0))
            else:
                values = one.values[tuple(places[str(dim)] for dim in one.dims)]
                by_line[name] = xr.Variable("line", values, one.attrs, one.encoding)
        for dim, place in places.items():
            about = {"units": "1", "long_name": f"position along {dim}"}
            by_line.setdefault(dim, xr.Variable("line", np.asarray(place, np.int32), about))
        return by_line


def lines_dataset(whole: Results, rows: Mapping[str, Variable], y: Side, x: Side, called: str = "{}") -> xr.Dataset:
    """Lines in the manner of CF geometries (section 7.5).

    `line` counts lines, `node` their nodes one line after the other. The container ``geometry`` says which
    variables hold nodes and how many each line has; a closed line repeats its first node.
    rows : the variables of lines and nodes. called : what the coordinates of nodes are, about the parameter's name.
    """
    names = {axis: called.format(side.name) for side, axis in ((x, "x"), (y, "y"))}
    geometry = {"geometry_type": "line", "node_count": "node_count", "node_coordinates": " ".join(names.values())}
    variables = {CONTAINER: xr.Variable((), np.int8(0), geometry, NO_FILL)}
    meanings = {"closed": ("open", "closed"), "node_along": (x.name, y.name, "junction")}  # of this dataset alone
    for name, row in rows.items():
        if name in meanings:
            flags = attributes_of(row, meanings[name])
            variables[name] = xr.Variable(row.dims, whole[name].astype(np.int8), flags, NO_FILL)
        else:
            variables[name] = variable_of(row, row.dims, whole[name])
        if name.endswith(("_left", "_right")):
            variables[name].attrs[CONTAINER] = CONTAINER
    nodes = {}
    for side, axis in ((x, "x"), (y, "y")):
        parameter = SEARCHABLE[side.name]
        about = {"units": parameter.units, "long_name": parameter.long_name}
        about |= {"axis": axis.upper(), "axis_spacing": side.spacing}
        nodes[names[axis]] = shown_in(xr.Variable("node", whole[axis], about, NO_FILL), side.written_in)
    return xr.Dataset(variables, nodes)


def _table(ds: xr.Dataset) -> ReportTable:
    """A row per contour."""
    names = plane_names(ds)
    units = [unit_of(ds[name]) for name in names]
    panels = [str(name) for name, coordinate in ds.coords.items() if coordinate.dims == ("line",)]
    rows = []
    for number, line in enumerate(polylines(ds)):
        where = [str(ds[name].values[number]) for name in panels]
        ranges = [f"{unit.of(values.min()):.6g} to {unit.text(values.max())}"
                  for values, unit in zip((line.x, line.y), units, strict=True)]  # fmt: skip
        sides = (Regime(REGIMES[side]) for side in (line.left, line.right))
        rows.append([*where, *sides, "loop" if line.closed else "line", *ranges, f"{len(line.x):,}"])
    return ReportTable("The lines", [*panels, "to the left", "to the right", "", *names], ["points"], rows)
