"""A configuration for people and for editors: how it was understood, and the JSON Schema.

`describe` has every quantity with its SI value and unit, every axis with its points. The schema is generated from the
tables and models that the reader uses. It cannot say everything: that each quantity is given exactly once, and what
must hold between quantities, is checked by `load_config` alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from stickslip import extensions
from stickslip.config.model import DEFAULT_TITLE, SECTIONS, Config, Group, Range, Values
from stickslip.config.problems import model_at
from stickslip.config.rules import magnitudes, span_text
from stickslip.config.sections import VALUE, Read, Schema, Section, StudySection, number_schema
from stickslip.config.studies import section_class, study_class
from stickslip.config.uncertain import DRAWN, FORMS, SamplingSection, Uncertain
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import customary
from stickslip.vocabulary.models import BREAKAWAY, CURVE, LAW_MESSAGES, laws_with, model_of
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import QUANTITIES, SEARCHABLE, STUDIES

_MOST_VALUES = 6  # of a list that are shown; of longer ones the ends


Row = tuple[str, str, str]  # one thing that was understood: name, value, what it is


def describe(config: Config) -> Iterator[Row]:
    """The rows of a configuration: what is the same in all cells, what varies, how it is computed, where it goes."""
    yield ("law", config.friction.law, LAW_MESSAGES[config.friction.law])
    fixed, model = config.fixed(), model_of(config.friction.law)
    for name, row in QUANTITIES.items():
        if name in model.absent and name in fixed and (math.isnan(fixed[name]) or fixed[name] == row.default):
            yield (name, "none", f"{row.long_name}: {model.absent[name]}")
        elif name in fixed and config.friction.law in laws_with(name):
            meaning = f"{row.long_name}: {row.absent}" if math.isnan(fixed[name]) else row.long_name
            yield (name, value_text(fixed[name], row), meaning)
    yield from _amounts(config)
    for axis in config.axes:
        if isinstance(axis, Group):
            yield (f"axis {axis.name}", f"{axis.size} points", ", ".join(axis.labels or ()))
        for member in axis.members:
            yield _along(member, "  with " if isinstance(axis, Group) else "axis ")
    studies: tuple[StudySection | None, ...] = (config.study, config.uncertain)
    for section in filter(None, studies):
        yield from study_class(section.key).explain(section, config)
    solver = config.solver
    horizon = "none" if solver.horizon is None else f"{solver.horizon:g} s"
    end = "until the regime is decided" if solver.early_stop else "to the horizon"
    yield ("solver", f"rtol {solver.rtol:g}, max_steps {solver.max_steps:,}, horizon {horizon}", end)
    if config.output.variables is not None:
        yield ("variables", ", ".join(config.output.variables), "all that is stored and written of a cell")
    files = [name for name in (config.output.file, config.output.plot, config.output.report) if name is not None]
    yield ("output", ", ".join(files) or "none", "" if config.output.file else "the result is not kept without -o")


def _amounts(config: Config) -> Iterator[Row]:
    """Closed forms of the quantities, in terms that can be held against the machine at hand."""
    spans, model = magnitudes(config), model_of(config.friction.law)
    load = f"{BREAKAWAY if model.curve else model.levels[0]} times load over stiffness"
    load += ", where it breaks away" if model.curve else ""
    frequency = ("natural frequency", "s-1", "Hz", "sqrt(stiffness/mass)/(2 pi), without friction")
    for name, si, unit, meaning in (frequency, ("static deflection", "m", "m", load)):
        if name in spans:
            yield (name, span_text(spans[name], unit) + _in_customary(si, *spans[name].tolist()), meaning)


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
    text += _in_customary(row.units, *ends)
    return (f"{before}{axis.name}", text, f"{axis.size:,} values, {spacing}: {row.long_name}")


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
    forms = {"type": ["array", "object"]}  # values, or keys of a range
    fit = f"measured points: {CURVE.level} to {CURVE.decay} of each file or column of friction"
    zipped = {name: {"type": "array", "minItems": 1} for name in QUANTITIES} | {"fit": {"description": fit}}
    group = strict({"zip": strict(zipped) | {"minProperties": 1}, "labels": {"description": "names of the points"}})
    return {
        "type": ["object", "null"],
        "description": "What varies, the outermost dimension first: quantities, or groups that vary together (zip).",
        "properties": {name: {"description": _description(row), **forms} for name, row in QUANTITIES.items()},
        "additionalProperties": group | {
            "description": "Quantities that vary together, point by point.", "required": ["zip"],
        },
    }  # fmt: skip


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
