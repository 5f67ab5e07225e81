"""Headings as people and instruments write them: what is understood, and what must not be."""

from itertools import product

import pytest

from helpers.data import cases, rows
from helpers.nightly import few
from helpers.tables import materials, points
from stickslip.errors import ConfigError
from stickslip_materials.fit.headings import heading
from stickslip_materials.fit.words import POINTS, RECORD, STEPS

WORDS = rows("materials.yaml")["test_headings"]
SPEEDS, FRICTIONS, NEITHER = (WORDS[name] for name in ("SPEEDS", "FRICTIONS", "NEITHER"))
ENGLISH, GERMAN, FRENCH = (WORDS[name] for name in ("ENGLISH", "GERMAN", "FRENCH"))
OF_MATERIALS = ["COF A", "µ (PTFE)", "Reibwert Fett 1", "COF [%]"]
NAMES = (
    [f"{word} {noun}" for word, noun in product(("friction", "frictional", "sliding", "Slip", "traction"), ENGLISH)]
    + [f"{noun} of friction" for noun in ENGLISH]
    + [f"{start}{noun}" for start, noun in product(("Reib", "Reibungs", "Gleit", "Reib-", "Haft"), GERMAN)]
    + [f"{noun} de {word}" for noun, word in product(FRENCH, ("frottement", "glissement"))]
    + ["Sliding", "Friction pair", "COF temperature", "Dynamic viscosity", "Static load", "Kinetic energy", "Slip"]
)
QUALIFIED = ("{}", "mean {}", "{} (avg)", "{}_mean", "{} Mittelwert", "measured {}", "{} 1", "max. {}")
UNITS = ("", " [-]", " [W]", " [°C]", " [Nm]", " (mm)", ", J", " in s", "_K", " [1]")
NOT_MU = sorted({qualified.format(name) + unit for name, qualified, unit in product(NAMES, QUALIFIED, UNITS)})


@pytest.mark.parametrize("text", SPEEDS)
def test_a_speed_is_read_in_its_unit(text, tmp_path):
    one = points(tmp_path, f"Messung Fett 1\n\n{text};µ\n2;0,3\n4;0,2\n")
    assert one["speed"].tolist() == [0.002, 0.004] and one["mu"].tolist() == [0.3, 0.2] and not one.assumed


@pytest.mark.parametrize("text", FRICTIONS)
def test_a_coefficient_is_friction_beside_other_columns(text, tmp_path):
    rows = f"Nr.;v [mm/s];{text};Verschleiß\n1;2;0,3;0,1\n2;4;0,2;0,1\n"
    assert {name: one["mu"].tolist() for name, one in materials(tmp_path, rows).items()} == {"": [0.3, 0.2]}


def test_a_coefficient_may_be_called_after_a_material():
    assert {heading(text).kind for text in OF_MATERIALS} == {"mu"}


@pytest.mark.parametrize("text", NEITHER)
def test_another_quantity_is_neither_a_speed_nor_friction(text):
    assert heading(text).kind not in ("speed", "mu", "kinetic", "static")


@pytest.mark.parametrize("kinds", few([POINTS, STEPS, RECORD], 1))
def test_no_other_quantity_is_friction_because_it_is_called_after_it(kinds):
    frictions = ("mu", "kinetic", "static", "friction_force", "")
    wrong = [text for text in NOT_MU if heading(text, kinds).kind in frictions[: 5 if kinds == POINTS else 4]]
    assert not [text for text in wrong if "force" not in heading(text, kinds).kind]


@cases("materials.yaml")
def test_what_is_not_understood_is_quoted_with_the_line_of_the_header(text, line, words, hint, tmp_path):
    with pytest.raises(ConfigError) as caught:
        materials(tmp_path, text)
    (problem,) = caught.value.problems
    assert problem.place.line == line and words in problem.message and hint in problem.hint
