"""Tables of measured points as people, instruments and Excel write them are read to the same numbers."""

import json
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from helpers.commands import call
from helpers.data import cases, rows
from helpers.tables import materials, points, write
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError
from stickslip_materials.fit import AGEING_COLUMNS, CURVE_COLUMNS, fit_materials, read_materials, read_points
from stickslip_materials.fit.files import names_of

# --- materials of a table ---------------------------------------------------------------------------------------------

SIX = "".join(f"{i};0,{40 - i};0,{i + 10};0,01{i}\n" for i in range(1, 7))


@cases("materials.yaml")
def test_a_table_of_several_materials_holds_the_points_of_each(text, expected, tmp_path):
    """`expected` : speeds in mm/s and friction by material."""
    read = materials(tmp_path, text)
    assert {key: (one["speed"].tolist(), one["mu"].tolist()) for key, one in read.items()} == {
        key: ([v / 1000 for v in speeds], mu) for key, (speeds, mu) in expected.items()
    }
    if len(expected) > 1:
        with pytest.raises(ConfigError, match="got 2 materials .*, expected one"):
            read_points(tmp_path / "points.csv", CURVE_COLUMNS)


def test_a_workbook_is_read_from_the_sheet_that_holds_points(tmp_path):
    pytest.importorskip("openpyxl")
    table = pd.DataFrame(
        {"v [mm/s]": [0.5, 1, 20], "dry": [0.41, 0.4, 0.3], "oil; new": [0.1, None, 0.09], "note": "x"}
    )
    with pd.ExcelWriter(tmp_path / "points.xlsx") as writer:
        table.to_excel(writer, index=False)
        pd.DataFrame({"speed": [1]}).to_excel(writer, sheet_name="other", index=False)
    read = read_materials(tmp_path / "points.xlsx", CURVE_COLUMNS)
    assert list(read) == ["dry", "oil; new"] and read["dry"]["speed"].tolist() == [0.0005, 0.001, 0.02]
    assert read["oil; new"]["mu"].tolist() == [0.1, 0.09]
    (tmp_path / "broken.xlsx").write_bytes((tmp_path / "points.xlsx").read_bytes()[:500])
    with pytest.raises(ConfigError, match=r"broken\.xlsx: an Excel workbook that cannot be read"):
        read_materials(tmp_path / "broken.xlsx", CURVE_COLUMNS)


NO_MATERIAL = rows("materials.yaml")["test_tables"]["NO_MATERIAL"]
COUNTS = ("Nr", "n", "index", "sample", "Punkt", "Cycle no.", "ok")


@pytest.mark.parametrize("heading", [*NO_MATERIAL, *COUNTS])
def test_a_column_of_something_else_is_no_material(heading, tmp_path):
    text = SIX
    if heading in COUNTS:
        text = "".join(f"{line.rpartition(';')[0]};{i}\n" for i, line in enumerate(SIX.splitlines(), 1))
    read = materials(tmp_path, f"v [mm/s];A;B;{heading}\n{text}")
    assert list(read) == ["A", "B"] and read["A"]["mu"][0] == 0.39
    assert heading in (*read["A"].ignored, read["A"].read.get("sigma"))


def test_a_standard_deviation_belongs_to_the_column_it_is_called_after(tmp_path):
    text = "v [mm/s];A;B;A std;B std\n" + "".join(f"{i};0,3;0,2;0,00{i};0,01\n" for i in range(1, 7))
    read = materials(tmp_path, text)
    assert read["A"]["sigma"][1] == 0.002 and read["B"]["sigma"][1] == 0.01
    several = materials(tmp_path, text.replace("A std;B std", "std;std"))
    assert "sigma" not in several["A"] and several["A"].ignored == ("std", "std")
    gap = materials(tmp_path, text.replace("0,004", "0"))
    assert "sigma" not in gap["A"] and gap["B"]["sigma"][0] == 0.01


# --- columns of friction, speed and load ------------------------------------------------------------------------------

FORCES = "v [mm/s];FR [mN]\n1;400\n2;300\n"
PERCENT = "1;40,7\n2;35\n"
READ = rows("materials.yaml")["test_tables"]["READ"]


@pytest.mark.parametrize("name", READ)
def test_friction_is_read_as_a_coefficient_over_speed(name, tmp_path):
    text, wanted, expected = READ[name]
    one = points(tmp_path, text, **wanted)
    assert one["mu"].tolist() == expected and one["speed"].tolist() == [0.001, 0.002] and not one.assumed
    if "kinetic" in name or "load" in name:
        assert one.notes


@cases("materials.yaml")
def test_what_may_be_friction_or_something_else_is_refused(text, wanted, said, tmp_path):
    with pytest.raises(ConfigError, match=said):
        materials(tmp_path, text, **wanted)


def test_a_table_with_time_and_speed_holds_a_curve_and_one_with_time_alone_ageing(tmp_path):
    rows = "".join(f"{t};{10 * t};{0.3 - t / 100:g}\n" for t in range(1, 7))
    (curve,) = fit_materials([write(tmp_path, "time [s];speed [mm/s];mu\n" + rows)])
    assert curve.curve is not None and curve.points.ignored == ("time [s]",)
    (ageing,) = fit_materials([write(tmp_path, "mu;t [min]\n" + "".join(f"{0.1 * t};{t}\n" for t in range(1, 7)))])
    assert ageing.ageing is not None and ageing.points["time"][0] == 60.0
    for head in ("hold time [s];static friction", "Haltezeit [s];mu_s"):
        assert points(tmp_path, f"{head};mu_k\n1;0.2;0.1\n", AGEING_COLUMNS)["mu"].tolist() == [0.2]


# --- files and commands -----------------------------------------------------------------------------------------------


def test_files_of_one_name_are_told_apart_by_their_folders():
    assert names_of([Path("a/x.csv"), Path("b/x.csv"), Path("y.csv")]) == ["a/x", "b/x", "y"]
    assert names_of([Path("1/a/x.csv"), Path("2/a/x.csv")]) == ["1/a/x", "2/a/x"]
    assert names_of([Path("x.csv"), Path("x.csv"), Path("b/x.csv")]) == ["x", "x (2)", "b/x"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    speed = np.array([0.5, 1, 5, 20, 50, 100, 200, 400])
    for name, a1 in (("a", 0.2), ("b", 0.1)):
        (tmp_path / name).mkdir()
        mu = a1 + 0.2 * speed / 1000 + 0.1 * np.exp(-speed / 30)
        rows = "".join(f"{v:g}, {m:.6f}\n" for v, m in zip(speed, mu, strict=True))
        (tmp_path / name / "x.csv").write_text("speed [mm/s], mu\n" + rows)
    return tmp_path


def test_the_printed_yaml_is_a_configuration_of_the_fitted_curves(folder):
    rest = "system: {mass: 1, stiffness: 10, normal_load: 1, belt_speed: 0.1}\n"
    _, _, one = call("fit", "a/x.csv").stdout.partition("configuration\n")
    assert parse_config(one + rest).friction.a4 == pytest.approx(0.03, rel=1e-3)
    _, _, both = call("fit", "a/x.csv", "b/x.csv").stdout.partition("configuration\n")
    (axis,) = parse_config(both + rest).axes
    assert axis.labels == ("a/x", "b/x") and axis.members[0].values == pytest.approx((0.2, 0.1), rel=1e-3)


def test_points_curve_and_band_are_drawn(folder):
    assert call("fit", "a/x.csv", "b/x.csv", "--plot", "fit.png").exit_code == 0
    assert (folder / "fit.png").read_bytes().startswith(b"\x89PNG")
    wrong = call("fit", "a/x.csv", "--plot", "fit.docx")
    assert wrong.exit_code == 2 and "plots end in" in wrong.stderr


def test_the_tables_that_come_with_the_package_are_found_anywhere(folder):
    done = call("fit", "configs/measured/dry.csv", "configs/measured/table.csv", "--json")
    assert [one["name"] for one in json.loads(done.stdout)["fits"]] == ["dry", "table: dry", "grease A", "grease B"]
    assert "taken from those that come with stickslip" in done.stderr
    alone, of_table = (one["coefficients"]["a1"] for one in json.loads(done.stdout)["fits"][:2])
    assert math.isclose(alone, of_table)


def test_fit_and_compare_say_what_columns_were_taken_for(folder):
    text = (folder / "a" / "x.csv").read_text().replace(", ", ";").replace("mu\n", "mu;Temp\n")
    text = text.replace("\n", ";23\n").replace("Temp;23", "Temp")
    above = "Protokoll 12\nPrüfer;Müller\nGeschwindigkeit;variabel\nPrüflast;15;N\n\n"
    write(folder, above + text.replace("speed [mm/s];mu", "Motor 1 [mm/s];Signal B"), "named.csv", "cp1252")
    options = ("--speed-column", "Motor 1", "--friction-column", "Signal B")
    said = call("fit", "named.csv", *options).stdout
    assert "left out above the header: lines 1 to 4" in said and "not used: 'Temp'" in said
    (told,) = json.loads(call("fit", "named.csv", *options, "--json").stdout)["fits"]
    assert told["lines_above"] == [1, 4] and told["points"] == 8 and told["ignored"] == ["Temp"]
    system = ("--mass", "100 g", "--stiffness", "5 N/mm", "--load", "10 N", "--damping", "1 N s/m", "--draws", "0")
    done = call("compare", "named.csv", *options, *system, "--json")
    assert done.exit_code == 0
    assert json.loads(done.stdout)["read"]["Signal B"]["ignored"] == ["Temp"]
    assert call("fit", "a/x.csv", "--load", "10 m").exit_code == 2
