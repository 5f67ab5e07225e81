"""A configuration as it was understood: every quantity with its SI value and unit, every axis with its points."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from stickslip.config.model import Config, Group, Range, Values
from stickslip.config.sections import StudySection
from stickslip.config.studies import study_class
from stickslip.config.unit_warnings import magnitudes, span_text
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import customary
from stickslip.vocabulary.models import BREAKAWAY, LAW_MESSAGES, laws_with, model_of
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import QUANTITIES

_MOST_VALUES = 6  # of a list that are shown; of longer ones the ends


class Row(NamedTuple):
    """One thing that was understood: its name, its value, and what it is."""

    name: str
    value: str
    meaning: str


def describe(config: Config) -> Iterator[Row]:
    """The rows of a configuration: what is the same in all cells, what varies, how it is computed, where it goes."""
    yield Row("law", config.friction.law, LAW_MESSAGES[config.friction.law])
    fixed, model = config.fixed(), model_of(config.friction.law)
    for name, row in QUANTITIES.items():
        if name in model.absent and name in fixed and (math.isnan(fixed[name]) or fixed[name] == row.default):
            yield Row(name, "none", f"{row.long_name}: {model.absent[name]}")
        elif name in fixed and config.friction.law in laws_with(name):
            meaning = f"{row.long_name}: {row.absent}" if math.isnan(fixed[name]) else row.long_name
            yield Row(name, value_text(fixed[name], row), meaning)
    yield from _amounts(config)
    for axis in config.axes:
        if isinstance(axis, Group):
            yield Row(f"axis {axis.name}", f"{axis.size} points", ", ".join(axis.labels or ()))
        for member in axis.members:
            yield _along(member, "  with " if isinstance(axis, Group) else "axis ")
    studies: tuple[StudySection | None, ...] = (config.study, config.uncertain)
    for section in filter(None, studies):
        yield from map(Row._make, study_class(section.key).explain(section, config))
    solver = config.solver
    horizon = "none" if solver.horizon is None else f"{solver.horizon:g} s"
    end = "until the regime is decided" if solver.early_stop else "to the horizon"
    yield Row("solver", f"rtol {solver.rtol:g}, max_steps {solver.max_steps:,}, horizon {horizon}", end)
    if config.output.variables is not None:
        yield Row("variables", ", ".join(config.output.variables), "all that is stored and written of a cell")
    files = [name for name in (config.output.file, config.output.plot, config.output.report) if name is not None]
    yield Row("output", ", ".join(files) or "none", "" if config.output.file else "the result is not kept without -o")


def _amounts(config: Config) -> Iterator[Row]:
    """Closed forms of the quantities, in terms that can be held against the machine at hand."""
    spans, model = magnitudes(config), model_of(config.friction.law)
    load = f"{BREAKAWAY if model.curve else model.levels[0]} times load over stiffness"
    load += ", where it breaks away" if model.curve else ""
    for name, si, unit, meaning in (
        ("natural frequency", "s-1", "Hz", "sqrt(stiffness/mass)/(2 pi), without friction"),
        ("static deflection", "m", "m", load),
    ):
        if name in spans:
            yield Row(name, span_text(spans[name], unit) + _in_customary(si, *spans[name].tolist()), meaning)


def value_text(value: float, row: Parameter) -> str:
    """A value in SI with its unit, and in the unit people use."""
    written = row.written(value)
    if isinstance(written, str):
        return written
    return f"{written:.6g} {units.spelled(row.units)}".rstrip() + _in_customary(row.units, written)


def _in_customary(si: str, *values: float) -> str:
    """The values in the unit people use, behind those in SI; nothing where that is the same."""
    text = customary(si, *values) if values else None
    return f"  ({text})" if text else ""


def _along(axis: Range | Values, before: str) -> Row:
    """A quantity along an axis: its ends or its values, how many there are, and how they are spaced."""
    row = QUANTITIES[axis.name]
    if isinstance(axis, Range):
        text, spacing, numbers = row.range_text((axis.start, axis.stop)), f"{axis.spacing} spacing", axis.points()
    else:
        written = [value if isinstance(value, str) else f"{value:.6g}" for value in map(row.written, axis.values)]
        if len(written) > _MOST_VALUES:
            written = [*written[: _MOST_VALUES - 2], "...", written[-1]]
        text, spacing = f"{', '.join(written)} {units.spelled(row.units)}".rstrip(), "as listed"
        numbers = axis.points()[[not math.isnan(value) for value in axis.values]]
    ends = (float(numbers.min()), float(numbers.max())) if numbers.size else ()
    meaning = f"{axis.size:,} values, {spacing}: {row.long_name}"
    return Row(f"{before}{axis.name}", text + _in_customary(row.units, *ends), meaning)
