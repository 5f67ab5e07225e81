"""What the model does not have is said in one sentence, wherever people ask for it."""

from pathlib import Path

import pytest

import stickslip
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError
from stickslip.vocabulary.suggest import SENTENCES

SYSTEM = "mass: 1, stiffness: 100, damping: 0, belt_speed: 0.1, normal_load: 10"
YAML = """
system: {{{system}}}
friction: {{a1: 0.2, a2: 0, a3: 0.2, a4: 0.1{friction}}}
axes: {{damping: [0, 1]{axes}}}
{more}
"""
PAGE = (Path(__file__).resolve().parents[2] / "docs" / "model.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "key, word",
    [
        ({"system": SYSTEM + ", mass_2: 1"}, "second mass"),
        ({"system": SYSTEM + ", degrees-of-freedom: 2"}, "second mass"),
        ({"system": SYSTEM.replace("load: 10", "load: {mean: 10, amplitude: 2, frequency: 30}")}, "dither"),
        ({"axes": ", normal_load: {mean: 10, amplitude: 2}"}, "dither"),
        ({"system": SYSTEM.replace("0.1", "{mean: 0.1, amplitude: 0.02}")}, "The belt runs at a constant speed"),
        ({"friction": ", law: maxwell-slip"}, "one layer of bristles"),
        ({"friction": ", wear: 1"}, "no wear"),
        ({"axes": ", temperature: [20, 80]"}, "Temperature is no quantity"),
        ({"more": "temperature: 20 C\n"}, "Temperature is no quantity"),
    ],
)
def test_a_configuration_that_asks_for_it_is_told(key, word):
    with pytest.raises(ConfigError) as refused:
        parse_config(YAML.format(**{"system": SYSTEM, "friction": "", "axes": "", "more": ""} | key))
    hints = [problem.hint or "" for problem in refused.value.problems]
    assert any(word in hint and "stickslip help speed" in hint for hint in hints), hints


def test_the_page_says_every_sentence():
    assert all(f"- {sentence}.\n" in PAGE for sentence in SENTENCES)


def test_a_call_of_python_is_told_too():
    with pytest.raises(TypeError, match="no second mass"):
        stickslip.evaluate({"mass": 1.0, "mass_2": 1.0})
