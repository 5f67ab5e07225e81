"""A configuration for people and for editors: how it was understood, numbers without a unit that are implausible in SI,
and the JSON Schema.

`describe` has every quantity with its SI value and unit, every axis with its points. A friction curve in mm/s read as
one in m/s is no error: the map is computed, and shows no stick-slip anywhere. So numbers beyond all contacts
(`Parameter.plausible`) are asked about, and springs that stretch by metres. In dimensionless studies, in which two of
mass, stiffness and load are 1, friction and springs are not questioned. The schema is generated from the tables and
models that the reader uses. It cannot say everything: that each quantity is given exactly once, and what must hold
between quantities, is checked by `load_config` alone.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip import extensions
from stickslip.config.model import DEFAULT_TITLE, SECTIONS, Config, Group, Range, Values
from stickslip.config.problems import model_at
from stickslip.config.resolve import varied_paths
from stickslip.config.sections import VALUE, Friction, Read, Schema, Section, StudySection, number_schema
from stickslip.config.studies import section_class, study_class
from stickslip.config.uncertain import DRAWN, FORMS, SamplingSection, Uncertain
from stickslip.config.yaml import Document
from stickslip.errors import ConfigError, Problem, UnitWarning
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import LIKELY, customary
from stickslip.vocabulary.models import BREAKAWAY, CURVE, LAW_MESSAGES, laws_with, model_of
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import AXIS, QUANTITIES, SEARCHABLE
from stickslip.vocabulary.results import STUDIES

_MOST_VALUES = 6  # of a list that are shown; of longer ones the ends


class Row(NamedTuple):
    """One thing that was understood, and what it is."""

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
    frequency = ("natural frequency", "s-1", "Hz", "sqrt(stiffness/mass)/(2 pi), without friction")
    for name, si, unit, meaning in (frequency, ("static deflection", "m", "m", load)):
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


# --- the JSON Schema --------------------------------------------------------------------------------------------------


def json_schema() -> Schema:
    """The schema, draft 2020-12, as plain data."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "stickslip configuration",
        "description": "A friction oscillator, or with a drive a rig. Quantities: numbers in SI, texts with units.",
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "title": {
                "type": "string",
                "pattern": r"\S",
                "default": DEFAULT_TITLE,
                "description": "what the map shows",
            },
            "axes": axes_schema(),
            **{key: section_schema(model) for key, model in SECTIONS.items()},
            **{key: section_schema(section_class(key)) for key in STUDIES},
            **{
                key: section_schema(extensions.imported(place))
                for entry in STUDIES.values()
                for key, place in entry.beside.items()
            },
            "uncertain": uncertain_schema(),
        },
    }


def uncertain_schema() -> Schema:
    """The section `uncertain`."""
    scatter: Schema = {"type": "object", "minProperties": 1}
    own: Schema = {
        "quantities": {
            "description": f"by quantity, its distribution: {FORMS}, {DRAWN}: [...], or one of scipy.stats",
            **strict({name: {**scatter, "description": _description(row)} for name, row in SEARCHABLE.items()}),
        },
        "correlation": {"type": "object", "required": ["between", "matrix"], "properties": {
            "between": {"type": "array", "items": {"enum": list(SEARCHABLE)}, "minItems": 2},
            "matrix": {"type": "array", "items": {"type": "array", "items": {"type": "number"}}},
        }, "description": "of normal deviates of quantities (a Gaussian copula)"},
    }  # fmt: skip
    whole = _object({**section_schema(SamplingSection)["properties"], **own}, str(Uncertain.__doc__).splitlines()[0])
    return whole | {"anyOf": [{"required": ["quantities"]}, {"required": ["fit"]}]}


def strict(properties: Schema) -> Schema:
    """A mapping with no other keys."""
    return {"type": "object", "additionalProperties": False, "properties": properties}


def _object(properties: Schema, description: str) -> Schema:
    """A section; without content it is one, too."""
    return strict(properties) | {"type": ["object", "null"], "description": description}


def _description(row: Parameter) -> str:
    unit = units.spelled(row.units)
    return f"{row.long_name} ({unit})" if unit else row.long_name


def _described(row: Parameter) -> Schema:
    """A number with what it is, its unit, and its default."""
    schema: Schema = {"description": _description(row), **number_schema(row)}
    if row.default is not None and (row.word or not row.may_be_absent):
        schema["default"] = row.written(row.default)
    return schema


# --- its axes ---------------------------------------------------------------------------------------------------------


def axes_schema() -> Schema:
    """Quantities that vary, and groups of them."""
    values: Schema = {name: {"type": "array", "minItems": 1, "items": number_schema(QUANTITIES[name])}
                      for name in QUANTITIES}  # fmt: skip
    values["fit"] = field_schema(Friction, "fit") | {
        "description": f"measured points: {CURVE.level} to {CURVE.decay} of each file or column of friction"
    }
    names = {"type": "array", "uniqueItems": True, "items": {"type": "string", "pattern": r"\S"}}
    group = strict({
        "zip": strict(values) | {"minProperties": 1}, "labels": names | {"description": "names of the points"},
    })  # fmt: skip
    return {
        "type": ["object", "null"],
        "description": "What varies, the outermost dimension first: quantities, or groups that vary together (zip).",
        "properties": {
            name: {"description": _description(row), "anyOf": _axis_forms(row)} for name, row in QUANTITIES.items()
        },
        "additionalProperties": group | {
            "description": "Quantities that vary together, point by point.", "required": ["zip"],
        },
    }  # fmt: skip


def _axis_forms(row: Parameter) -> list[Schema]:
    """A list of values, the same in a mapping, or a range."""
    values = {"type": "array", "minItems": 1, "uniqueItems": True, "items": number_schema(row)}
    end, spacing = number_schema(row, words=False), field_schema(Range, "spacing") | {"default": "linear"}
    return [
        values,
        strict({"values": values}) | {"required": ["values"]},
        strict({"start": end, "stop": end, "num": _described(AXIS["num"]), "spacing": spacing})
        | {"required": ["start", "stop", "num"]},
    ]


# --- its sections -----------------------------------------------------------------------------------------------------


def section_schema(model: type[Section]) -> Schema:
    """A section: its numbers as the vocabulary has them, the rest with descriptions and defaults from the model."""
    properties: Schema = {}
    for name, field in model.model_fields.items():
        if name in model.rows:
            properties[name] = _described(model.rows[name])
            continue
        properties[name] = {"description": field.description} if field.description else {}
        properties[name] |= field_schema(model, name)
        if field.default is not None and not field.is_required():
            properties[name]["default"] = list(field.default) if isinstance(field.default, tuple) else field.default
    required = [name for name, field in model.model_fields.items() if field.is_required()]
    return _object(properties, str(model.__doc__).splitlines()[0]) | ({"required": required} if required else {})


def field_schema(model: type[Section], name: str) -> Schema:
    """The schema of a field: what its annotation or the field itself says, or that of the section it holds."""
    field, inner = model.model_fields[name], model_at(model, (name,))
    for schema in (*(note.schema for note in field.metadata if isinstance(note, Read)), field.json_schema_extra):
        if isinstance(schema, dict):
            return dict(schema)
    return VALUE if inner is model else section_schema(inner)
