"""The JSON Schema of configurations, for editors that check and complete YAML.

It is generated from the tables and models that the reader uses. It cannot say everything: that each quantity is given
exactly once, and what must hold between quantities, is checked by `load_config` alone.
"""

from stickslip import extensions
from stickslip.config.model import SECTIONS, Range
from stickslip.config.problems import model_at
from stickslip.config.reader import DEFAULT_TITLE
from stickslip.config.sections import VALUE, Friction, Read, Schema, Section, number_schema
from stickslip.config.studies import section_class
from stickslip.config.uncertain import DRAWN, FORMS, SamplingSection, Uncertain
from stickslip.vocabulary import units
from stickslip.vocabulary.models import CURVE
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import AXIS, QUANTITIES, SEARCHABLE
from stickslip.vocabulary.studies import STUDIES


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


# --- axes -------------------------------------------------------------------------------------------------------------


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


# --- sections ---------------------------------------------------------------------------------------------------------


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
