"""Headings as people and instruments abbreviate them: what is understood, and what must not be."""

import pytest

from stickslip.errors import ConfigError
from stickslip.vocabulary.quantities import CURVE_COLUMNS
from stickslip_materials.fit import read_materials
from stickslip_materials.fit.headings import heading

SPEEDS = (
    "Gleitgeschw. [mm/s]|Geschw. [mm/s]|Geschw [mm/s]|Rel.-Geschw. [mm/s]|Relativgeschw. [mm/s]|Gleit-Geschw. (mm/s)|"
    "Prüfgeschw. [mm/s]|v_gleit [mm/s]|v_rel (mm/s)|v_slip [mm/s]|slip vel. [mm/s]|Sliding vel. (mm/s)|"
    "slid. speed [mm/s]|Vel. [mm/s]|rel. velocity, mm/s|Vit. [mm/s]|vit. gliss. [mm/s]|Vit. de gliss. (mm/s)|"
    "vitesse rel. [mm/s]|Gleitgeschwind. [mm/s]|Geschw. in mm/s|Gl.-Geschw. [mm/s]|mittl. Gleitgeschw. [mm/s]|"
    "Geschw. (Soll) [mm/s]|Gleitgeschw.[mm/s]|Motor vel. [mm/s]|Gleitgeschwindigk. / mm/s|Gleitgeschw. v [mm/s]|"
    "sliding_vel [mm/s]|Spd [mm/s]|controlled speed [mm/s]|Anfangsgeschw. [mm/s]"
).split("|")
FRICTIONS = (
    "Reib.-Zahl|Reib.-Zahl [-]|Reibkoeff.|Reibungskoeff. µ|Reib.koeff. [-]|Reib.beiwert|Reibungsbeiwert|Reibungsz.|"
    "COF avg.|COF (avg.)|avg. COF|COF Mittelw.|Frict. coeff.|Friction coef.|fric. coeff. [-]|Coef. of fric.|"
    "Coeff. frott.|coef. de frot.|µ mittl.|Reibungszahl µ [-]|Reibungskoeff. (Mittelwert)|mittl. Reibungszahl|mue|Mü|"
    "mu_avg|Reibungskoeffiz.|dyn. Reibzahl|Gleitreib.-Zahl|Gleitreibungskoeff.|kin. frict. coeff.|C.O.F."
).split("|")
NEITHER = (
    "Drehzahl [1/min]|Umfangsgeschw. [mm/s]|Rolling speed [mm/s]|Entrainment speed [mm/s]|Summengeschw. [mm/s]|"
    "Rotational speed [rpm]|Verschleißgeschw. [µm/h]|Schwinggeschw. [mm/s]|Reib.-Arbeit [J]|Reibleistung [W]|"
    "Reibspur [mm]|Noise level [dB]|Std.-Abw.|Standardabw.|Norm.-Kraft [N]|Prüfl. [N]|Travel [mm]|Nr."
).split("|")


def write(folder, text):
    path = folder / "points.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("text", SPEEDS)
def test_an_abbreviated_speed_is_read_in_its_unit(text, tmp_path):
    (one,) = read_materials(write(tmp_path, f"{text};µ\n2;0,3\n4;0,2\n"), CURVE_COLUMNS).values()
    assert one["speed"].tolist() == [0.002, 0.004] and not one.assumed


@pytest.mark.parametrize("text", FRICTIONS)
def test_an_abbreviated_coefficient_is_friction_beside_other_columns(text, tmp_path):
    rows = f"Nr.;v [mm/s];{text};Verschleiß\n1;2;0,3;0,1\n2;4;0,2;0,1\n"
    found = read_materials(write(tmp_path, rows), CURVE_COLUMNS)
    assert {name: one["mu"].tolist() for name, one in found.items()} == {"": [0.3, 0.2]}


@pytest.mark.parametrize("text", NEITHER)
def test_another_quantity_is_neither_a_speed_nor_friction(text):
    assert heading(text).kind not in ("speed", "mu", "kinetic", "static")


def test_what_is_not_understood_is_quoted_with_the_line_of_the_header(tmp_path):
    text = (
        "Bericht;;\nProbe;Fett;\nPrüflast;15;N\n\nNr.;Umfangsgeschw. [mm/s];Reib.-Zahl µ [-]\n1;1,0;0,14\n2;2,0;0,13\n"
    )
    with pytest.raises(ConfigError) as caught:
        read_materials(write(tmp_path, text), CURVE_COLUMNS)
    (problem,) = caught.value.problems
    assert problem.place.line == 5 and "'Umfangsgeschw. [mm/s]'" in problem.message and " mu " not in problem.message
    assert "--speed-column 'Umfangsgeschw. [mm/s]'" in problem.hint and "stickslip fit" not in problem.hint


def test_a_line_of_units_is_not_taken_for_the_header(tmp_path):
    with pytest.raises(ConfigError) as caught:
        read_materials(write(tmp_path, "Titel;x\nDrehzahl;mu\n1/min;-\n1;0.3\n2;0.2\n"), CURVE_COLUMNS)
    (problem,) = caught.value.problems
    assert problem.place.line == 2 and "'Drehzahl" in problem.message
