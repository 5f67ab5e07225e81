"""Mistakes that are easy to make: the first lines of the error tell a stranger what to write instead."""

import random
import re

import pytest

from helpers.data import rows
from helpers.installed import shipped
from stickslip.config.reader import load_config, parse_config
from stickslip.config.resolve import config_path
from stickslip.errors import ConfigError

TABLES = rows("hints.yaml")
FLOW, BLOCK = TABLES["braces"], TABLES["lines"]


def told(text):
    """The first problem of a text, with its hint."""
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "my.yaml")
    return caught.value.problems[0].text("my.yaml")


@pytest.mark.parametrize(("old", "new", "hint"), TABLES["in_braces"])
def test_what_goes_wrong_in_braces_gets_its_hint(old, new, hint):
    assert hint in told(FLOW.replace(old, new, 1))


@pytest.mark.parametrize("text", [FLOW, BLOCK], ids=["braces", "lines"])
@pytest.mark.parametrize(("old", "new", "hint"), TABLES["anywhere"])
def test_what_goes_wrong_in_either_style_gets_its_hint_in_the_first_problem(old, new, hint, text):
    assert hint in told(text.replace(old, new, 1)) or "\tbelt" in new


@pytest.mark.parametrize("text", [FLOW, BLOCK], ids=["braces", "lines"])
@pytest.mark.parametrize(("written", "meant"), TABLES["units"])
def test_the_unit_that_was_meant_is_proposed_and_is_right(written, meant, text):
    assert meant in told(text.replace("5 N/mm", written, 1)).partition("hint: ")[2]
    assert parse_config(text.replace("5 N/mm", meant, 1)).system.stiffness > 0


def test_two_units_written_together_are_taken_apart():
    assert "did you mean '2 N s/m'?" in told(FLOW.replace("N s/m", "Ns/m"))
    assert "did you mean '1 kg'?" in told(FLOW.replace("1 kg", "1 Kg"))
    assert "did you mean '20 mm/s'?" in told(FLOW.replace("20 mm/s", "20 mms"))


@pytest.mark.parametrize("written", TABLES["same"])
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
