"""Rules between quantities, which must hold in every cell of the grid.

Grids have up to 1e10 cells, so nothing here walks over cells. Each rule is a margin that is monotone in every quantity
it involves: along an axis that varies one of them only the worst end can break it; of quantities that vary together all
points are tried. What is reported is the worst cell.

A friction curve in mm/s read as one in m/s breaks no rule: the map is computed, and shows no stick-slip anywhere. So
numbers beyond all contacts (`Parameter.plausible`) are asked about, and springs that stretch by metres. In
dimensionless studies, in which two of mass, stiffness and load are 1, friction and springs are not questioned.
"""

import math
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip.config.model import Axis, Config, Group, Range, Values
from stickslip.config.problems import Finding as Finding
from stickslip.config.resolve import varied_paths
from stickslip.config.uncertain import Uncertain
from stickslip.config.yaml import Document
from stickslip.errors import ConfigError, Path, Problem, UnitWarning
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import LIKELY
from stickslip.vocabulary.models import BREAKAWAY, model_of
from stickslip.vocabulary.quantities import QUANTITIES

MOST_CELLS = 10_000_000_000
_TRIED_DRAWS = 2**12  # what is rarer is met while computing, and such draws are `failed` there

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class QuantitySpace:
    """The quantities that were read without problems: what is fixed (NaN for words), varied, and uncertain."""

    fixed: Mapping[str, float]
    axes: Sequence[Axis]
    uncertain: Uncertain | None = None
    law: str = "stribeck"

    @cached_property
    def drawn(self) -> Mapping[str, Floats]:
        """Some draws of the uncertain quantities, as many of each, to hold the rules against."""
        if self.uncertain is None:
            return {}
        normals = np.random.default_rng(1).standard_normal((_TRIED_DRAWS, len(self.uncertain.names)))
        return self.uncertain.values(normals)

    @property
    def draws_per_cell(self) -> int:
        """Cells computed for each cell of the axes."""
        return 1 if self.uncertain is None else self.uncertain.draws_per_cell

    def names(self) -> set[str]:
        """All quantities, fixed, varied or uncertain."""
        return set(self.fixed) | set(self.drawn) | {member.name for axis in self.axes for member in axis.members}


def findings(space: QuantitySpace) -> Iterator[Finding]:
    """Everything that is wrong between the quantities of `space`. Rules about absent quantities are left out."""
    cells = math.prod(axis.size for axis in space.axes) * space.draws_per_cell
    if cells > MOST_CELLS:
        sizes = [str(axis.size) for axis in space.axes]
        shape = " x ".join([*sizes, *([f"{space.draws_per_cell} draws"] if space.draws_per_cell > 1 else [])])
        number = f"{cells:.3g}" if cells < 10**15 else f"10^{len(str(cells)) - 1}"  # no float is as large as some grids
        path: Path = ("axes",)
        hint = "use fewer points, or fewer axes"
        if space.draws_per_cell > MOST_CELLS:
            path, hint = ("uncertain", "draws"), "use fewer draws or scramblings"
        yield Finding(path, f"at most {MOST_CELLS:.0e}", hint, f"{number} cells ({shape})")
    for axis in space.axes:
        if isinstance(axis, Values):
            yield from _order(axis)
    yield from _between(space)


def _order(axis: Values) -> Iterator[Finding]:
    """Values of an axis differ, and numbers are monotone: they become a coordinate."""
    seen: dict[float | str, int] = {}
    for i, value in enumerate(map(QUANTITIES[axis.name].written, axis.values)):
        if value in seen:
            hint = f"it is the same as value number {seen[value] + 1}"
            yield Finding(("axes", axis.name, "values", i), "a value that is not in the list yet", hint)
        seen.setdefault(value, i)
    steps = np.diff(axis.points())
    if len(seen) == axis.size and not np.isnan(steps).any() and not ((steps > 0).all() or (steps < 0).all()):
        turn = 1 + int(np.flatnonzero(np.sign(steps) != np.sign(steps[0]))[0])
        hint = "sort them; a group (zip) keeps any order"
        yield Finding(("axes", axis.name, "values", turn), "values that rise or fall all the way", hint)


# --- rules ------------------------------------------------------------------------------------------------------------


def _between(space: QuantitySpace) -> Iterator[Finding]:
    """The rules of the model of the contact."""
    for rule in model_of(space.law).rules.get(space.law, ()):
        cell = worst_cell(space, rule.worse, rule.margin)
        if cell is not None and rule.is_broken(cell.margin, cell.values):
            yield cell.finding(rule.name, rule.expected(cell.values), rule.why)
            if rule.last:
                return


# --- the worst cell ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Cell:
    """One cell: the margin there, the values it comes from, and their positions in the file.

    wrong_draws : share of the draws with a margin below 0 in some cell; None where nothing uncertain is involved.
    """

    margin: float
    values: Mapping[str, float]
    paths: Mapping[str, Path]
    wrong_draws: float | None = None

    def finding(self, name: str, expected: str, hint: str) -> Finding:
        """The problem of a quantity. A draw of it, or of what it is compared with, is not what the file says."""
        if self.wrong_draws is None:
            return Finding(self.paths[name], expected, hint)
        share = f"{100 * self.wrong_draws:.2g} % of them are impossible"
        got = f"{self.values[name]:.6g} in the worst draw ({share})"
        return Finding(self.paths[name], expected, f"{hint}; truncate the distribution", got)


def worst_cell(
    space: QuantitySpace, worse: Mapping[str, int], margin: Callable[[Mapping[str, Floats]], Floats]
) -> _Cell | None:
    """The cell with the smallest margin.

    worse : by quantity, +1 if the margin falls as it grows, -1 if it rises, 0 if it is not monotone.
    Cells where a quantity is absent (NaN) do not count. None if there is no other, or a quantity is not in `space`.
    """
    if not set(worse) <= space.names():
        return None
    columns: dict[str, Floats] = {n: np.asarray(space.fixed[n], np.float64) for n in worse if n in space.fixed}
    indices: dict[str, tuple[Axis, int, NDArray[np.intp]]] = {}
    involved = [axis for axis in space.axes if any(m.name in worse for m in axis.members)]
    drawn = {name: values for name, values in space.drawn.items() if name in worse}
    named = [name for name in (*columns, *drawn, *(m.name for axis in involved for m in axis.members)) if name in worse]
    if len(set(named)) < len(named):  # one is given twice, which is reported
        return None
    dimensions = len(involved) + bool(drawn)
    for number, axis in enumerate(involved):
        here = {m.name: m.points() for m in axis.members if m.name in worse}
        chosen = _candidates(here, worse)
        for name, points in here.items():
            columns[name] = points[chosen].reshape([-1 if i == number else 1 for i in range(dimensions)])
            indices[name] = (axis, number, chosen)
    columns |= drawn  # along the last dimension
    margins = np.atleast_1d(margin(columns))
    if np.isnan(margins).all():
        return None
    at = np.unravel_index(int(np.nanargmin(margins)), margins.shape)
    values = {n: float(np.broadcast_to(c, margins.shape)[at]) for n, c in columns.items()}
    paths: dict[str, Path] = {n: (QUANTITIES[n].section, n) for n in worse}
    paths |= {n: _path(axis, n, int(chosen[at[number]])) for n, (axis, number, chosen) in indices.items()}
    paths |= {name: ("uncertain", "quantities", name) for name in drawn}
    wrong = float((margins < 0).any(axis=tuple(range(margins.ndim - 1))).mean()) if drawn else None
    return _Cell(float(margins[at]), values, paths, wrong)


def _candidates(points: Mapping[str, Floats], worse: Mapping[str, int]) -> NDArray[np.intp]:
    """Points of an axis that can be the worst: one for a lone quantity, all for several that vary together."""
    if len(points) > 1 or not all(worse[name] for name in points):
        return np.arange(len(next(iter(points.values()))))
    ((name, values),) = points.items()
    ranked = worse[name] * values
    return np.array([0 if np.isnan(ranked).all() else int(np.nanargmax(ranked))])


def _path(axis: Axis, name: str, i: int) -> Path:
    """The position of value number `i` of the quantity `name` along `axis`."""
    if isinstance(axis, Group):
        return ("axes", axis.name, "zip", name, i)
    if isinstance(axis, Range):
        return ("axes", axis.name, "start" if i == 0 else "stop")
    return ("axes", axis.name, "values", i)


# --- numbers that are implausible in SI -------------------------------------------------------------------------------

_FARTHEST = 1.0  # m, static deflection of a spring that holds a sliding contact
_HEAVY = 1000.0  # kg; from here on it may be a fault of the earth, whose springs are long
_DIMENSIONLESS = ("mass", "stiffness", "normal_load")
_HINT = "numbers without a unit are in SI; write the unit, as in '20 mm/s' (`stickslip help configuration`)"


def warn_of_units(document: Document, config: Config) -> None:
    """Warn of the numbers in a document that are implausible in SI, at the line outside of this package."""
    if (text := unit_question(document, config)) is None:
        return
    frame, depth = sys._getframe(), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("stickslip."):
        frame, depth = frame.f_back, depth + 1
    warnings.warn(text, UnitWarning, stacklevel=depth)


def unit_question(document: Document, config: Config) -> str | None:
    """The question about the numbers of a document, `config` being what it comes to; None if all are plausible.

    What is not written there but stands behind its words, a fitted curve say, is not asked about.
    """
    sections = [(key, name) for key, inside in document.data.items() if isinstance(inside, dict) for name in inside]
    written = {path[-1]: path for path in (*sections, *varied_paths(document.data.get("axes")))}
    places = document.values | document.keys
    doubts = [Problem(written[name], question, places.get(written[name]))
              for name, question in _questions(config) if name in written]  # fmt: skip
    return f"{ConfigError(document.name, doubts)}\n  hint: {_HINT}" if doubts else None


def _questions(config: Config) -> Iterator[tuple[str, str]]:
    """The quantities that are implausible, each with a question."""
    spans, fixed = magnitudes(config), config.fixed()
    of_ratios = sum(fixed.get(name) == 1.0 for name in _DIMENSIONLESS) >= 2
    for name, row in QUANTITIES.items():
        if row.plausible is None or name not in spans or name in config.written_in or (of_ratios and row.units == "1"):
            continue
        if spans[name][1] > row.plausible:
            likely = LIKELY.get(row.units)
            meant = f"did you mean {span_text(spans[name], likely)}?" if likely else "is that meant?"
            yield name, f"got {span_text(spans[name], units.spelled(row.units))}; {meant}"
    if of_ratios or not {"static deflection", "mass"} <= spans.keys() or spans["mass"][0] > _HEAVY:
        return
    if (deflection := spans["static deflection"])[0] > _FARTHEST:
        load, far = span_text(spans["normal_load"], "N"), span_text(deflection, "m")
        yield "stiffness", f"under {load} the belt drags the mass {far} far before it breaks away; is that meant?"


def magnitudes(config: Config) -> dict[str, NDArray[np.float64]]:
    """By name, the smallest and the largest magnitude of quantities, fixed or along axes, and of what follows from
    them. Words and uncertain quantities have none."""
    points = {name: np.array([value]) for name, value in config.fixed().items()}
    points |= {member.name: member.points() for axis in config.axes for member in axis.members}
    numbers = {name: np.abs(values[~np.isnan(values)]) for name, values in points.items()}
    spans = {name: np.array([sizes.min(), sizes.max()]) for name, sizes in numbers.items() if sizes.size}
    levels = model_of(config.friction.law).levels
    if BREAKAWAY not in spans and all(name in spans for name in levels):
        spans[BREAKAWAY] = np.sum([spans[name] for name in levels], axis=0)
    if {"stiffness", "mass"} <= spans.keys():
        spans["natural frequency"] = np.sqrt(spans["stiffness"] / spans["mass"][::-1]) / (2.0 * math.pi)
    if {BREAKAWAY, "normal_load", "stiffness"} <= spans.keys():
        spans["static deflection"] = spans[BREAKAWAY] * spans["normal_load"] / spans["stiffness"][::-1]
    return spans


def span_text(span: NDArray[np.float64], unit: str = "") -> str:
    """`1 to 500 m/s`."""
    return f"{' to '.join(dict.fromkeys(f'{end:.3g}' for end in span))} {unit}".rstrip()
