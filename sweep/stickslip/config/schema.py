"""The JSON Schema of configurations, for editors that check and complete YAML.

It is generated from the tables and models that the reader uses. It cannot say everything: that each quantity is given
exactly once, and what must hold between quantities, is checked by `load_config` alone.
"""

from __future__ import annotations

import re
from typing import Any

from stickslip.config.addresses import LOCAL, PATTERN
from stickslip.config.margins import Margins
from stickslip.config.reader import DEFAULT_TITLE, SECTIONS
from stickslip.config.scatter import ARGUMENTS, MAY_SCATTER, METRICS, Sampling, Subset, Uncertain
from stickslip.config.sections import OUTPUT_SUFFIXES, PLOT_SUFFIXES, REMOTE_SUFFIX, Section
from stickslip.config.studies import STUDIES, Contours
from stickslip.vocabulary import units
from stickslip.vocabulary.flags import DECIDED
from stickslip.vocabulary.laws import LAWS
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import PARAMETERS, PROFILES, QUANTITIES, SEARCHABLE
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.settings import AXIS, COST, FEATURE_SETTINGS, RISK
from stickslip.vocabulary.words import listed

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
            "axes": _axes(),
            **{key: _section(model) for key, model in (SECTIONS | STUDIES).items() if key != "uncertain"},
            "uncertain": _uncertain(),
            **{key: _judged(key) for key in _JUDGED},
        },
    }


def _uncertain() -> Schema:
    """Quantities that scatter, and how they are drawn."""
    forms = [
        {name: {"type": "number", "exclusiveMinimum": 1} if name == "factor" else _VALUE for name in arguments}
        for arguments in ARGUMENTS.values()
    ]
    kinds: Schema = {
        kind: {"type": "object", "additionalProperties": False, "properties": form, "minProperties": 1}
        for kind, form in zip(ARGUMENTS, forms, strict=True)
    }
    pair = {"type": "array", "minItems": 2, "maxItems": 2, "items": _VALUE}
    kinds["uniform"] = {"anyOf": [kinds["uniform"], pair]}
    ends = {"type": "object", "additionalProperties": False, "properties": {"low": _VALUE, "high": _VALUE}}
    one = {"type": "object", "additionalProperties": False, "properties": {**kinds, "truncated": ends}}
    quantities = {
        name: {"description": _described(row)["description"], **one, "minProperties": 1}
        for name, row in MAY_SCATTER.items()
    }
    matrix = _object(
        {
            "between": {"type": "array", "minItems": 2, "uniqueItems": True, "items": {"enum": list(MAY_SCATTER)}},
            "matrix": {"type": "array", "minItems": 2, "items": {"type": "array", "items": {"type": "number"}}},
        },
        "some of the quantities, and a row of numbers for each",
    )
    matrices = {"anyOf": [matrix, {"type": "array", "items": matrix}]}
    own: Schema = {
        "quantities": {
            "description": f"by quantity, its distribution: {listed(tuple(kinds))}",
            "type": "object",
            "additionalProperties": False,
            "properties": quantities,
        },
        "correlation": matrices | {"description": "of the normal deviates of quantities (a Gaussian copula)"},
        "covariance": matrices | {"description": "of normal quantities, in SI; it says their standard deviations"},
        "subset": _section(Subset),
    }
    found = _object({**_section(Sampling)["properties"], **own}, str(Uncertain.__doc__).splitlines()[0])
    return found | {"anyOf": [{"required": ["quantities"]}, {"required": ["fit"]}]}


def _judged(key: str) -> Schema:
    """A section about how records are judged."""
    rows, description = _JUDGED[key]
    others = {"subtract_offset": _OFFSET} if key == "features" else {}
    return _object({name: _described(row) for name, row in rows.items()} | others, description)


def _object(properties: Schema, description: str) -> Schema:
    return {
        "type": ["object", "null"],  # a section without content is one
        "additionalProperties": False,
        "description": description,
        "properties": properties,
    }


# --- numbers ----------------------------------------------------------------------------------------------------------


def _number(row: Parameter, words: bool = True) -> Schema:
    """A number within the bounds of a row, a text with a unit, or the word for NaN."""
    bare: Schema = {"type": "integer" if row.whole else "number"}
    if row.units != "1":
        bare["description"] = f"in {units.spelled(row.units)}"
    bounds = {"exclusiveMinimum": row.above, "minimum": row.at_least, "maximum": row.at_most}
    forms = [bare | {key: bound for key, bound in bounds.items() if bound is not None}]
    if row.units != "1":
        forms.append({"type": "string", "pattern": _WITH_UNIT, "examples": [units.example(row.units)]})
    if words and row.word:
        forms.append({"const": row.word})
    return forms[0] if len(forms) == 1 else {"anyOf": forms}


def _described(row: Parameter) -> Schema:
    """A number with what it is, its unit, and its default."""
    unit = units.spelled(row.units)
    found = {"description": f"{row.long_name} ({unit})" if unit else row.long_name, **_number(row)}
    if row.default is not None and (row.word or not row.may_be_absent):
        found["default"] = row.written(row.default)
    return found


# --- axes -------------------------------------------------------------------------------------------------------------


def _axes() -> Schema:
    """Quantities that vary, and groups of them."""
    values = {name: {"type": "array", "minItems": 1, "items": _number(QUANTITIES[name])} for name in QUANTITIES}
    values["fit"] = _OTHERS["fit"] | {"description": "measured points: a1 to a4 of each file or column of friction"}
    return {
        "type": ["object", "null"],
        "description": "What varies, the outermost dimension first: quantities, or groups that vary together (zip).",
        "properties": {
            name: {"description": _described(row)["description"], "anyOf": _axis_forms(name)}
            for name, row in QUANTITIES.items()
        },
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
    values = {"type": "array", "minItems": 1, "uniqueItems": True, "items": _number(QUANTITIES[name])}
    end = _number(QUANTITIES[name], words=False)
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
                "num": _described(AXIS["num"]),
                "spacing": {"enum": ["linear", "log"], "default": "linear"},
            },
        },
    ]


# --- sections ---------------------------------------------------------------------------------------------------------


def _section(model: type[Section]) -> Schema:
    """A section: its numbers as the vocabulary has them, the rest with descriptions and defaults from the model."""
    properties: Schema = {}
    for name, field in model.model_fields.items():
        if name in model.rows:
            properties[name] = _described(model.rows[name])
            continue
        properties[name] = {"description": field.description, **(_OTHERS | _OWN.get(model, {}))[name]}
        if field.default is not None and not field.is_required():
            properties[name]["default"] = list(field.default) if isinstance(field.default, tuple) else field.default
    required = [name for name, field in model.model_fields.items() if field.is_required()]
    return _object(properties, str(model.__doc__)) | ({"required": required} if required else {})


def _file_name(*suffixes: str) -> Schema:
    here, anywhere = (s for s in suffixes if s != REMOTE_SUFFIX), re.escape(REMOTE_SUFFIX)
    local = f"^(?!.*://).*({'|'.join(map(re.escape, here))})$"
    return {"type": "string", "pattern": f"{anywhere}$|{local}" if REMOTE_SUFFIX in suffixes else local}


_VALUE: Schema = {"anyOf": [{"type": "number"}, {"type": "string", "pattern": _WITH_UNIT}]}
_RANGE: Schema = {"type": "array", "minItems": 2, "maxItems": 2, "items": _VALUE}
_VARIABLE: Schema = {"enum": list(VARIABLES)}
_OTHERS: Schema = {  # what is not a number
    "along": {"enum": list(SEARCHABLE)},
    "between": _RANGE,
    "displacement": _RANGE,
    "velocity": _RANGE,
    "law": {"enum": list(LAWS)},
    "interpolate": {"type": "boolean"},
    "fit": {"anyOf": [_file_name(".csv"), {"type": "array", "minItems": 1, "items": _file_name(".csv")}]},
    "profile": {"enum": list(PROFILES)},
    "early_stop": {"type": "boolean"},
    "indices": {"type": "boolean"},
    "metrics": {"type": "array", "uniqueItems": True, "items": {"enum": list(METRICS)}},
    "quantiles": {"type": "array", "uniqueItems": True, "items": {"exclusiveMinimum": 0, "exclusiveMaximum": 1}},
    "dask": {"type": "string", "pattern": PATTERN, "examples": ["tcp://host:8786", LOCAL]},
    "file": _file_name(*OUTPUT_SUFFIXES),
    "plot": _file_name(*PLOT_SUFFIXES),
    "variables": {"anyOf": [_VARIABLE, {"type": "array", "minItems": 1, "items": _VARIABLE}]},
}
_NAMES: Schema = {"enum": list(SEARCHABLE)}
_FACTOR: Schema = {"type": "number", "exclusiveMinimum": 1}
_OWN: dict[type[Section], Schema] = {  # where a key means something else in one section
    Contours: {
        "axes": {"type": "array", "minItems": 2, "maxItems": 2, "uniqueItems": True, "items": _NAMES},
        "between": {"type": "object", "propertyNames": _NAMES, "additionalProperties": _RANGE},
    },
    Margins: {
        "parameters": {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"enum": list(PARAMETERS)}},
        "costs": {"type": "object", "propertyNames": {"enum": list(PARAMETERS)}, "additionalProperties": _number(COST)},
        "within": {
            "anyOf": [
                _FACTOR,
                {
                    "type": "object",
                    "propertyNames": {"enum": list(PARAMETERS)},
                    "additionalProperties": {"anyOf": [_FACTOR, _RANGE]},
                },
            ]
        },
        "into": {"type": "array", "minItems": 1, "items": {"enum": list(DECIDED)}},
        "joint": {"type": "boolean"},
    },
}
_JUDGED = {
    "features": (FEATURE_SETTINGS, "How the features of a record are read."),
    "risk": (RISK, "Parameters of the model RPN: base, and weight_ and scale_ of each of its three features."),
}
_OFFSET = {"type": "boolean", "description": "whether the median of the acceleration is subtracted as an offset"}
