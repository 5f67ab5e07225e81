"""Mistakes that are easy to make: the first lines of the error tell a stranger what to write instead."""

import random
import re

import pytest

from helpers.installed import shipped
from stickslip.config.reader import load_config, parse_config
from stickslip.config.resolve import config_path
from stickslip.errors import ConfigError

FLOW = """\
title: Grease A
system: {mass: 1 kg, normal_load: 10 N, stiffness: 5 N/mm, damping: 2 N s/m}
friction: {a1: 0.2, a2: 0.02, a3: 0.1, a4: 20 mm/s}
axes:
  belt_speed: {start: 1 mm/s, stop: 200 mm/s, num: 80}
"""
BLOCK = """\
title: Grease A
system:
  mass: 1 kg
  normal_load: 10 N
  stiffness: 5 N/mm
friction:
  a1: 0.2
  a2: 0.02
  a3: 0.1
  a4: 20 mm/s
axes:
  belt_speed:
    start: 1 mm/s
    stop: 200 mm/s
    num: 80
"""
IN_BRACES = {  # what is written instead of what, and what is said
    ("mass: 1 kg", "mass: 1,5 kg"): "my.yaml:2:18: system.5 kg: unknown key",
    ("a1: 0.2", "a1:0.2"): "my.yaml:3:1: friction.a1: missing",
    ("{start: 1 mm/s, stop: 200 mm/s, num: 80}", "1 mm/s to 200 mm/s"): "belt_speed: {start: ..., stop: ...",
    ("a4: 20 mm/s}", "a4: 20 mm/s"): "while parsing a flow mapping that begins on line 3",
    ("20 mm/s}", "20 mm/s}}"): "found '}'",
    ("a1: 0.2, ", "a1: 0.2 "): "my.yaml:3:",
}
ANYWHERE = {
    ("title: Grease A", "title: 1e9"): "put it in quotes",
    ("title: Grease A", "title: true"): "put it in quotes",
    ("title: Grease A", "title: Grease: A"): "a text that contains ': ' needs quotes",
    ("title: Grease A", "title:Grease"): "my.yaml:2:7: not valid YAML",
    ("title: Grease A", "title: @home"): "a text that begins with this character needs quotes",
    ("title: Grease A", 'title: "Grease'): "a quote is not closed",
    ("axes:", "axes"): "could not find expected ':'",
    ("axes:", "axis:"): "did you mean axes?",
    ("axes:", 'output: {file: "C:\\results\\map.nc"}\naxes:'): "use single quotes, or /",
    ("axes:", 'output: {file: "C:\\users\\map.nc"}\naxes:'): "use single quotes, or /",
    ("axes:", "output: {file: map}\naxes:"): "did you mean map.nc?",
    ("axes:", "output: map.nc\naxes:"): "expected a mapping with the keys file, plot",
    ("axes:", "solver: {early_stop: yes}\naxes:"): "expected true or false",
    ("axes:", "friction: {a1: 1}\naxes:"): "remove one of the two",
    ("stiffness", "stifness"): "did you mean stiffness?",
    ("stiffness", "k"): "did you mean stiffness?",
    ("normal_load", "Load"): "did you mean normal_load?",
    ("belt_speed", "belt speed"): "did you mean belt_speed?",
    ("num", "steps"): "num: missing, expected start, stop and num",
    ("mass: 1 kg", "mass: [1 kg, 2 kg]"): "what varies belongs to axes: {mass: ...}",
    ("\n  belt", "\n\tbelt"): "indent with spaces, not with tabs",
}
UNITS = {  # of the stiffness, and what is meant
    "5 N/mm^2": "5 N/mm", "5 N/mm²": "5 N/mm", "5 kN/m m": "5 kN/mm", "5 Nmm": "5 N/mm", "5 N-mm": "5 N/mm",
    "5 N per mm": "5 N/mm", "5 Newton/mm": "5 N/mm", "5 n/mm": "5 N/mm", "5 N/MM": "5 N/mm",
    "5 N/mm.": "5 N/mm", "N/mm": "1 N/mm",
}  # fmt: skip
SAME = [  # other characters for 20 mm/s: no mistake
    "20\u00a0mm/s", "20\u202fmm/s", "20 mm s⁻¹", "20 mm·s⁻¹", "20 mm⋅s-1", "20 mm∕s", "20 µm/ms", "20 μm/ms",
    "20 mm/sec", "20mm/s", "2e1 mm/s",
]  # fmt: skip


def told(text):
    """The first problem of a text, with its hint."""
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "my.yaml")
    return caught.value.problems[0].text("my.yaml")


@pytest.mark.parametrize(("pair", "hint"), IN_BRACES.items(), ids=[new for _, new in IN_BRACES])
def test_what_goes_wrong_in_braces_gets_its_hint(pair, hint):
    assert hint in told(FLOW.replace(*pair, 1))


@pytest.mark.parametrize("text", [FLOW, BLOCK], ids=["braces", "lines"])
@pytest.mark.parametrize(("pair", "hint"), ANYWHERE.items(), ids=[new for _, new in ANYWHERE])
def test_what_goes_wrong_in_either_style_gets_its_hint_in_the_first_problem(pair, hint, text):
    assert hint in told(text.replace(*pair, 1)) or "\tbelt" in pair[1]


@pytest.mark.parametrize("text", [FLOW, BLOCK], ids=["braces", "lines"])
@pytest.mark.parametrize(("written", "meant"), UNITS.items())
def test_the_unit_that_was_meant_is_proposed_and_is_right(written, meant, text):
    assert meant in told(text.replace("5 N/mm", written, 1)).partition("hint: ")[2]
    assert parse_config(text.replace("5 N/mm", meant, 1)).system.stiffness > 0


def test_two_units_written_together_are_taken_apart():
    assert "did you mean '2 N s/m'?" in told(FLOW.replace("N s/m", "Ns/m"))
    assert "did you mean '1 kg'?" in told(FLOW.replace("1 kg", "1 Kg"))
    assert "did you mean '20 mm/s'?" in told(FLOW.replace("20 mm/s", "20 mms"))


@pytest.mark.parametrize("written", SAME)
def test_other_characters_for_the_same_unit_are_understood(written):
    assert parse_config(FLOW.replace("20 mm/s", written)).friction.a4 == pytest.approx(0.02, rel=1e-15)


def test_a_misspelt_key_is_the_only_thing_that_is_wrong():
    """What is missing because of it is not listed beside it."""
    for old, new in (("stiffness", "stifness"), ("axes:", "axis:"), ("num", "nmu")):
        with pytest.raises(ConfigError) as caught:
            parse_config(FLOW.replace(old, new, 1))
        assert len(caught.value.problems) == 1, str(caught.value)


# --- mutations of files that are right --------------------------------------------------------------------------------

TEXTS = {name: config_path(name).read_text(encoding="utf-8") for name in shipped()}
_KEY = re.compile(r"(?<=[{ ,\n])([a-z][a-z_]{3,}): ")
KEYS = {name: [m for m in _KEY.finditer(text) if "#" not in text[: m.start()].splitlines()[-1]]
        for name, text in TEXTS.items()}  # fmt: skip


def problems_of(tmp_path, name, text):
    path = tmp_path / "my.yaml"
    path.write_text(text, encoding="utf-8")
    try:
        load_config(path, apart=None)
    except ConfigError as error:
        return [problem.text("my.yaml") for problem in error.problems]
    return []


@pytest.mark.filterwarnings("ignore::stickslip.errors.UnitWarning")
@pytest.mark.parametrize("name", TEXTS)
def test_a_key_with_two_letters_swapped_is_named_in_a_hint(tmp_path, name):
    """Any key of any configuration that ships: the line is the right one, and the hint has the word."""
    generator = random.Random(name)
    for match in generator.sample(KEYS[name], min(3, len(KEYS[name]))):
        key, at = match[1], generator.randrange(len(match[1]) - 1)
        swapped = key[:at] + key[at + 1] + key[at] + key[at + 2 :]
        if swapped == key:
            continue
        text = TEXTS[name][: match.start()] + swapped + TEXTS[name][match.end(1) :]
        said = problems_of(tmp_path, name, text)
        line = text[: match.start()].count("\n") + 1
        about = [one for one in said if one.startswith(f"my.yaml:{line}:")]
        assert any(key in one.partition("hint:")[2] for one in about), (swapped, said)
