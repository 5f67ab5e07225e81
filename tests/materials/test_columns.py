"""What columns are taken for, in fit, compare, points and records: nothing that is no friction coefficient is one."""

import json
import re

import numpy as np
import pytest

from helpers.commands import call
from helpers.data import cases
from helpers.tables import materials, rows, write
from stickslip.errors import ConfigError
from stickslip.files import texts
from stickslip_materials.fit import CURVE_COLUMNS, read_points, read_steps
from stickslip_rig.api import read_record

SPEED = np.array([1, 3, 10, 30, 100, 200.0])  # mm/s
MU = 0.2 + 0.12 * np.exp(-SPEED / 20) + 0.2 * SPEED / 1000


def table(head, *columns, mark=";"):
    return f"{head}\n{rows(*columns, mark=mark)}"


def record(noise=0.0, samples=60):
    """Time, speed, friction and load of a log at steps, two samples a second."""
    random = np.random.default_rng(1)
    speed = np.repeat(SPEED, samples)
    mu = np.repeat(MU, samples) + 0.002 * random.standard_normal(speed.size)
    return 0.5 * np.arange(speed.size), speed, mu, 10 * (1 + noise * random.standard_normal(speed.size))


def points_of(folder, text, *options):
    done = call("points", write(folder, text, "file.csv"), "-o", folder / "points.csv", *options)
    if done.exit_code:
        return done.output
    one = read_points(folder / "points.csv", CURVE_COLUMNS)
    assert one["speed"] * 1000 == pytest.approx(SPEED, rel=0.02) and one["mu"] == pytest.approx(MU, abs=0.004)
    return done.output


@cases("materials.yaml")
@pytest.mark.parametrize("noise", [0.0, 0.002, 0.01, 0.03])
def test_a_log_at_steps_becomes_its_points(head, letters, noise, tmp_path):
    """`letters` : columns of time, speed, friction, load that a log has besides others."""
    time, speed, mu, load = record(noise)
    columns = {"t": time, "v": speed, "m": mu, "f": 10 * mu, "n": load, "5": np.full(time.size, 25.0)}
    said = points_of(tmp_path, table(head, *(columns[letter] for letter in letters)))
    assert "6 points" in said and " is speed" in said and "friction" in said


def test_load_and_radius_are_taken_from_lines_above_and_an_option_must_agree(tmp_path):
    time, speed, mu, _ = record()
    turns = speed / 20 / (2 * np.pi) * 60
    text = "Stift-Scheibe;;\nNormalkraft;10;N\nReibradius;20;mm\n" + table("Zeit [s];Drehzahl [1/min];Reibkraft [N]",
                                                                          time, turns, 10 * mu)  # fmt: skip
    said = points_of(tmp_path, text)
    assert "line 2" in said and "line 3" in said
    assert "--radius" in points_of(tmp_path, text, "--radius", "30 mm")
    assert "--load" in points_of(tmp_path, text, "--load", "5 N")
    with pytest.raises(ConfigError, match=r"6 steps of 'Drehzahl \[1/min\]'"):
        materials(tmp_path, text)


@pytest.mark.filterwarnings("default")
def test_options_that_a_column_makes_useless_are_named(tmp_path):
    time, speed, mu, load = record()
    said = points_of(tmp_path, table("t [s];v [mm/s];F friction [N];load [N]", time, speed, 10 * mu, load),
                     "--load", "5 N", "--radius", "3 mm")  # fmt: skip
    assert "--load is not used" in said and "--radius is not used" in said
    forces = write(tmp_path, table("v [mm/s];Friction force [N];Load [N]", SPEED, 10 * MU, np.full(6, 10)))
    assert "--load is not used" in call("fit", forces, "--load", "5 N").output
    plain = write(tmp_path, table("v [mm/s];mu", SPEED, MU))
    said = call("fit", plain, "--load", "5 N", "--unit", "m/s", "--at", "5 min").output
    assert "--load is not used" in said and "--unit m/s is not used" in said and "--at is not used" in said


@cases("materials.yaml")
def test_what_is_open_is_refused_with_a_way_on(command, head, letters, words, tmp_path):
    time, speed, mu, load = record()
    columns = {"t": time, "v": speed, "m": mu, "p": 100 * mu, "n": load}
    path = write(tmp_path, table(head, *(columns[letter] for letter in letters)))
    done = call(command, path, *(["-o", tmp_path / "o.csv"] if command == "points" else []))
    assert done.exit_code == 2 and "hint:" in done.output
    assert re.search(words, done.output)


def fitted(path):
    done = call("fit", path, "--json")
    assert done.exit_code == 0, done.output
    return [one["coefficients"]["mu_start"] for one in json.loads(done.stdout)["fits"]]


SPEEDS = np.geomspace(1, 300, 12)
CURVE = 0.2 + 0.12 * np.exp(-SPEEDS / 20) + 0.2 * SPEEDS / 1000


@pytest.mark.parametrize(("head", "mark"), [
    ("# speed [mm/s];mu", ";"), ("# taken by hand\n# v [mm/s],COF", ","), ("speed[mm/s]    mu", "    "),
    ("speed [mm/s] mu", " "), ("  v (mm/s)   mu", "  "), ("# v [mm/s] mu", " "),
])  # fmt: skip
def test_remarks_name_columns_and_blanks_separate_them(head, mark, tmp_path):
    values = fitted(write(tmp_path, table(head, SPEEDS, CURVE, mark=mark), "file.txt"))
    assert values == pytest.approx([0.32], abs=1e-3)


@pytest.mark.parametrize("footer", [
    "\nMittelwert;67.6;0.1\nMaximum;300;0.3\nMinimum;1;0.2\n", "mean;50;0.1\nstd;2;0.1\n",
    "Average:;50;0.1\n", "Std. Dev.;50;0.1\nStabw;50;0.1\nMedian;3;0.2\n",
])  # fmt: skip
def test_rows_of_means_and_extremes_are_left_out_and_named(footer, tmp_path):
    text = table("No.;speed [mm/s];mu", np.arange(12), SPEEDS, CURVE) + footer
    path = write(tmp_path, text)
    assert fitted(path) == pytest.approx([0.32], abs=1e-3)
    assert footer.strip().split(";")[0] in call("fit", path).stdout


def test_a_column_that_tells_very_different_parts_apart_is_asked_about(tmp_path):
    speed, warm = np.tile(SPEEDS, 2), np.repeat([23.0, 80.0], 12)
    text = table("Nr.;v [mm/s];mu;Temperatur [°C]", np.arange(24), speed, np.append(CURVE, CURVE / 2), warm)
    with pytest.raises(ConfigError, match=r"Temperatur \[°C\].*23 and 80.*factor of 2"):
        materials(tmp_path, text)
    alike = table("v [mm/s];mu;Temperatur [°C]", speed, np.append(CURVE, 1.02 * CURVE), warm)
    assert len(materials(tmp_path, alike)) == 1


def test_sheets_are_materials_and_hidden_ones_and_notes_are_none(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = "Info"
    book.active.append(["Operator", "me"])
    for title, factor in (("old", 0.5), ("oil A", 1.0), ("oil B", 1.5)):
        sheet = book.create_sheet(title)
        sheet.append(["speed [mm/s]", "mu"])
        for row in zip(SPEEDS, factor * CURVE, strict=True):
            sheet.append([float(value) for value in row])
    book["old"].sheet_state = "hidden"
    book.save(tmp_path / "both.xlsx")
    values = fitted(tmp_path / "both.xlsx")
    assert values == pytest.approx([0.32, 0.48], abs=2e-3)
    assert "sheets not read: 'Info'" in call("fit", tmp_path / "both.xlsx").stdout


def blocks(mark, above="Step No. {}\n\n", load=-10 / 0.00980665, top="Data Viewer export\n\n"):
    """A file as a tribometer exports it, a block for each of six speeds; forces in grams-force, the load negative."""
    head = mark.join(["T", "V", "Fn", "Ff"]) + "\n" + mark.join(["sec", "mm/s", "g", "g"]) + "\n\n"
    time, ones, noise = 0.5 * np.arange(60), np.ones(60), 1 + 0.002 * np.random.default_rng(1).standard_normal(60)
    each = [above.format(i) + head + rows(time, v * ones, load * ones, -mu * load * noise, mark=mark)
            for i, (v, mu) in enumerate(zip(SPEED, MU, strict=True), 1)]  # fmt: skip
    return top + "\n".join(each)


GRAMS = pytest.mark.filterwarnings("always:.*grams-force")


@GRAMS
@pytest.mark.parametrize("mark", [",", ";", "\t"])
@pytest.mark.parametrize("above", ["Step No. {}\nSet Force = -200\n\n", "Step{0};{0};;\n", ""])
@pytest.mark.parametrize("is_long", [False, True])
def test_each_block_below_the_names_of_columns_is_a_step(mark, above, is_long, tmp_path, monkeypatch):
    if is_long:
        monkeypatch.setattr(texts, "_BEGINNING", 300)
    said = points_of(tmp_path, blocks(mark, above))
    assert "6 blocks" in said and "6 points" in said and "grams-force" in said


@GRAMS
def test_a_speed_above_each_block_is_that_of_the_block(tmp_path):
    time = 0.5 * np.arange(60)
    block = "Velocity = {:g} mm/s\n" + table("T [s];COF", time, np.full(60, 0.3))
    path = write(tmp_path, "\n".join(block.format(v) for v in SPEED))
    assert read_steps(path).speed * 1000 == pytest.approx(SPEED)
    with pytest.raises(ConfigError, match="--speed-column") as refused:  # a speed of what?
        read_steps(write(tmp_path, block.format(3.0).replace(" mm/s", "")))
    assert refused.value.problems[0].place.line == 1


@GRAMS
@pytest.mark.parametrize(("cut", "line"), [
    (lambda text: text[:-12], 397), (lambda text: text.replace("\n29.5;1;", "\n1;", 1), 67),
    (lambda text: text + "\nT;V;Fn\nsec;mm/s;g\n0;1;2\n", 399),
])  # fmt: skip
def test_a_block_that_is_cut_short_or_has_other_columns_is_refused_by_its_line(cut, line, tmp_path):
    with pytest.raises(ConfigError) as refused:
        read_steps(write(tmp_path, cut(blocks(";"))))
    assert refused.value.problems[0].place.line == line


@GRAMS
def test_a_load_that_changes_its_sign_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="with all values above 0"):
        read_steps(write(tmp_path, blocks(";", load=1000 * (-1.0) ** np.arange(60))))


def test_tables_that_are_no_records_have_one_heading(tmp_path):
    part = table("v [mm/s];mu", SPEED, MU)
    with pytest.raises(ConfigError, match="names of the columns come again") as refused:
        materials(tmp_path, f"Step 1\n{part}\nStep 2\n{part}")
    assert [problem.place.line for problem in refused.value.problems] == [11]


def test_friction_without_a_unit_is_no_force_of_a_record(tmp_path):
    text = table("time [s];Friction;a [m/s2]", np.arange(20), np.ones(20), np.ones(20))
    with pytest.raises(ConfigError, match="force or coefficient"):
        read_record(write(tmp_path, text))
