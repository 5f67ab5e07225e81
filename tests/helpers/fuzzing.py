"""Broken configurations, made from good ones: what people mistype, and what nobody would write but an attacker.

Two ways: a tree is changed and written out again, bytes are thrown in. Strategies are
hypothesis's, so that what is found comes out small.
"""

import json
import os
from copy import deepcopy

from hypothesis import strategies as st

from helpers.data import rows
from helpers.installed import shipped
from stickslip.config.reader import SECTIONS
from stickslip.config.resolve import config_path
from stickslip.config.yaml import parse_yaml
from stickslip.vocabulary.quantities import QUANTITIES

EXAMPLES = int(os.environ.get("STICKSLIP_FUZZ", "0"))  # of each kind; 0: the few that continuous integration tries
TRIPWIRE = "stickslip-fuzz-tripwire"  # a file that code smuggled into a configuration would make

SHIPPED = [config_path(name).read_text(encoding="utf-8") for name in shipped() if "/" not in name]
GOOD = SHIPPED + rows("good.yaml")

# --- single values ----------------------------------------------------------------------------------------------------

NUMBERS = st.one_of(
    st.sampled_from([0, -0.0, 1, -1, 10**12, 10**15, 2**63, 10**400, -(10**400), 1e308, -1e308, 5e-324, 1e-300]),
    st.integers(),
    st.floats(allow_nan=True, allow_infinity=True),
)
WORDS = st.sampled_from(
    [*QUANTITIES, *SECTIONS, "title", "axes", "zip", "labels", "values", "start", "stop", "num", "spacing", "log"]
    + ["none", "sticking", "auto", "linear", "cubic", "rational", "true", "null", "~", ".nan", ".inf", "-.inf", "1e999"]
)
UNITS = st.builds(
    "{}{}{}{}".format,
    st.sampled_from(["1", "1,5", "1.5", "1e5", "1e-400", "1e9999", "-0", "nan", "٣", "1_000", "0x10", "2**99", ""]),
    st.sampled_from([" ", "", "\t", "\u00a0", "  "]),
    st.sampled_from(["mm/s", "m/s", "N", "kg", "N/m", "degC", "m^9", "m^99", "µm", "N s/m", "s/m", "nan", "inf"]),
    st.sampled_from(["", "", "", "/", "^", "**2", " ()", ";", "__class__", "²", "\x00"]),
)
HOSTILE = st.sampled_from(["x" * 5000, "../../etc/passwd", "/dev/stdin", "\ud7ff", "a\0b"])
TEXTS = st.one_of(WORDS, UNITS, st.text(max_size=20), HOSTILE)
SCALARS = st.one_of(NUMBERS, TEXTS, st.none(), st.booleans())
TREES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXTS, inner, max_size=4), max_leaves=6
)

# What YAML has beyond plain data, and what it is feared for.
RAW = st.sampled_from(
    [
        f'!!python/object/apply:os.system ["touch {TRIPWIRE}"]',
        f'!!python/object/new:os.system ["touch {TRIPWIRE}"]',
        "!!python/name:os.system",
        "!!binary aGVsbG8=", "!!set {a, b}", "!!timestamp 2001-01-01", "!local x", "!<tag:yaml.org,2002:str> x",
        "&a [1, 2]", "*a", "&a *a", "<<: *a", "{<<: {a: 1}}", "? [complex, key] : value", "{1: 2}", "{null: 1}",
        "|\n  text", ">-\n  text", "'it''s'", '"\\x41\\u00e9\\U0001F600"', '"\\ud800"', "---", "...", "%YAML 1.1",
        "[" * 500, "{a: " * 100, "- " * 50, "]", "}", "\t- a", "#", "@", "`", "%", "017", "0o17", "0x1F", "1_000",
        "12:30:00", "2001-01-01", "=", "1.5.2", "+.inf", "+1", "1.", ".5", "1e", "e5", "--1", "Infinity", "NaN",
        "\x07", "\x85", "\u2028", "\ufeff", "\u202e", "\x00", "\x1b[31m", "é" * 300, "9" * 2000, "0." + "9" * 2000,
    ]
)  # fmt: skip


# --- trees, texts and bytes -------------------------------------------------------------------------------------------


class Raw(str):
    """A piece of YAML that is written as it is."""


def dump(value: object) -> str:
    """A tree as YAML in flow style."""
    if isinstance(value, Raw):
        return str(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{dump(key)}: {dump(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(dump, value)) + "]"
    if isinstance(value, float):
        return repr(value).replace("inf", ".inf").replace("nan", ".nan")
    if isinstance(value, int) and not isinstance(value, bool):
        return f"{value:d}" if abs(value) < 10**4000 else "9" * 5000
    return json.dumps(value, ensure_ascii=False)


def places(value):
    """Every mapping and list in a tree, and each key or index in it."""
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield value, key
        yield from places(value[key])


@st.composite
def mutated_trees(draw) -> str:
    """A good configuration with one to four changes, with a line per section, so that errors have lines to name."""
    tree = {"": deepcopy(parse_yaml(draw(st.sampled_from(GOOD))).data)}
    for _ in range(draw(st.integers(1, 4))):
        inside, key = draw(st.sampled_from([*places(tree)]))
        kind = draw(st.sampled_from(["replace", "insert", "repeat", "move", "drop", "rename"]))
        if kind == "repeat":
            inside[key] = [deepcopy(inside[key]) for _ in range(draw(st.integers(0, 3)))]
        elif kind == "move":
            other, at = draw(st.sampled_from([*places(tree)]))
            inside[key] = deepcopy(other[at])
        elif kind == "drop" and inside is not tree:
            del inside[key]
        elif kind == "rename" and inside is not tree and isinstance(inside, dict):
            inside[draw(TEXTS)] = inside.pop(key)
        elif kind == "insert" and isinstance(inside[key], dict):
            inside[key][draw(TEXTS)] = draw(TREES | RAW.map(Raw))
        else:
            inside[key] = draw(TREES | RAW.map(Raw))
    whole = tree[""]
    if not isinstance(whole, dict) or not whole:
        return dump(whole) + "\n"
    return "".join(f"{dump(key)}: {dump(value)}\n" for key, value in whole.items())


@st.composite
def mutated_bytes(draw) -> bytes:
    """A good configuration with bytes of any value, or bytes alone."""
    data = draw(st.sampled_from([*map(str.encode, GOOD), b""]))
    for _ in range(draw(st.integers(1, 5))):
        start = draw(st.integers(0, len(data)))
        data = data[:start] + draw(st.binary(max_size=200 if not data else 8)) + data[start + draw(st.integers(0, 8)) :]
    return data


def files() -> st.SearchStrategy[bytes]:
    """Contents of configuration files, most of them broken."""
    texts = mutated_trees().map(lambda text: text.encode("utf-8", "surrogatepass"))
    return st.one_of(texts, texts, mutated_bytes())
