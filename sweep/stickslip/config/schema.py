"""The JSON Schema of configurations, for editors that check and complete YAML while one types.

It is generated from the tables and models that the reader uses. It cannot say everything: that each quantity is given
exactly once, and what must hold between quantities, is checked by `load_config` alone.
"""

from __future__ import annotations

import re
from typing import Any

from stickslip.config.addresses import LOCAL, PATTERN
from stickslip.config.model import LONGEST_AXIS
from stickslip.config.reader import DEFAULT_TITLE, QUANTITY_SECTIONS
from stickslip.config.sections import OUTPUT_SUFFIXES, PLOT_SUFFIXES, RTOL, Execution, Output, Section, Sensor, Solver
from stickslip.vocabulary import units
from stickslip.vocabulary.laws import LAWS
from stickslip.vocabulary.quantities import HORIZON_UNITS, PROFILES, QUANTITIES, SENSOR, WORDS, default

Schema = dict[str, Any]

_WITH_UNIT = r"^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d{1,3})?\s*[A-Za-zµμ/].*$"


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
            **{key: _quantity_section(model) for key, model in QUANTITY_SECTIONS.items()},
            "axes": _axes(),
            "solver": _section(Solver, _SOLVER),
            "execution": _section(Execution, _EXECUTION),
            "output": _section(Output, _OUTPUT),
            "sensor": _section(Sensor, _SENSOR),
            **{key: {"type": ["object", "null"], "description": what} for key, what in _JUDGED.items()},
        },
    }


def _object(properties: Schema, description: str) -> Schema:
    return {
        "type": ["object", "null"],  # a section without content is one
        "additionalProperties": False,
        "description": description,
        "properties": properties,
    }


# --- quantities -------------------------------------------------------------------------------------------------------


def _quantity(name: str, words: bool = True) -> Schema:
    """A number within the bounds of the quantity, a text with a unit, or the word that stands for its absence."""
    declared = QUANTITIES[name]
    forms = [_number(declared.units, declared.minimum, declared.exclusive)]
    if declared.units != "1":
        forms.append({"type": "string", "pattern": _WITH_UNIT, "examples": [units.example(declared.units)]})
    if words and name in WORDS:
        forms.append({"const": WORDS[name]})
    return forms[0] if len(forms) == 1 else {"anyOf": forms}


def _number(unit: str, minimum: float, exclusive: bool) -> Schema:
    found: Schema = {"type": "number"}
    if unit != "1":
        found["description"] = f"in {units.spelled(unit)}"
    if minimum != float("-inf"):
        found["exclusiveMinimum" if exclusive else "minimum"] = minimum
    return found


def _described(name: str) -> str:
    """The long name of a quantity with its unit."""
    declared = QUANTITIES[name]
    unit = units.spelled(declared.units)
    return f"{declared.long_name} ({unit})" if unit else declared.long_name


def _quantity_section(model: type[Section]) -> Schema:
    """A section that fixes quantities; friction also names its law, or the points it is fitted to, a drive its
    profile."""
    properties: dict[str, Schema] = {}
    for name, field in model.model_fields.items():
        if name == "law":
            properties[name] = {"description": field.description, "enum": list(LAWS), "default": field.default}
            continue
        if name in _OTHERS:
            properties[name] = {"description": field.description, **_OTHERS[name]}
            continue
        properties[name] = {"description": _described(name), **_quantity(name)}
        if default(name) is not None:
            properties[name]["default"] = default(name)
    return _object(properties, str(model.__doc__))


# --- axes -------------------------------------------------------------------------------------------------------------


def _axes() -> Schema:
    """Quantities that vary, and groups of them."""
    values = {name: {"type": "array", "minItems": 1, "items": _quantity(name)} for name in QUANTITIES}
    return {
        "type": ["object", "null"],
        "description": "What varies, the outermost dimension first: quantities, or groups that vary together (zip).",
        "properties": {name: {"description": _described(name), "anyOf": _axis_forms(name)} for name in QUANTITIES},
        "additionalProperties": {
            "type": "object",
            "description": "Quantities that vary together, point by point.",
            "required": ["zip"],
            "additionalProperties": False,
            "properties": {
                "zip": {"type": "object", "minProperties": 1, "additionalProperties": False, "properties": values},
                "labels": {
                    "type": "array",
                    "uniqueItems": True,
                    "items": {"type": "string", "pattern": r"\S"},
                    "description": "names of the points",
                },
            },
        },
    }


def _axis_forms(name: str) -> list[Schema]:
    """A list of values, the same in a mapping, or a range."""
    values = {"type": "array", "minItems": 1, "uniqueItems": True, "items": _quantity(name)}
    end = _quantity(name, words=False)
    return [
        values,
        {"type": "object", "required": ["values"], "additionalProperties": False, "properties": {"values": values}},
        {
            "type": "object",
            "required": ["start", "stop", "num"],
            "additionalProperties": False,
            "properties": {
                "start": end,
                "stop": end,
                "num": {"type": "integer", "minimum": 2, "maximum": LONGEST_AXIS, "description": "number of points"},
                "spacing": {"enum": ["linear", "log"], "default": "linear"},
            },
        },
    ]


# --- the rest ---------------------------------------------------------------------------------------------------------


def _section(model: type[Section], shapes: Schema) -> Schema:
    """A section of other things: their shapes, with descriptions and defaults from the model."""
    properties = {}
    for name, field in model.model_fields.items():
        properties[name] = {"description": field.description, **shapes[name]}
        if field.default is not None:
            properties[name]["default"] = field.default
    return _object(properties, str(model.__doc__))


def _file_name(suffixes: tuple[str, ...]) -> Schema:
    return {"type": "string", "pattern": f"({'|'.join(map(re.escape, suffixes))})$"}


_OTHERS: Schema = {
    "fit": {"type": "string"},
    "profile": {"enum": list(PROFILES)},
    "strokes": {"type": "integer", "minimum": 1},
}
_JUDGED = {
    "features": "How the features of a record are read: bandwidth of the sensor, smallest drop of the force, ...",
    "risk": "Parameters of the model RPN: base, and weight_ and scale_ of each of its three features.",
}
_SOLVER: Schema = {
    "rtol": {"type": "number", "minimum": RTOL[0], "maximum": RTOL[1]},
    "horizon": {
        "anyOf": [
            _number(HORIZON_UNITS, 0, True),
            {"type": "string", "pattern": _WITH_UNIT, "examples": [units.example(HORIZON_UNITS)]},
        ]
    },
    "max_steps": {"type": "integer", "minimum": 1},
    "early_stop": {"type": "boolean"},
}
_EXECUTION: Schema = {
    "threads": {"anyOf": [{"const": "auto"}, {"type": "integer", "minimum": 1}]},
    "block": {"type": "integer", "minimum": 1},
    "dask": {"type": "string", "pattern": PATTERN, "examples": ["tcp://host:8786", LOCAL]},
}
_SENSOR: Schema = {
    **{
        name: {
            "anyOf": [
                _number(declared.units, declared.minimum, declared.exclusive),
                {"type": "string", "pattern": _WITH_UNIT, "examples": [units.example(declared.units)]},
            ]
        }
        for name, declared in SENSOR.items()
    },
    "seed": {"type": "integer", "minimum": 0},
    "oversampling": {"type": "integer", "minimum": 1, "maximum": 64},
}
_OUTPUT: Schema = {"file": _file_name(OUTPUT_SUFFIXES), "plot": _file_name(PLOT_SUFFIXES)}
