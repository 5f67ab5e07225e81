"""Goals computed: items are the panels of a plane, each with its map, its borders, and what it would need."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from stickslip.config.grid import options_of, quantity_of
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.sections import StudySection
from stickslip.config.studies import Moved, ReportTable
from stickslip.dataset.build import NO_FILL, grid_coordinates, of_parameter, shown_in, study_dataset
from stickslip.dataset.display import axis_names, parts_over, unit_of
from stickslip.engine import Options, Results, StopFlag, joined
from stickslip.errors import ArgumentError
from stickslip.studies.changes import ChangeSpace, Reach, nearest, reach_of, turned_in
from stickslip.studies.contours import VARIABLES, ContourStudy, lines_dataset
from stickslip.studies.draws import Design
from stickslip.studies.lines import CellsOrConfig, Lines, fine_enough
from stickslip.studies.plane import OPEN, PlaneSearch
from stickslip.studies.search import Floats, Labels
from stickslip.vocabulary.cells import taken
from stickslip.vocabulary.display_units import customary, spoken
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.parameter import Variable, table
from stickslip.vocabulary.quantities import SEARCHABLE, VERDICTS
from stickslip_explain.goal import IMPOSSIBLE, PROBABILITY, QUIET, VIBRATES, Demand, Goal, goal_plane

_PER_POINT = 8  # places judged per grid point along one side of the plane, about
_ROUGHLY = 1.1  # times the way to a node of a border: how far along it the border is looked for
_PLANE = ("y", "x")  # stand for the parameters
_MAPS = table(
    Variable("quiet_probability", "1", "probability of being quiet over the whole range",
             comment="draws without a verdict do not count as quiet; NaN where there is no such cell", dims=_PLANE),
    Variable("quiet_probability_error", "1", "standard error of the probability of being quiet",
             comment="scatter over independent scramblings; at least that of one draw", dims=_PLANE),
    Variable("undecided_probability", "1", "share of the draws without a verdict", dims=_PLANE),
)  # fmt: skip
_OF_PANELS = table(
    Variable("verdict", "1", "verdict on what the panel has"),
    Variable("quiet_share", "1", "probability of being quiet over the whole range, of what the panel has"),
)
_PLACES = table(
    Variable("here", "parameter", "what the panel has"),
    Variable("alone", "parameter", "nearest change of the verdict along one parameter alone",
             comment="the least change that makes it quiet, or the largest that leaves it quiet"),
    Variable("together", "parameter", "nearest change of the verdict in both parameters",
             comment="changes are logarithms of ratios, or over a scale where the value is 0 or may change its sign"),
)  # fmt: skip
_LINES = table(*(
    replace(row, name=name.replace("regime", "verdict"), long_name=row.long_name.replace("regime", "verdict"))
    for name, row in VARIABLES.items()
))  # fmt: skip
_NAMES = dict(zip(VARIABLES, _LINES, strict=True))  # of the same, where borders are those of regimes


class _Plane(PlaneSearch):
    """A panel whose labels are verdicts; `demand` is about this panel alone."""

    demand: Demand

    @property
    def growth(self) -> None:
        """None: verdicts are about ranges and draws, of which theory knows nothing."""
        return

    def looked(self, x: Floats, y: Floats) -> tuple[Labels, Floats]:
        """Verdicts, and the guide to where they change."""
        judged = self.demand.judged(np.zeros(x.size, np.int64), {self.x.name: x, self.y.name: y})
        return judged.verdict, judged.guide

    def columns(self) -> Results:
        """The map at the points that are looked at first, and the lines."""
        places = (side.scanned(self.scan) for side in (self.y, self.x))
        row, column = (axis.ravel() for axis in np.meshgrid(*places, indexing="ij"))
        at = {self.x.name: self.x.places[column], self.y.name: self.y.places[row]}
        judged = self.demand.judged(np.zeros(row.size, np.int64), at, shares=True)
        self.boxes.learn(np.ravel_multi_index((row, column), self.boxes.shape), judged.verdict)
        maps = dict(zip(_MAPS, (judged.quiet, judged.error, judged.undecided), strict=True))
        maps = {name: np.where(judged.verdict == IMPOSSIBLE, np.nan, values) for name, values in maps.items()}
        return maps | {_NAMES.get(name, name): values for name, values in super().columns().items()}

    def needs(self, lines: Results, here: Mapping[str, float]) -> Results:
        """The verdict on what the panel has (y and x, by name), and where the nearest changes of it are."""
        demand, home = self.demand, np.zeros(1, np.int64)
        now = demand.judged(home, {}, shares=True)
        needs: Results = {"verdict": now.verdict, "quiet_share": now.quiet}
        if now.verdict[0] == IMPOSSIBLE or not np.isfinite([*here.values()]).all():
            return needs
        far = [QUIET] if now.verdict[0] != QUIET else [VIBRATES, OPEN]
        reaches = [reach_of(side.name, demand.cells, (side.low, side.high)) for side in (self.y, self.x)]
        ways = _nearest_node(lines, reaches)
        for i, reach in enumerate(reaches):
            border = nearest(demand, reach, np.array([VIBRATES], np.int8), far, self.scan, self.tolerance)
            if np.isfinite(border.change).any():
                up = int(np.nanargmin(np.abs(border.change[0])))
                ends = border.low[0, up], border.high[0, up]
                needs[f"alone_{reach.name}"] = np.array([ends[bool(up) == (far == [QUIET])]])  # which is quiet
                ways.append(np.eye(2)[i] * border.change[0, up])
        if (change := self._least(ways, reaches, far)) is not None:
            needs |= {f"together_{reach.name}": reach.at(change[i], home) for i, reach in enumerate(reaches)}
        return needs

    def _least(self, ways: Sequence[Floats], reaches: Sequence[Reach], far: list[int]) -> Floats | None:
        """The least change (2,) of both parameters that changes the verdict, on its quiet side, from near ones."""
        costs = np.linalg.norm(ways, axis=1) if ways else np.zeros(1)
        if not costs.all():
            return None
        space = ChangeSpace(self.demand, reaches, np.ones(2), far, np.inf)
        start = np.zeros(len(ways), np.int64), np.array(ways) / costs[:, np.newaxis], _ROUGHLY * costs
        directions, costs = turned_in(space, *start, self.tolerance)
        best = int(np.argmin(costs))
        within = 1.0 if far == [QUIET] else 1.0 - 2.0 * self.tolerance
        return directions[best] * costs[best] * within if np.isfinite(costs[best]) else None


def _nearest_node(lines: Results, reaches: Sequence[Reach]) -> list[Floats]:
    """The changes (2,) of y and x to the nearest node of the borders of what is quiet; none where there are none."""
    line = np.repeat(np.arange(lines["node_count"].size), lines["node_count"])
    sides = np.stack([lines["verdict_left"], lines["verdict_right"]])
    ours = (sides == QUIET).any(axis=0) & ~(sides == IMPOSSIBLE).any(axis=0)
    changes = np.stack([reach.change(lines[axis]) for reach, axis in zip(reaches, _PLANE, strict=True)], axis=1)
    changes = changes[ours[line] & np.isfinite(changes).all(axis=1)]
    return [changes[np.argmin((changes**2).sum(axis=1))]] if len(changes) else []


class GoalStudy(ContourStudy):
    """The regions of all panels; its items are the panels."""

    with_indices = False

    section: ClassVar[type[StudySection]] = Goal
    variables: ClassVar[Mapping[str, Variable]] = {**_MAPS, **_OF_PANELS, **_PLACES, **_LINES}
    title, name, subject, caption, over_map = "Goal", "goal", "quiet_probability", "region that is quiet", False
    about = (
        "The plane of two parameters is parted by where a cell is quiet over whole ranges, of the belt speed say: "
        "neither stick-slip nor another vibration lasts anywhere there. Where quantities scatter (`uncertain` in "
        "CONFIG) it is to be so with a probability. Other axes of CONFIG, materials say, become panels; for each is "
        "said which change of either parameter, or of both, it would need."
    )
    examples = (
        "configs/goal.yaml",
        "configs/goal.yaml --quiet-over belt_speed=15..60mm/s --with 99% --plot goal.png",
        'configs/quickstart.yaml --over stiffness damping --between damping 0 "1 N s/m" \\\n'
        "      --quiet-over belt_speed=0.3..1",
    )
    _section: Goal

    def __init__(self, given: CellsOrConfig, section: Goal, options: Options) -> None:
        self._goal = goal = goal_plane(given, section, options)
        super().__init__(goal.panels, goal.y, goal.x, section, options)
        uncertain = given.uncertain if isinstance(given, Config) else None
        self._drawn, self._scramblings, self._probability = dict[str, Floats](), 1, 1.0
        if uncertain is not None:
            design = Design(len(uncertain.names), uncertain.draws, uncertain.scramblings, uncertain.seed, False)
            self._drawn = uncertain.values(design.normals(design.place(0, design.per_cell)))
            self._scramblings, self._probability = uncertain.scramblings, section.probability or PROBABILITY
        nodes = section.scan**2 + _PER_POINT * (goal.x.points + goal.y.points)
        self.cells_each = nodes * len(next(iter(self._drawn.values()), (0,))) * section.samples ** len(goal.ranges)
        self._maps = [side.scanned(section.scan) for side in (goal.y, goal.x)]
        self._of_plane = {f"{what}_{side.name}": (row, side) for what, row in _PLACES.items()
                          for side in (goal.y, goal.x)}  # fmt: skip
        self._each = dict.fromkeys(_MAPS, self._maps[0].size * self._maps[1].size)  # values of a panel
        self._each |= dict.fromkeys((*_OF_PANELS, *self._of_plane), 1)
        self.columns = {_NAMES.get(name, name): kind for name, kind in ContourStudy.columns.items()}
        self.columns |= dict.fromkeys((*self._each, "computed"), np.dtype(np.float64)) | {"verdict": np.dtype(np.int8)}

    @classmethod
    def of(cls, given: CellsOrConfig, section: Any, options: Options) -> GoalStudy:
        """The region in the plane of the section."""
        return cls(given, *fine_enough(section, options))

    @classmethod
    def check(cls, section: Any, config: Config, problems: ProblemCollector) -> None:
        """Note a plane, or ranges, that cannot be asked about."""
        try:
            goal_plane(config, section, options_of(config))
        except ArgumentError as error:
            problems.add((section.key, error.key), error.what)

    @classmethod
    def lines_in(cls, section: Any, config: Config) -> Lines:
        """None: a goal has a map of its own."""
        return {}

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | ReportTable]:
        """The goal, and what each panel would need."""
        yield f"goal     {ds.attrs['goal']}"
        if bool((ds["verdict"] != 0).any()):
            yield cls.table(ds)

    @classmethod
    def table(cls, ds: xr.Dataset) -> ReportTable:
        """A row for each panel: verdict and probability, and the nearest changes along either parameter and in both."""
        dims = [*ds["verdict"].dims]
        names = ["quiet_share", *(f"{what}_{name}" for what in ("alone", "together")
                                  for name in ds["quiet_probability"].dims[-2:])]  # fmt: skip
        rows = []
        for where, part in parts_over(ds, dims):
            texts = (unit_of(part[name]).text(float(part[name]), 4) if part[name].notnull() else "-" for name in names)
            rows.append([*where, VERDICTS[int(part["verdict"])], *texts])
        headings = [name.replace("_", " ") for name in names]
        return ReportTable("Nearest changes of the verdict", [*axis_names(ds, dims), "verdict"], headings, rows)

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Figure | None:
        """The region, with what panels have and would need; of a variable its map."""
        from stickslip_explain.plots import plot_goal

        return plot_goal(ds, select, title=title, look=look) if variable is None else None

    def _searched(self, panel: int, stop: StopFlag, moved: Moved | None) -> Results:
        goal, section = self._goal, self._section
        search = _Plane(self._cells, goal.y, goal.x, panel, section.scan, section.tolerance, self.options, stop)
        search.demand = Demand(
            taken(goal.as_they_are, slice(panel, panel + 1)), self.options, stop, (), moved, goal.measured,
            goal.ranges, self._drawn, self._scramblings, self._probability,
        )  # fmt: skip
        columns, here = self.blank(range(1)) | search.columns(), {n: float(v[panel]) for n, v in goal.here.items()}
        columns |= {f"here_{name}": np.array([value]) for name, value in here.items()}
        columns |= {} if goal.is_plane else search.needs(columns, here)
        for name in ("verdict", "verdict_left", "verdict_right"):
            columns[name] = np.where(columns[name] == OPEN, VERDICTS.index("undecided"), columns[name])
        return columns

    def blank(self, items: range) -> Results:
        """Panels of which nothing is known."""
        unknown = {name: np.full(len(items) * each, np.nan) for name, each in self._each.items()}
        none: Results = {"verdict": np.zeros(len(items), np.int8), "computed": np.zeros(len(items))}
        return super().blank(items) | unknown | none

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """Over panels and the plane the probability; over panels what they need; and the borders as lines."""
        whole, (y, x) = joined(parts), (self._goal.y, self._goal.x)
        rows = {name: replace(row, dims=(y.name, x.name)) for name, row in _MAPS.items()} | dict(_OF_PANELS)
        rows |= {name: of_parameter(row, side.name) for name, (row, side) in self._of_plane.items()}
        shape = [place.size for place in self._maps]
        values = {name: whole[name].reshape(-1, *shape) if name in _MAPS else whole[name] for name in rows}
        attributes = {**attributes, **self._attributes()}
        ds = study_dataset("goal", rows, values, self.dims, self.shape, self._coordinates(), attributes)
        for name, (_, side) in self._of_plane.items():
            shown_in(ds[name].variable, side.written_in)
        lines = lines_dataset(whole, _LINES, y, x, "border_{}")
        about = {"units": "1", "long_name": "panel of the line, the last dimension running fastest"}
        panel = np.repeat(np.arange(self._cells.size, dtype=np.int32), whole["lines"])
        return ds.assign(lines.data_vars).assign_coords(lines.coords).assign(panel=("line", panel, about))

    def _coordinates(self) -> dict[str, xr.Variable]:
        """Those of the panels, without what varies in them, and those of the map."""
        goal, follows = self._goal, model_of(self.options.law).replaced if self._goal.measured else ()
        varied = {side.name for side in (goal.y, goal.x, *goal.ranges)} | self._drawn.keys()
        coordinates = {name: v for name, v in grid_coordinates(self._cells).items()
                 if quantity_of(name) not in varied and (v.dims or name not in follows)}  # fmt: skip
        for side, places in zip((goal.y, goal.x), self._maps, strict=True):
            row = SEARCHABLE[side.name]
            about = {"units": row.units, "long_name": row.long_name, "axis_spacing": side.spacing}
            coordinates[side.name] = xr.Variable(side.name, side.places[places], about, NO_FILL)
            shown_in(coordinates[side.name], side.written_in)
        return coordinates

    def _attributes(self) -> dict[str, Any]:
        """The goal."""
        rows = [(SEARCHABLE[side.name], (side.low, side.high)) for side in self._goal.ranges]
        texts = (f"{spoken(row.name)} {customary(row.units, *ends) or row.range_text(ends)}" for row, ends in rows)
        chance = f" with a probability of {100 * self._probability:g} %" if self._drawn else ""
        return {"goal": f"quiet over {' and '.join(texts)}{chance}", "goal_probability": self._probability}
