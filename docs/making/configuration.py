"""The page of every key of a configuration, from the JSON Schema, which is made of the tables of the reader."""

from collections.abc import Iterator
from typing import Any

from making.markdown import code, codes, sentence, table
from stickslip.config.describe import json_schema
from stickslip.vocabulary.quantities import DECIDED, MAP_VARIABLES, PARAMETERS, QUANTITIES, SEARCHABLE

Schema = dict[str, Any]

HEAD = """# Every key of a configuration

A configuration is a YAML file of the sections below; only `system` and `friction` are always needed. A number is in SI,
a text carries a unit (`10 mm/s`), and every quantity of a cell is given exactly once: in its section, or under `axes`.
In a list, a range or a distribution a number takes the unit of the next one, as in `[-5, 5 mm/s]`; after one with a
unit it needs its own.
Where no default stands, a quantity must be given and any other key may be left out.

[tutorial.md](tutorial.md) begins with one, `stickslip init my.yaml` writes one with comments, `stickslip validate
my.yaml` says what was understood of it, and `stickslip schema` prints the JSON Schema by which editors complete and
check keys.
"""
AXES = """## axes

What varies, a dimension of the map each, the outermost first. Any quantity of `system`, `friction`, `start` and, on a
test rig, `drive` can be one, in one of these forms:

| form | meaning |
| --- | --- |
| `stiffness: [1 N/mm, 5 N/mm]` | these values, each once |
| `stiffness: {start: 1 N/mm, stop: 10 N/mm, num: 200}` | from start to stop, both included; or `spacing: log` |
| `grease: {labels: [A, B], zip: {a1: [0.1, 0.2], a3: [0.1, 0.3]}}` | what varies together, under a name of its own |

A list may hold the words that its quantity allows, such as `none`.
"""
_MORE = {  # pages that tell what a section does
    "friction": "model.md", "start": "model.md#the-start", "drive": "rig.md", "sensor": "rig.md", "features": "rig.md",
    "risk": "rig.md", "border": "borders.md", "contours": "borders.md", "goal": "explain.md", "explain": "explain.md",
    "margins": "borders.md#margins-how-far-from-the-border", "refine": "borders.md#refined-maps",
    "attractors": "attractors.md", "uncertain": "uncertainty.md",
    "execution": "runs.md", "output": "runs.md", "solver": "regimes.md#accuracy",
}  # fmt: skip
_LISTS = {  # long lists of names, and what they are
    tuple(QUANTITIES): "quantities",
    **{tuple(names): "quantities of a cell" for names in (PARAMETERS, SEARCHABLE)},
    tuple(MAP_VARIABLES): "[variables](variables.md)", tuple(DECIDED): "regimes but `unresolved` and `failed`",
}  # fmt: skip


def page() -> str:
    """The whole page, in Markdown."""
    properties = json_schema()["properties"]
    title = properties.pop("title")
    properties.pop("axes")  # said otherwise: above
    words = f"`title` says {title['description']}; without one it is {title['default']!r}."
    first, others = ("system", "friction"), [key for key in properties if key not in ("system", "friction")]
    parts = [HEAD, words + "\n", *(_section(key, properties[key]) for key in first), AXES]
    return "\n".join([*parts, *(_section(key, properties[key]) for key in others)])


def _section(key: str, section: Schema) -> str:
    """Heading, words and keys of a section."""
    more = f" See [{_MORE[key].partition('#')[0]}]({_MORE[key]})." if key in _MORE else ""
    required = section.get("required", ())
    rows = ((code(name), *_row(one, name in required)) for name, one in section["properties"].items())
    keys = table(("key", "meaning", "unit", "allowed", "default"), rows)
    return f"## {key}\n\n{sentence(section['description'])}{more}\n\n{keys}"


def _row(key: Schema, required: bool) -> tuple[str, ...]:
    unit = _unit(key)
    meaning = key["description"].removesuffix(f" ({unit})")
    default = "must be given" if required else code(_written(key["default"])) if "default" in key else ""
    return meaning, unit, "; ".join(dict.fromkeys(filter(None, _allowed(key)))), default


def _unit(key: Schema) -> str:
    number = key["anyOf"][0].get("description", "") if "anyOf" in key else ""
    return number.removeprefix("in ") if number.startswith("in ") else ""


def _allowed(one: Schema) -> Iterator[str]:
    """What may be written, in words, a form each."""
    if "anyOf" in one:
        for form in one["anyOf"]:
            yield from _allowed(form)
    elif "enum" in one:
        yield _names(one["enum"])
    elif "const" in one:
        yield code(one["const"])
    elif one.get("type") == "array":
        yield _list(one)
    elif one.get("type") == "boolean":
        yield "`true`, `false`"
    elif one.get("type") in ("number", "integer") or "exclusiveMinimum" in one:
        yield _number(one)
    elif one.get("type") == "string":
        yield from (f"such as {code(example)}" for example in one.get("examples", ()))
    elif "properties" in one:
        yield "a mapping of " + codes(one["properties"]) if len(one["properties"]) < 9 else "a mapping by quantity"
    else:
        yield "a mapping by quantity"


def _list(one: Schema) -> str:
    within = "; ".join(filter(None, _allowed(one["items"]))) if "items" in one else ""
    if one.get("minItems") == 2 == one.get("maxItems"):
        return "a list of two" + (f" {within}" if "enum" in one["items"] else ", the lower end first")
    return f"a list of {within}" if within else "a list"


def _names(names: list[str]) -> str:
    return _LISTS.get(tuple(names)) or (codes(names) if len(names) < 9 else "names of [variables](variables.md)")


def _number(one: Schema) -> str:
    whole = "whole, " if one.get("type") == "integer" else ""
    bounds = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
    said = " and ".join(f"{sign} {one[key]:.10g}" for key, sign in bounds.items() if key in one)
    return f"{whole}{said}" if said else "any number"


def _written(value: object) -> object:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else value
