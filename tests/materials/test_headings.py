"""Headings as people and instruments write them: what is understood, and what must not be."""

from itertools import product

import pytest

from helpers.nightly import few
from helpers.tables import materials, points
from stickslip.errors import ConfigError
from stickslip_materials.fit.headings import heading
from stickslip_materials.fit.words import POINTS, RECORD, STEPS

SPEEDS = (
    "Gleitgeschw. [mm/s]|Geschw. [mm/s]|Geschw [mm/s]|Rel.-Geschw. [mm/s]|Relativgeschw. [mm/s]|Gleit-Geschw. (mm/s)|"
    "Prüfgeschw. [mm/s]|v_gleit [mm/s]|v_rel (mm/s)|v_slip [mm/s]|slip vel. [mm/s]|Sliding vel. (mm/s)|"
    "slid. speed [mm/s]|Vel. [mm/s]|rel. velocity, mm/s|Vit. [mm/s]|vit. gliss. [mm/s]|Vit. de gliss. (mm/s)|"
    "vitesse rel. [mm/s]|Gleitgeschwind. [mm/s]|Geschw. in mm/s|Gl.-Geschw. [mm/s]|mittl. Gleitgeschw. [mm/s]|"
    "Geschw. (Soll) [mm/s]|Gleitgeschw.[mm/s]|Motor vel. [mm/s]|Gleitgeschwindigk. / mm/s|Gleitgeschw. v [mm/s]|"
    "sliding_vel [mm/s]|Spd [mm/s]|controlled speed [mm/s]|Anfangsgeschw. [mm/s]|Prüfgeschwindigkeit [mm/s]|"
    "Sliding speed v (mm/s)|mean velocity, mm/s"
).split("|")
FRICTIONS = (
    "Reib.-Zahl|Reib.-Zahl [-]|Reibkoeff.|Reibungskoeff. µ|Reib.koeff. [-]|Reib.beiwert|Reibungsbeiwert|Reibungsz.|"
    "COF avg.|COF (avg.)|avg. COF|COF Mittelw.|Frict. coeff.|Friction coef.|fric. coeff. [-]|Coef. of fric.|"
    "Coeff. frott.|coef. de frot.|µ mittl.|Reibungszahl µ [-]|Reibungskoeff. (Mittelwert)|mittl. Reibungszahl|mue|Mü|"
    "mu_avg|Reibungskoeffiz.|dyn. Reibzahl|Gleitreib.-Zahl|Gleitreibungskoeff.|kin. frict. coeff.|C.O.F.|COF|mean µ|"
    "Friction [-]|friction coefficient, -|Coefficient de frottement|dyn. COF|sliding friction coefficient|"
    "Friction (kinetic)"
).split("|")
OF_MATERIALS = ["COF A", "µ (PTFE)", "Reibwert Fett 1", "COF [%]"]
NEITHER = (
    "Drehzahl [1/min]|Umfangsgeschw. [mm/s]|Rolling speed [mm/s]|Entrainment speed [mm/s]|Summengeschw. [mm/s]|"
    "Rotational speed [rpm]|Verschleißgeschw. [µm/h]|Schwinggeschw. [mm/s]|Reib.-Arbeit [J]|Reibleistung [W]|"
    "Reibspur [mm]|Noise level [dB]|Std.-Abw.|Standardabw.|Norm.-Kraft [N]|Prüfl. [N]|Travel [mm]|Nr.|n in rpm"
).split("|")

ENGLISH = (
    "temperature torque power energy radius time distance work heat moment pressure stress wear length width area "
    "angle frequency noise loss voltage track path rate index number cycles depth velocity ratio duration acceleration "
    "signal"
).split()
GERMAN = (
    "temperatur drehmoment moment leistung energie arbeit wärme radius weg strecke zeit dauer spur fläche verschleiß "
    "winkel druck spannung geschwindigkeit paarung länge"
).split()
FRENCH = (
    "température couple puissance énergie travail chaleur rayon distance temps durée usure pression contrainte "
    "longueur vitesse piste angle"
).split()
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


ABOVE = "Bericht;;\nProbe;Fett;\nPrüflast;15;N\n\n"
REFUSED = {  # by text: line, what is quoted, option of the hint
    ABOVE + "Nr.;Umfangsgeschw. [mm/s];Reib.-Zahl µ [-]\n1;1,0;0,14\n2;2,0;0,13\n":
        (5, "'Umfangsgeschw. [mm/s]'", "--speed-column 'Umfangsgeschw. [mm/s]'"),
    "Titel;x\nDrehzahl;mu\n1/min;-\n1;0.3\n2;0.2\n": (2, "'Drehzahl", "--speed-column"),
    "Drehgeschwindigkeit [rpm];COF\n1;0,3\n2;0,3\n": (1, "'Drehgeschwindigkeit [rpm]'", "--speed-column"),
    "Motor speed a;Motor speed b;COF\n1;1;0,3\n2;2;0,3\n": (1, "'Motor speed b'", "--speed-column"),
    "1;0.5\n2;0.4\n3;0.3\n": (1, "no column is called", "the first line names the columns"),
}  # fmt: skip


@pytest.mark.parametrize("text", REFUSED)
def test_what_is_not_understood_is_quoted_with_the_line_of_the_header(text, tmp_path):
    line, words, hint = REFUSED[text]
    with pytest.raises(ConfigError) as caught:
        materials(tmp_path, text)
    (problem,) = caught.value.problems
    assert problem.place.line == line and words in problem.message and hint in problem.hint
