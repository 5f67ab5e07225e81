"""Values that are legal and implausible in SI: a unit was probably forgotten, or another one was meant.

A friction curve in mm/s read as one in m/s is no error: the map is computed, and shows no stick-slip anywhere. So what
is beyond all contacts is asked about (`Parameter.plausible`), numbers without a unit more readily, and springs that
stretch by metres. Dimensionless studies, in which mass, stiffness and load are of order one, are not questioned.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Collection, Iterator, Mapping
from functools import reduce
from itertools import product
from operator import add, getitem
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.config.checks import varied_paths
from stickslip.config.model import Config
from stickslip.config.yaml import Document
from stickslip.errors import Problem, UnitWarning
from stickslip.vocabulary import units
from stickslip.vocabulary.cell_values import scales_of
from stickslip.vocabulary.display_units import LIKELY
from stickslip.vocabulary.models import BREAKAWAY, model_of, model_with
from stickslip.vocabulary.parameter import FRICTION
from stickslip.vocabulary.quantities import OSCILLATOR, QUANTITIES

_FARTHEST = 1.0  # m, static deflection of a spring that holds a sliding contact
_FAR = 0.2  # m, the same in the middle of the grid, where the numbers had no unit ...
_NEAR = 0.01  # m, ... and in its stiffest cell
_HEAVY = 1000.0  # kg; from here on it may be a fault of the earth, whose springs are long
_IMPOSSIBLE = 5.0  # a friction coefficient from here on is a share in %, or a force; the limit in a study of ratios
_ORDER_ONE = 0.2, 5.0  # mass and load of a dimensionless study ...
DOUBTED_FRICTION_OF_RATIOS = 0.8  # ... and its friction coefficient, as in the article; few dry contacts have more
_HINT = "numbers without a unit are in SI; write the unit, as in '20 mm/s' (`stickslip help configuration`)"
_MEANT = "is that meant?"
DOUBTED_FRICTION = FRICTION[-1]

Spans = Mapping[str, NDArray[np.float64]]  # the smallest and the largest of some numbers


def warn_of_units(document: Document, config: Config, names: Collection[str] | None = None) -> None:
    """Warn of the values in a document that are implausible in SI, at the line outside of this package.

    names : of the quantities that were written; others were filled in, and are not asked about.
    """
    text = unit_question(document, config, names)
    if text is None:
        return
    frame, depth = sys._getframe(), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("stickslip."):
        frame, depth = frame.f_back, depth + 1
    warnings.warn(text, UnitWarning, stacklevel=depth)


def warn_of_cell(source: str, given: Mapping[str, Any], cell: Config) -> None:
    """Warn of the numbers without a unit that pick a cell and are implausible. source : the option that gave them."""
    sections: dict[str, Any] = {}
    for name, value in given.items():
        if name in QUANTITIES and isinstance(value, float):
            sections.setdefault(QUANTITIES[name].section, {})[name] = value
    warn_of_units(Document(source, sections), cell)


def unit_question(document: Document, config: Config, names: Collection[str] | None = None) -> str | None:
    """The question about the values of a document, `config` being what was read from it; None if all are plausible.

    names : as for `warn_of_units`.
    """
    data, bare = document.data, _bare_numbers(document.data)
    bare = {name: values for name, values in bare.items() if names is None or name in names}
    varied = {path[-1]: path for path in reversed(varied_paths(data.get("axes") or {}))}
    problems = []
    for name, question in _questions(config, bare):
        path = varied.get(name, (QUANTITIES[name].section, name))
        is_written = names is None or name in names  # a fitted curve has its own warning
        if is_written and (path[0] == "axes" or name in (data.get(path[0]) or {})):
            problems.append(Problem(path, question, document.keys.get(path) or document.values.get(path)))
    if not problems:
        return None
    lines = [problem.text(document.name) for problem in sorted(problems, key=lambda problem: problem.place or (0, 0))]
    return "\n".join([*lines, f"  hint: {_HINT}"])


def friction_question_of_cells(cells: Mapping[str, NDArray[np.float64]]) -> str | None:
    """The question about the largest friction coefficient at break-away among cells, if no contact has it.

    Cells of ratios, of which two of mass, stiffness and load are 1, are not questioned.
    """
    model = model_with(cells)
    start = model.static_of(cells)
    if not (start > DOUBTED_FRICTION).any():
        return None
    ones = sum((cells[name] == 1.0).astype(np.int8) for name in ("mass", "stiffness", "normal_load"))
    odd = start[(start > DOUBTED_FRICTION) & (ones < 2)]
    what = model.levels[0] if len(model.levels) == 1 else BREAKAWAY
    return friction_question(float(odd.max()), what) if odd.size else None


def friction_question(value: float, what: str) -> str:
    """The question about a friction coefficient above `DOUBTED_FRICTION`."""
    share = f"is that {value / 100:.3g}, which is a share in %?" if value > _IMPOSSIBLE else _MEANT
    return (
        f"{what} = {value:.3g} is more than the friction coefficient of most contacts ({DOUBTED_FRICTION:g}); {share}"
    )


# --- what a configuration comes to ------------------------------------------------------------------------------------


def magnitudes(config: Config) -> dict[str, NDArray[np.float64]]:
    """Magnitudes of the quantities, fixed or along axes, and of two that follow from them, by name.

    Words and uncertain quantities have none.
    """
    points = {member.name: member.points() for axis in config.axes for member in axis.members}
    points |= {name: np.array([value]) for name, value in config.fixed().items()}
    numbers = {name: np.abs(values[~np.isnan(values)]) for name, values in points.items()}
    spans = {name: np.array([sizes.min(), sizes.max()]) for name, sizes in numbers.items() if sizes.size}
    levels = model_of(config.friction.law).levels
    if BREAKAWAY not in spans and all(name in spans for name in levels):
        spans[BREAKAWAY] = reduce(add, (spans[name] for name in levels))
    if {"stiffness", "mass"} <= spans.keys():
        oscillator = dict.fromkeys(("mass", "stiffness", *(name for name in spans if name in OSCILLATOR)))
        corners = np.transpose([*product(*(spans[name] for name in oscillator))])
        frequency = scales_of(dict(zip(oscillator, corners, strict=True))).natural_frequency
        spans["natural frequency"] = np.array([frequency.min(), frequency.max()])
    if {BREAKAWAY, "normal_load", "stiffness"} <= spans.keys():
        spans["static deflection"] = spans[BREAKAWAY] * spans["normal_load"] / spans["stiffness"][::-1]
    return spans


def span_text(span: ArrayLike, unit: str = "", digits: int = 3) -> str:
    """`1 to 500 m/s`."""
    ends = dict.fromkeys(f"{end:.{digits}g}" for end in np.atleast_1d(span))
    return f"{' to '.join(ends)} {unit}".rstrip()


def _bare_numbers(data: Any) -> dict[str, NDArray[np.float64]]:
    """The numbers without a unit in the plain data of a configuration that is right; zero is zero in any unit."""
    sections = dict.fromkeys(row.section for row in QUANTITIES.values())
    given = {name: value for section in sections for name, value in (data.get(section) or {}).items()}
    given |= {str(path[-1]): reduce(getitem, path, data) for path in varied_paths(data.get("axes") or {})}
    bare = {}
    for name, value in given.items():
        if isinstance(value, dict):
            value = value["values"] if "values" in value else [value.get("start"), value.get("stop")]
        parts = value if isinstance(value, list) else [value]
        parts = units.each_with_unit(parts, QUANTITIES[name].units) if name in QUANTITIES else parts
        numbers = [float(part) for part in parts if isinstance(part, int | float) and part]
        if numbers and name in QUANTITIES and QUANTITIES[name].units != "1":
            bare[name] = np.array([min(numbers), max(numbers)])
    return bare


# --- doubts -----------------------------------------------------------------------------------------------------------


def _questions(config: Config, bare: Spans) -> Iterator[tuple[str, str]]:
    """The quantities that are implausible, each with a question. bare : the numbers written without a unit."""
    spans, fixed = magnitudes(config), config.fixed()
    low, high = _ORDER_ONE
    of_ratios = sum(fixed.get(name) == 1.0 for name in ("mass", "stiffness", "normal_load")) >= 2 or (
        BREAKAWAY in spans and spans[BREAKAWAY][1] >= DOUBTED_FRICTION_OF_RATIOS
        and all(name in spans and low <= spans[name][0] <= high for name in ("mass", "normal_load"))
    )  # fmt: skip
    for name, row in QUANTITIES.items():
        if row.plausible is None or name not in spans:
            continue
        largest, (most_bare, most) = float(spans[name][1]), row.plausible
        if row.units == "1":
            if largest > (_IMPOSSIBLE if of_ratios else DOUBTED_FRICTION):
                share = f"did you mean {largest / 100:.3g}, which is a share in %?"
                yield name, f"got {largest:.3g}, a friction coefficient; {share if largest > _IMPOSSIBLE else _MEANT}"
        elif (name in bare and np.abs(bare[name]).max() > most_bare) or largest > most:
            yield name, _question(name, spans, bare)
    if of_ratios or "static deflection" not in spans or "mass" not in spans or spans["mass"][0] > _HEAVY:
        return
    deflection, may_lack = spans["static deflection"], "stiffness" in bare or "normal_load" in bare
    middle = math.sqrt(math.prod(deflection))  # geometric, for grids over decades
    if deflection[0] > _FARTHEST or (may_lack and middle > _FAR and deflection[0] > _NEAR):
        load, far = span_text(spans["normal_load"], "N"), span_text(deflection, "m")
        yield "stiffness", _question("stiffness", spans, bare, f": under {load} the belt drags the mass {far} far "
                                     "before it breaks away")  # fmt: skip


def _question(name: str, spans: Spans, bare: Spans, reason: str = "") -> str:
    """The question about a quantity, with the unit that was likely meant."""
    declared, digits = QUANTITIES[name].units, 6 if name in bare else 3
    numbers, unit, likely = bare.get(name, spans[name]), units.spelled(declared), LIKELY.get(declared)
    value = f"{span_text(numbers, digits=digits)} understood as " if name in bare else "got "
    meant = f"did you mean {span_text(numbers, likely, digits)}?" if likely else _MEANT
    return f"{value}{span_text(numbers, unit, digits)}{reason}; {meant}"
