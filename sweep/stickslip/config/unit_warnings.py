"""Values that are legal and implausible in SI: a unit was probably forgotten, or another one was meant.

A friction curve in mm/s read as one in m/s is no error: the map is computed, and shows no stick-slip anywhere. So what
is beyond all contacts (`Parameter.plausible`) is asked about, numbers without a unit more readily, and springs that
stretch by metres. In dimensionless studies, in which two of mass, stiffness and load are 1, friction and springs are
not questioned.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator, Mapping
from functools import reduce
from itertools import product
from operator import add

import numpy as np
from numpy.typing import NDArray

from stickslip.config.model import Config
from stickslip.config.yaml import Document
from stickslip.errors import Path, Problem, UnitWarning
from stickslip.vocabulary import units
from stickslip.vocabulary.cell_values import scales_of
from stickslip.vocabulary.display_units import LIKELY
from stickslip.vocabulary.models import BREAKAWAY, model_of, model_with
from stickslip.vocabulary.parameter import FRICTION
from stickslip.vocabulary.quantities import OSCILLATOR, QUANTITIES

DOUBTED_FRICTION = FRICTION[-1]
_FARTHEST = 1.0  # m, static deflection of a spring that holds a sliding contact
_HEAVY = 1000.0  # kg; from here on it may be a fault of the earth, whose springs are long
_DIMENSIONLESS = ("mass", "stiffness", "normal_load")
_HINT = "numbers without a unit are in SI; write the unit, as in '20 mm/s' (`stickslip help configuration`)"


def warn_of_units(document: Document, config: Config) -> None:
    """Warn of the values in a document that are implausible in SI, at the line outside of this package."""
    if (text := unit_question(document, config)) is None:
        return
    frame, depth = sys._getframe(), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("stickslip."):
        frame, depth = frame.f_back, depth + 1
    warnings.warn(text, UnitWarning, stacklevel=depth)


def unit_question(document: Document, config: Config) -> str | None:
    """The question about the values of a document, `config` being what it comes to; None if all are plausible.

    What is not written there but stands behind its words, a fitted curve say, is not asked about.
    """
    written = dict(_written(document.data))
    problems = [
        Problem(written[name], question, document.keys.get(written[name]) or document.values.get(written[name]))
        for name, question in _questions(config)
        if name in written
    ]
    if not problems:
        return None
    problems.sort(key=lambda problem: problem.place or (0, 0))
    return "\n".join([*(problem.text(document.name) for problem in problems), f"  hint: {_HINT}"])


def friction_question_of_cells(cells: Mapping[str, NDArray[np.float64]]) -> str | None:
    """The question about the largest friction coefficient at break-away among cells, if no contact has it."""
    model = model_with(cells)
    start = model.static_of(cells)
    if not (start > DOUBTED_FRICTION).any():
        return None
    ones = sum((cells[name] == 1.0).astype(np.int8) for name in _DIMENSIONLESS)
    odd = start[(start > DOUBTED_FRICTION) & (ones < 2)]
    what = model.levels[0] if len(model.levels) == 1 else BREAKAWAY
    return friction_question(float(odd.max()), what) if odd.size else None


def friction_question(value: float, what: str) -> str:
    """The question about a friction coefficient above `DOUBTED_FRICTION`."""
    return f"{what} = {value:.3g} is more than the friction coefficient of most contacts ({DOUBTED_FRICTION:g})"


def magnitudes(config: Config) -> dict[str, NDArray[np.float64]]:
    """By name, the smallest and the largest magnitude of quantities, fixed or along axes, and of what follows from
    them. Words and uncertain quantities have none."""
    points = {name: np.array([value]) for name, value in config.fixed().items()}
    points |= {member.name: member.points() for axis in config.axes for member in axis.members}
    numbers = {name: np.abs(values[~np.isnan(values)]) for name, values in points.items()}
    spans = {name: np.array([sizes.min(), sizes.max()]) for name, sizes in numbers.items() if sizes.size}
    levels = model_of(config.friction.law).levels
    if BREAKAWAY not in spans and all(name in spans for name in levels):
        spans[BREAKAWAY] = reduce(add, (spans[name] for name in levels))
    if {"stiffness", "mass"} <= spans.keys():
        names = [name for name in OSCILLATOR if name in spans]
        corners = np.transpose([*product(*(spans[name] for name in names))])
        frequency = scales_of(dict(zip(names, corners, strict=True))).natural_frequency
        spans["natural frequency"] = np.array([frequency.min(), frequency.max()])
    if {BREAKAWAY, "normal_load", "stiffness"} <= spans.keys():
        spans["static deflection"] = spans[BREAKAWAY] * spans["normal_load"] / spans["stiffness"][::-1]
    return spans


def span_text(span: NDArray[np.float64], unit: str = "") -> str:
    """`1 to 500 m/s`."""
    return f"{' to '.join(dict.fromkeys(f'{end:.3g}' for end in span))} {unit}".rstrip()


def _written(data: Mapping[str, object]) -> Iterator[tuple[str, Path]]:
    """The places of quantities in the plain data of a configuration that is right."""
    for section, inside in data.items():
        for name, value in inside.items() if isinstance(inside, dict) else ():
            zipped = value.get("zip") if section == "axes" and isinstance(value, dict) else None
            yield from ((member, (section, name, "zip", member)) for member in zipped or ())
            yield name, (section, name)


def _questions(config: Config) -> Iterator[tuple[str, str]]:
    """The quantities that are implausible, each with a question."""
    spans, fixed = magnitudes(config), config.fixed()
    of_ratios = sum(fixed.get(name) == 1.0 for name in _DIMENSIONLESS) >= 2
    for name, row in QUANTITIES.items():
        if row.plausible is None or name not in spans or (of_ratios and row.units == "1"):
            continue
        if spans[name][1] > row.plausible[name in config.written_in]:
            likely = LIKELY.get(row.units)
            meant = f"did you mean {span_text(spans[name], likely)}?" if likely else "is that meant?"
            yield name, f"got {span_text(spans[name], units.spelled(row.units))}; {meant}"
    if of_ratios or not {"static deflection", "mass"} <= spans.keys() or spans["mass"][0] > _HEAVY:
        return
    if (deflection := spans["static deflection"])[0] > _FARTHEST:
        load, far = span_text(spans["normal_load"], "N"), span_text(deflection, "m")
        yield "stiffness", f"under {load} the belt drags the mass {far} far before it breaks away; is that meant?"
