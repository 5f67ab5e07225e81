"""A configuration as it was understood: every quantity with its SI value and unit, every axis with its points."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from stickslip.config.model import Config, Range, Values
from stickslip.config.plausible import natural_frequency, static_deflection
from stickslip.config.refined import refined_axes
from stickslip.config.rules import members
from stickslip.config.scatter import Uncertain
from stickslip.config.sections import Sensor
from stickslip.config.studies import Attractors, Border, Contours
from stickslip.vocabulary import units
from stickslip.vocabulary.customary import customary
from stickslip.vocabulary.laws import LAW_MESSAGES
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.settings import SENSOR

_MOST_VALUES = 6  # of a list that are shown; of longer ones the ends


class Row(NamedTuple):
    """One thing that was understood: its name, its value, and what it is."""

    name: str
    value: str
    meaning: str


def understood(config: Config) -> Iterator[Row]:
    """What is the same in all cells, then what varies, then how it is computed and where it goes."""
    yield Row("law", config.friction.law, LAW_MESSAGES[config.friction.law])
    fixed = config.fixed()
    for name, declared in QUANTITIES.items():
        if name in fixed and (name != "delta" or config.friction.law == "stribeck_delta"):
            yield Row(name, _value(fixed[name], declared), _meaning(declared, fixed[name]))
    yield from _drive(config)
    yield from _amounts(config)
    for axis in config.axes:
        if not isinstance(axis, Range | Values):
            yield Row(f"axis {axis.name}", f"{axis.size} points", ", ".join(axis.labels or ()))
        for member in members(axis):
            yield _along(member, "axis " if member is axis else "  with ")
    if config.border is not None:
        yield _border(config.border)
    if config.attractors is not None:
        yield from _box(config.attractors)
    if config.refine is not None:
        yield _refine(config)
    if config.uncertain is not None:
        yield from _uncertain(config.uncertain)
    if config.contours is not None:
        yield _contours(config.contours)
    if config.margins is not None:
        names = ", ".join(config.margins.parameters or ("what a designer chooses",))
        yield Row("margins along", names, "with the cheapest joint change" if config.margins.joint else "one by one")
    solver = config.solver
    horizon = "none" if solver.horizon is None else f"{solver.horizon:g} s"
    yield Row("solver", f"rtol {solver.rtol:g}, max_steps {solver.max_steps:,}, horizon {horizon}", _end(config))
    if config.output.variables is not None:
        yield Row("variables", ", ".join(config.output.variables), "all that is stored and written of a cell")
    files = [name for name in (config.output.file, config.output.plot) if name is not None]
    yield Row("output", ", ".join(files) or "none", "" if config.output.file else "the result is not kept without -o")


def _amounts(config: Config) -> Iterator[Row]:
    """What the quantities come to, in terms that can be held against the machine at hand."""
    for name, units_, found, meaning in (
        ("natural frequency", "s-1", natural_frequency(config), "sqrt(stiffness/mass)/(2 pi), without friction"),
        (
            "static deflection",
            "m",
            static_deflection(config),
            "mu_start times load over stiffness, where it breaks away",
        ),
    ):
        if found is not None:
            unit = "Hz" if units_ == "s-1" else units.spelled(units_)
            other = customary(units_, *found)
            yield Row(name, found.text(unit) + (f"  ({other})" if other else ""), meaning)


def _border(asked: Border) -> Row:
    """What is searched for instead of a map."""
    unit = units.spelled(QUANTITIES[asked.along].units)
    between = "the range of its axis"
    if asked.between is not None:
        between = f"{asked.between[0]:.6g} to {asked.between[1]:.6g} {unit}".rstrip()
    meaning = f"between {between}, {asked.scan} places first, tolerance {asked.tolerance:g}"
    return Row("border along", asked.along, meaning)


def _box(asked: Attractors) -> Iterator[Row]:
    """The starting states whose attractors are asked for, instead of a map."""
    for name, (low, high) in (("displacement", asked.displacement), ("velocity", asked.velocity)):
        unit = units.spelled(QUANTITIES[name].units)
        yield Row(f"attractors from {name}", f"{low:.6g} to {high:.6g} {unit}", f"starting states: {name}")
    yield Row("samples", f"{asked.samples:,}", "starting states per cell where the share is not exact")


def _refine(config: Config) -> Row:
    """How few cells of a map are computed."""
    assert config.refine is not None
    names = [config.axes[i].name for i in refined_axes(config.axes, config.refine.depth)]
    meaning = f"audit {config.refine.audit:g}; other metrics " + (
        "interpolated" if config.refine.interpolate else "only where they were computed"
    )
    return Row("refine", f"boxes of 2^{config.refine.depth} + 1 cells along {', '.join(names)}", meaning)


def _uncertain(asked: Uncertain) -> Iterator[Row]:
    """What scatters, and how it is sampled."""
    for one in asked.quantities:
        yield Row(one.name, "uncertain", one.in_words)
    if asked.correlation is not None:
        yield Row("correlation", "of uncertain quantities", asked.correlation_in_words)
    yield Row("sampling", "subset simulation" if asked.subset else "Sobol points", asked.method_in_words)


def _contours(asked: Contours) -> Row:
    """What is followed instead of computing a map."""
    over = "the last two axes" if asked.axes is None else " and ".join(asked.axes)
    meaning = f"a grid of {asked.points} points a side, {asked.scan} looked at first, tolerance {asked.tolerance:g}"
    return Row("contours over", over, meaning)


def _drive(config: Config) -> Iterator[Row]:
    """What only a rig has, besides quantities."""
    if config.drive is None:
        return
    yield Row("drive", f"{config.drive.strokes} strokes, {config.drive.profile}", "strokes, and speed over time")
    sensor = config.sensor or Sensor()
    for name, declared in SENSOR.items():
        value = getattr(sensor, name)
        yield Row(name, "none" if value is None else _value(value, declared), declared.long_name)


def _value(value: float, declared: Parameter) -> str:
    written = declared.written(value)
    if isinstance(written, str):
        return written
    other = customary(declared.units, written)
    return f"{written:.6g} {units.spelled(declared.units)}".rstrip() + (f"  ({other})" if other else "")


def _meaning(declared: Parameter, value: float) -> str:
    """The long name; where a word is given, what it means."""
    return f"{declared.long_name}: {declared.absent}" if math.isnan(value) else declared.long_name


def _along(axis: Range | Values, before: str) -> Row:
    """A quantity along an axis: its ends or its values, how many there are, and how they are spaced."""
    declared = QUANTITIES[axis.name]
    unit = units.spelled(declared.units)
    if isinstance(axis, Range):
        span, spacing = f"{axis.start:.6g} to {axis.stop:.6g} {unit}".rstrip(), f"{axis.spacing} spacing"
        ends = [axis.start, axis.stop]
    else:
        span, spacing = _listed(axis, unit), "as listed"
        ends = [value for value in axis.values if not math.isnan(value)]
        ends = [min(ends), max(ends)] if ends else []
    if ends and (other := customary(declared.units, *ends)):
        span += f"  ({other})"
    return Row(f"{before}{axis.name}", span, f"{axis.size:,} values, {spacing}: {declared.long_name}")


def _listed(axis: Values, unit: str) -> str:
    written = map(QUANTITIES[axis.name].written, axis.values)
    values = [value if isinstance(value, str) else f"{value:.6g}" for value in written]
    shown = values if len(values) <= _MOST_VALUES else [*values[: _MOST_VALUES - 2], "...", values[-1]]
    return f"{', '.join(shown)} {unit}".rstrip()


def _end(config: Config) -> str:
    return "until the regime is decided" if config.solver.early_stop else "to the horizon"
