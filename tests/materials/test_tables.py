"""Tables of measured points as people, instruments and Excel write them are read to the same numbers."""

import json
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from helpers.commands import call
from helpers.tables import materials, points, write
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError
from stickslip_materials.fit import AGEING_COLUMNS, CURVE_COLUMNS, fit_materials, read_materials, read_points
from stickslip_materials.fit.files import names_of


def table(*columns):
    """Lines of numbers, and the same with decimal commas."""
    return "".join(";".join(row) + "\n" for row in zip(*columns, strict=True))


def test_a_wide_table_is_a_fit_for_each_material_with_gaps_where_it_was_not_measured(tmp_path):
    text = "v [mm/s];dry;grease A;Load [N];Temperature\n1;0,4;0,1;10;20\n2;0,38;;10;20\n3;-;0,09;10;21\n"
    found = read_materials(write(tmp_path, text), CURVE_COLUMNS)
    assert list(found) == ["dry", "grease A"]
    assert found["dry"]["speed"].tolist() == [0.001, 0.002] and found["dry"]["mu"].tolist() == [0.4, 0.38]
    assert found["grease A"]["speed"].tolist() == [0.001, 0.003]
    assert found["dry"].ignored == ("Load [N]", "Temperature")
    with pytest.raises(ConfigError, match=r"got 2 materials \(dry, grease A\), expected one"):
        read_points(write(tmp_path, text), CURVE_COLUMNS)


def test_a_workbook_is_read_from_the_sheet_that_holds_points(tmp_path):
    pd = pytest.importorskip("pandas")
    pytest.importorskip("openpyxl")
    table = pd.DataFrame(
        {"v [mm/s]": [0.5, 1, 20], "dry": [0.41, 0.4, 0.3], "oil; new": [0.1, None, 0.09], "note": "x"}
    )
    with pd.ExcelWriter(tmp_path / "points.xlsx") as writer:
        table.to_excel(writer, index=False)
        pd.DataFrame({"speed": [1]}).to_excel(writer, sheet_name="other", index=False)
    found = read_materials(tmp_path / "points.xlsx", CURVE_COLUMNS)
    assert list(found) == ["dry", "oil; new"] and found["dry"]["speed"].tolist() == [0.0005, 0.001, 0.02]
    assert found["oil; new"]["mu"].tolist() == [0.1, 0.09]
    (tmp_path / "broken.xlsx").write_bytes((tmp_path / "points.xlsx").read_bytes()[:500])
    with pytest.raises(ConfigError, match=r"broken\.xlsx: an Excel workbook that cannot be read"):
        read_materials(tmp_path / "broken.xlsx", CURVE_COLUMNS)


def test_a_column_of_names_tells_materials_apart(tmp_path):
    text = "Material,speed [mm/s],COF\nfelt,1,0.4\noil,1,0.1\nfelt,2,0.3\n"
    found = read_materials(write(tmp_path, text), CURVE_COLUMNS)
    assert {name: points["mu"].tolist() for name, points in found.items()} == {"felt": [0.4, 0.3], "oil": [0.1]}


def test_columns_are_what_people_say_they_are(tmp_path):
    text = "Motor 1 [mm/s];Signal A;Signal B;speed [m/s]\n1;5;0,4;7\n2;6;0,3;8\n"
    wanted = Wanted(speed="motor 1", friction=("Signal B",))
    ((name, points),) = read_materials(write(tmp_path, text), CURVE_COLUMNS, wanted).items()
    assert name == "Signal B" and points["speed"].tolist() == [0.001, 0.002] and points["mu"].tolist() == [0.4, 0.3]
    with pytest.raises(ConfigError, match="no column is called 'Signal C', expected 'Motor 1"):
        read_materials(write(tmp_path, text), CURVE_COLUMNS, Wanted(speed="motor 1", friction=("Signal C",)))


def test_a_record_with_time_and_speed_holds_a_curve_and_one_with_time_alone_ageing(tmp_path):
    rows = "".join(f"{t};{10 * t};{0.3 - t / 100:g}\n" for t in range(1, 7))
    (curve,) = fit_materials([write(tmp_path, "time [s];speed [mm/s];mu\n" + rows)])
    assert curve.curve is not None and curve.points.ignored == ("time [s]",)
    (ageing,) = fit_materials([write(tmp_path, "mu;t [min]\n" + "".join(f"{0.1 * t};{t}\n" for t in range(1, 7)))])
    assert ageing.ageing is not None and ageing.points["time"][0] == 60.0
    assert read_points(write(tmp_path, "hold time [s],static friction\n1,0.2\n"), AGEING_COLUMNS)["mu"].tolist() == [
        0.2
    ]


def test_files_of_one_name_are_told_apart_by_their_folders(tmp_path):
    from pathlib import Path

    assert names_of([Path("a/x.csv"), Path("b/x.csv"), Path("y.csv")]) == ["a/x", "b/x", "y"]
    assert names_of([Path("1/a/x.csv"), Path("2/a/x.csv")]) == ["1/a/x", "2/a/x"]
    assert names_of([Path("x.csv"), Path("x.csv"), Path("b/x.csv")]) == ["x", "x (2)", "b/x"]


@pytest.fixture
def points(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    speed = np.array([0.5, 1, 5, 20, 50, 100, 200, 400])
    for folder, a1 in (("a", 0.2), ("b", 0.1)):
        (tmp_path / folder).mkdir()
        mu = a1 + 0.2 * speed / 1000 + 0.1 * np.exp(-speed / 30)
        rows = "".join(f"{v:g}, {m:.6f}\n" for v, m in zip(speed, mu, strict=True))
        (tmp_path / folder / "x.csv").write_text("speed [mm/s], mu\n" + rows)
        (tmp_path / folder / "bare.csv").write_text("speed, mu\n" + rows)
    return tmp_path


def test_the_printed_yaml_is_a_configuration_of_the_fitted_curves(points):
    from stickslip.config.reader import parse_config

    rest = "system: {mass: 1, stiffness: 10, normal_load: 1, belt_speed: 0.1}\n"
    _, _, one = call("fit", "a/x.csv").stdout.partition("configuration\n")
    assert parse_config(one + rest).friction.a4 == pytest.approx(0.03, rel=1e-3)
    _, _, both = call("fit", "a/x.csv", "b/x.csv").stdout.partition("configuration\n")
    (axis,) = parse_config(both + rest).axes
    assert axis.labels == ("a/x", "b/x") and axis.members[0].values == pytest.approx((0.2, 0.1), rel=1e-3)


def test_points_curve_and_band_are_drawn(points):
    assert call("fit", "a/x.csv", "b/x.csv", "--plot", "fit.png").exit_code == 0
    assert (points / "fit.png").read_bytes().startswith(b"\x89PNG")
    wrong = call("fit", "a/x.csv", "--plot", "fit.docx")
    assert wrong.exit_code == 2 and "plots end in" in wrong.stderr


def test_the_tables_that_come_with_the_package_are_found_anywhere(points):
    done = call("fit", "configs/measured/dry.csv", "configs/measured/table.csv", "--json")
    assert [one["name"] for one in json.loads(done.stdout)["fits"]] == ["dry", "table: dry", "grease A", "grease B"]
    assert "taken from those that come with stickslip" in done.stderr
    alone, of_table = (one["coefficients"]["a1"] for one in json.loads(done.stdout)["fits"][:2])
    assert math.isclose(alone, of_table)


@pytest.mark.parametrize("title", ["", "Messung Fett 1\n\n", "Grease 1;;\nOperator: me;;\n"])
@pytest.mark.parametrize("word", ["Prüfgeschwindigkeit [mm/s]", "Sliding speed v (mm/s)", "mean velocity, mm/s"])
def test_titles_above_the_heading_are_skipped_and_longer_headings_understood(tmp_path, title, word):
    path = write(tmp_path, f"{title}{word};COF;Temp\n1;0,3;20\n2;0,29;20\n5;0,27;21\n")
    points = read_points(path, CURVE_COLUMNS)
    assert points["speed"].tolist() == [0.001, 0.002, 0.005] and points["mu"].tolist() == [0.3, 0.29, 0.27]


def test_a_speed_of_rotation_and_two_speeds_are_not_guessed_but_the_option_is_named(tmp_path):
    for heading in ("Drehgeschwindigkeit [rpm];COF", "Motor speed a;Motor speed b;COF"):
        cells = heading.count(";")
        rows = "\n".join(";".join([f"{i + 1}"] * cells + ["0,3"]) for i in range(4))
        with pytest.raises(ConfigError, match="--speed-column"):
            read_points(write(tmp_path, f"{heading}\n{rows}\n"), CURVE_COLUMNS)


def test_a_table_without_heading_loses_no_line(tmp_path):
    with pytest.raises(ConfigError, match="the first line names the columns"):
        read_points(write(tmp_path, "1;0.5\n2;0.4\n3;0.3\n"), CURVE_COLUMNS)


# --- columns that are no materials ------------------------------------------------------------------------------------

NO_MATERIAL = (
    "A std", "A sd", "A_sd", "A (SD)", "sd A", "s_A", "A ±", "±", "+-", "A +/-", "Stabw", "A Stabw", "Std.-Abw.",
    "s(mu)", "u(mu)", "SE", "A err", "err", "A Fehler", "écart-type", "A max", "A CI95", "A 2s", "FN", "Fn [N]",
    "F_N in N", "Normalkraft", "Last", "Load", "Prüflast", "charge (N)", "Temperature", "T [°C]", "Öltemperatur",
    "rel. Feuchte", "rH (%)", "humidity", "Drehmoment", "Torque [Nm]", "Verschleiß", "wear", "Weg", "Gleitstrecke",
    "distance", "Datum", "cycle", "Zyklen", "SRR", "R²", "log A", "ECR in Ohm", "film, µm",
)  # fmt: skip


@pytest.mark.parametrize("heading", NO_MATERIAL)
def test_a_column_of_something_else_is_no_material(heading, tmp_path):
    rows = "".join(f"{v};0,{40 - v};0,{v + 10};0,01{v}\n" for v in range(1, 7))
    found = read_materials(write(tmp_path, f"v [mm/s];A;B;{heading}\n{rows}"), CURVE_COLUMNS)
    assert list(found) == ["A", "B"] and found["A"]["mu"][0] == 0.39
    assert heading in (*found["A"].ignored, found["A"].read.get("sigma"))


def test_the_numbers_of_samples_and_points_are_no_materials_but_may_tell_them_apart(tmp_path):
    for heading in ("Nr", "n", "index", "sample", "Punkt", "Cycle no.", "ok"):
        rows = "".join(f"{i};{i};0,{40 - i};0,{i + 10}\n" for i in range(1, 7))
        assert list(read_materials(write(tmp_path, f"{heading};v [mm/s];A;B\n{rows}"), CURVE_COLUMNS)) == ["A", "B"]
    rows = "".join(f"{i % 3 + 1};{i};0,{40 - i}\n" for i in range(1, 10))
    assert sorted(read_materials(write(tmp_path, f"sample;v [mm/s];COF\n{rows}"), CURVE_COLUMNS)) == ["1", "2", "3"]


def test_a_standard_deviation_belongs_to_the_column_it_is_called_after(tmp_path):
    text = "v [mm/s];A;B;A std;B std\n" + "".join(f"{i};0,3;0,2;0,00{i};0,01\n" for i in range(1, 7))
    found = read_materials(write(tmp_path, text), CURVE_COLUMNS)
    assert found["A"]["sigma"][1] == 0.002 and found["B"]["sigma"][1] == 0.01
    several = read_materials(write(tmp_path, text.replace("A std;B std", "std;std")), CURVE_COLUMNS)
    assert "sigma" not in several["A"] and several["A"].ignored == ("std", "std")
    gap = read_materials(write(tmp_path, text.replace("0,004", "0")), CURVE_COLUMNS)
    assert "sigma" not in gap["A"] and gap["B"]["sigma"][0] == 0.01


def test_kinetic_friction_is_taken_over_speed_and_static_over_time_and_else_it_is_asked(tmp_path):
    rows = "".join(f"{i};0,{50 - i};0,{40 - i}\n" for i in range(1, 7))
    for heading in (
        "v [mm/s];mu_s;mu_k",
        "v [mm/s];µs;µd",
        "v [mm/s];Haftreibung;Gleitreibung",
        "v [mm/s];static COF;dynamic COF",
    ):
        (one,) = read_materials(write(tmp_path, f"{heading}\n{rows}"), CURVE_COLUMNS).values()
        assert one["mu"][0] == 0.39 and "static friction" in one.notes[0]
    (one,) = read_materials(write(tmp_path, f"Haltezeit [s];mu_s;mu_k\n{rows}"), AGEING_COLUMNS).values()
    assert one["mu"][0] == 0.49
    for heading in ("v [mm/s];mu;mu_k", "v [mm/s];mu_s;x"):
        with pytest.raises(ConfigError, match="--friction-column"):
            read_materials(write(tmp_path, f"{heading}\n{rows}"), CURVE_COLUMNS)
    (one,) = read_materials(
        write(tmp_path, f"v [mm/s];mu_s;x\n{rows}"), CURVE_COLUMNS, Wanted(friction=("mu_s",))
    ).values()
    assert one["mu"][0] == 0.49


@pytest.mark.parametrize(
    "heading", ["COF in %", "COF [%]", "mu (%)", "COF %", "Reibwert in Prozent", "COF, %", "mu\n%"]
)
def test_friction_in_percent_is_divided_by_a_hundred(heading, tmp_path):
    first, _, below = heading.partition("\n")
    head = f"v;{first}\nmm/s;{below}" if below else f"v [mm/s];{first}"
    points = read_points(write(tmp_path, f"{head}\n1;40,7\n2;35\n3;30\n"), CURVE_COLUMNS)
    assert points["mu"].tolist() == [0.407, 0.35, 0.3]


@pytest.mark.parametrize("text", ["COF\n1;35,5\n2;50\n", "COF [-]\n1;35,5\n2;50\n", "A;B\n1;35,5;0,3\n2;50;0,2\n"])
def test_friction_too_large_to_be_a_coefficient_is_refused(text, tmp_path):
    with pytest.raises(ConfigError, match="expected friction coefficients"):
        read_materials(write(tmp_path, f"v [mm/s];{text}"), CURVE_COLUMNS)
    rubber = read_points(write(tmp_path, "v [mm/s];COF [-]\n1;2,5\n2;2,1\n"), CURVE_COLUMNS)
    assert rubber["mu"][0] == 2.5


def test_friction_forces_are_divided_by_the_load_of_the_row_the_file_or_the_option_or_refused(tmp_path):
    rows = "1;4;10\n2;6;20\n3;2,5;10\n"
    by_row = read_points(write(tmp_path, f"v [mm/s];Reibkraft [N];FN [N]\n{rows}"), CURVE_COLUMNS)
    assert by_row["mu"].tolist() == [0.4, 0.3, 0.25]
    forces = "v [mm/s];FR [mN]\n1;400\n2;300\n"
    for above in ("Prüflast;2;N\n", "Load: 2 N\n", "# Normalkraft = 2 N\n", "Last [N];2\n", "Auflast;2000;mN\n"):
        assert read_points(write(tmp_path, above + forces), CURVE_COLUMNS)["mu"].tolist() == [0.2, 0.15]
    (one,) = read_materials(write(tmp_path, forces), CURVE_COLUMNS, Wanted(load="2 N")).values()
    assert one["mu"].tolist() == [0.2, 0.15] and "2 N (--load)" in one.notes[0]
    for above in ("", "Last;15\n", "Last;15;kg\n", "Last;1.500;N\n", "Last: 5 bis 15 N\n", "Last;2;N\nPrüflast;3;N\n"):
        with pytest.raises(ConfigError, match=r"load"):
            read_points(write(tmp_path, above + forces), CURVE_COLUMNS)
    for wrong in ("FR", "COF [N]", "FR [kg]", "Kraft [N]"):
        with pytest.raises(ConfigError):
            read_materials(write(tmp_path, f"v [mm/s];{wrong}\n1;4\n2;5\n"), CURVE_COLUMNS, Wanted(load=10.0))


def test_columns_of_one_name_are_repeats_unless_their_numbers_are_not_alike(tmp_path):
    text = "v [mm/s];A;A\n1;0,4;0,41\n2;0,3;0,31\n"
    assert read_materials(write(tmp_path, text), CURVE_COLUMNS)["A"]["mu"].tolist() == [0.4, 0.41, 0.3, 0.31]
    with pytest.raises(ConfigError, match="another name"):
        read_materials(write(tmp_path, "v [mm/s];A;A\n1;0,4;0,01\n2;0,3;0,01\n"), CURVE_COLUMNS)


def test_lines_above_the_header_are_left_out_and_said(points):
    text = "Protokoll 12\nPrüfer;Müller\nGeschwindigkeit;variabel\nPrüflast;15;N\n\n" + (
        points / "a" / "x.csv"
    ).read_text().replace(", ", ";")
    (points / "above.csv").write_text(text, "cp1252")
    done = call("fit", "above.csv")
    assert done.exit_code == 0 and "left out above the header: lines 1 to 4" in done.stdout
    named = text.replace("speed [mm/s];mu", "Motor 1 [mm/s];Signal B")
    (points / "named.csv").write_text(named, "cp1252")
    told = json.loads(
        call("fit", "named.csv", "--speed-column", "Motor 1", "--friction-column", "Signal B", "--json").stdout
    )
    assert told["fits"][0]["lines_above"] == [1, 4] and told["fits"][0]["points"] == 8
    with pytest.raises(ConfigError, match="above the heading"):
        read_points(write(points, "Einheit;mm/s\nv;mu\n1;0.3\n2;0.2\n"), CURVE_COLUMNS)


def test_compare_says_what_columns_were_taken_for(points):
    system = ("--mass", "100 g", "--stiffness", "5 N/mm", "--load", "10 N", "--damping", "1 N s/m", "--draws", "0")
    text = (
        (points / "a" / "x.csv")
        .read_text()
        .replace("mu\n", "mu, Temp\n")
        .replace("\n", ", 23\n")
        .replace("Temp, 23", "Temp")
    )
    (points / "warm.csv").write_text(text)
    done = call("compare", "warm.csv", *system)
    assert done.exit_code == 0 and "not used: 'Temp'" in done.stdout
    assert json.loads(call("compare", "warm.csv", *system, "--json").stdout)["read"]["warm"]["ignored"] == ["Temp"]
    assert call("fit", "a/x.csv", "--load", "10 m").exit_code == 2


def test_a_column_that_people_name_keeps_its_unit_and_a_capital_t_is_a_temperature(tmp_path):
    rows = "1;0,4;23\n2;0,3;23\n"
    for heading in ("Motor 1 [mm/s]", "Motor 1 mm/s", "Motor 1 in mm / s"):
        (one,) = read_materials(
            write(tmp_path, f"{heading};µ;T\n{rows}"), CURVE_COLUMNS, Wanted(speed=heading)
        ).values()
        assert one["speed"][0] == 0.001 and not one.assumed and one.ignored == ("T",)
    for wrong in ("Motor 1 (foo)", "Motor 1 [Mm/s]"):
        with pytest.raises(ConfigError, match="expected the unit of a speed"):
            read_materials(write(tmp_path, f"{wrong};µ;T\n{rows}"), CURVE_COLUMNS, Wanted(speed=wrong))
    with pytest.raises(ConfigError, match="no column is called speed"):
        fit_materials([write(tmp_path, f"vG in mm/s;µ;T\n{rows}")])
