"""CSV files of rigs, good and bad, and the configuration that says how to read them."""

import json

import numpy as np
import pytest

from helpers.commands import invoke
from helpers.data import cases
from stickslip.errors import ConfigError
from stickslip_rig.api import (
    FeatureSettings,
    RecordSettings,
    Settings,
    load_settings,
    make_record,
    read_record,
    read_records,
)  # fmt: skip
from stickslip_rig.records import force_of

GOOD = "time [ms], force [N], acceleration [m/s2]"
ROWS = [f"{t}, {0.1 * t}, {0.01 * t}" for t in range(20)]


def write(folder, heading=GOOD, rows=ROWS, name="felt.csv"):
    path = folder / name
    path.write_text("\n".join([heading, *rows]) + "\n", encoding="utf-8")
    return path


def complaint(call, *args):
    with pytest.raises(ConfigError) as caught:
        call(*args)
    return str(caught.value)


# --- good files -------------------------------------------------------------------------------------------------------


def test_units_are_those_of_the_header_and_conditions_those_of_the_remarks(tmp_path):
    heading = (
        "# material: felt on PC-ABS\n# load = 10 N\n# measured on a Tuesday\n\n"
        "Acceleration (mm/s²), Time [ms], Drive speed [mm/s], Force [kN]"
    )
    rows = [f"{1000 * a}, {t}, 10, 0.002" for t, a in zip(range(20), np.linspace(0, 1, 20), strict=True)]
    found = read_record(write(tmp_path, heading, rows))
    assert found["time"].values == pytest.approx(np.arange(20) * 1e-3)
    assert found["acceleration"].values == pytest.approx(np.linspace(0, 1, 20))
    assert found["spring_force"].values == pytest.approx(np.full(20, 2.0))
    assert found["drive_velocity"].values == pytest.approx(np.full(20, 0.01))
    assert str(found["material"].values) == "felt on PC-ABS" and float(found["normal_load"]) == 10.0
    assert found["acceleration"].attrs["units"] == "m s-2"


def test_a_configuration_names_columns_units_and_conditions(tmp_path):
    config = tmp_path / "rig.yaml"
    config.write_text(
        "record: {columns: {time: Zeit, force: Kraft}, units: {time: ms}, ignore: [Temp]}\n"
        "conditions: {material: PVC, load: 20 N, drive_speed: 10 mm/s, waiting_time: 1 min}\n"
        "features: {bandwidth: 2 kHz, smallest_drop: 0.5 N, subtract_offset: true}\n"
        "risk: {weight_sticks: 1.5, scale_acceleration_max: 500 mm/s2}\n"
    )
    settings = load_settings(config)
    path = write(tmp_path, "Zeit, Kraft [N], Temp, a [m/s2]", [f"{t}, 1, warm, 0" for t in range(20)])
    found = read_record(path, settings.record, settings.conditions)
    assert found["time"].values[-1] == pytest.approx(0.019)
    assert float(found["normal_load"]) == 20.0 and float(found["waiting_time"]) == 60.0
    assert settings.features == FeatureSettings(bandwidth=2000.0, smallest_drop=0.5, subtract_offset=True)
    assert settings.risk.weight_sticks == 1.5 and settings.risk.scale_acceleration_max == 0.5
    config.write_text(settings.to_yaml())
    assert load_settings(config) == settings


def test_what_a_file_says_of_itself_outweighs_the_configuration(tmp_path):
    path = write(tmp_path, f"# load: 40 N\n{GOOD}")
    assert float(read_record(path, None, {"normal_load": 10.0})["normal_load"]) == 40.0
    assert str(read_record(path)["material"].values) == "felt"  # the name of the file


def test_the_force_of_the_spring_comes_from_friction_and_mass():
    time, friction, acceleration = np.arange(20.0), np.full(20, 3.0), np.full(20, 2.0)
    signals = {"friction_force": friction, "acceleration": acceleration}
    assert force_of(make_record(time, signals, {})).tolist() == friction.tolist()
    assert force_of(make_record(time, signals, {"mass": 0.5})).tolist() == [2.0] * 20


# --- bad files --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "heading, rows, expected",
    [
        (GOOD, [*ROWS, "20, x, 0"], "felt.csv:22:5: force [N]: got 'x', expected a number"),
        (GOOD, [*ROWS, "20, nan, 0"], "a signal has no gaps"),
        (GOOD, [*ROWS, "20, 1"], "felt.csv:22:5: got 2 values, expected 3, one for each column (commas separate them)"),
        (GOOD, ["0,0, 0,1, 0,2", *ROWS], "so write decimal points"),
        (GOOD, ["ms, N, m/s2", *ROWS], "units go in brackets after the names"),
        (GOOD, [*ROWS[:18], ROWS[3]], "felt.csv:20:1: time [ms]: got 0.003 s after 0.017 s, expected time to increase"),
        (GOOD, ROWS[:5], "5 samples, expected at least 16"),
        (GOOD, [], "no samples, only the names of columns"),
        (
            "time [N], force, a",
            ROWS,
            "felt.csv:1:1: got 'time [N]', expected the unit of a time\n  hint: N is a unit of force",
        ),
        ("time, force, a [kg]", ROWS, "expected the unit of an acceleration\n  hint: kg is a unit of mass"),
        ("time, forze, a", ROWS, "felt.csv:1:7: got 'forze', expected time, force"),
        ("time, forze, a", ROWS, "did you mean 'force'?"),
        ("time, force, force", ROWS, "felt.csv:1:14: got 'force', expected it once"),
        ("time, a", [row.rpartition(",")[0] for row in ROWS], "no column is called force"),
        ("a, drive speed", ROWS, "no column is called time and force"),
        ("# materiel: felt\n" + GOOD, ROWS, "did you mean 'material'?"),
        ("# load: 10\xa0kN/m\n" + GOOD, ROWS, "felt.csv:1:3: got"),
        ("# load: -3 N\n" + GOOD, ROWS, "expected a force above 0 N"),
    ],
)
def test_what_is_wrong_is_said_with_line_and_column(tmp_path, heading, rows, expected):
    said = complaint(read_record, write(tmp_path, heading, rows))
    assert expected in said, said


def test_units_in_two_places_must_agree(tmp_path):
    said = complaint(read_record, write(tmp_path), RecordSettings(units={"time": "s"}))
    assert "expected the unit s, as the configuration says" in said


@cases("rig.yaml")
def test_a_wrong_configuration_is_refused_with_its_place(tmp_path, text, expected):
    path = tmp_path / "rig.yaml"
    path.write_text(text)
    assert expected in complaint(load_settings, path)


@pytest.mark.parametrize(
    "time, signals, expected",
    [
        (np.arange(20.0)[::-1], {}, "increase"),
        (np.arange(5.0), {}, "at least 16"),
        (np.arange(20.0), {"acceleration": np.zeros(19)}, "acceleration: expected 20 finite numbers"),
        (np.arange(20.0), {"acceleration": np.full(20, np.nan)}, "acceleration: expected 20 finite numbers"),
        (np.arange(20.0), {"spring_force": None}, "no force"),
    ],
)
def test_arrays_that_are_no_record_are_refused(time, signals, expected):
    given_ = {"spring_force": np.zeros(20), "acceleration": np.zeros(20)} | signals
    with pytest.raises(ValueError, match=expected):
        make_record(time, {name: values for name, values in given_.items() if values is not None}, {})


# --- headings of other programs ---------------------------------------------------------------------------------------


def test_records_of_german_and_of_our_headings_are_one_table(tmp_path):
    from stickslip_rig.api import feature_table
    from stickslip_rig.records import write_record

    rows = [f"{t};{0.1 * t:.2f};{t % 5};{10};23".replace(".", ",") for t in range(40)]
    heading = (
        "Prüfstand;SSP\nPrüflast;15;N\n\nZeit [ms];Kraft [N];Beschleunigung [mm/s²];Geschwindigkeit [mm/s];Temp [°C]"
    )
    measured = read_record(write(tmp_path, heading, rows))
    assert float(measured["normal_load"]) == 15.0 and measured.attrs["not_used"] == ["Temp [°C]"]
    assert measured["drive_velocity"].values[0] == 0.01 and measured["acceleration"].values[4] == 0.004
    write_record(measured, tmp_path / "ours.csv")
    again = read_record(tmp_path / "ours.csv")
    for name in measured.data_vars:
        np.testing.assert_allclose(again[name], measured[name], rtol=1e-8)
    assert feature_table({"a": measured, "b": again}, Settings()).sizes["record"] == 2


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252", "latin-1"])
def test_the_encoding_does_not_matter(tmp_path, encoding):
    path = tmp_path / "felt.csv"
    rows = [f"{t};1;{t / 2:g};".replace(".", ",") for t in range(20)]  # with the empty cell of a spreadsheet
    path.write_bytes("\r\n".join(["sep=;", "Time [ms];Force [N];a [m/s²];", *rows]).encode(encoding))
    found = read_record(path)
    assert found["acceleration"].values.tolist() == [t / 2 for t in range(20)]


@cases("rig.yaml")
def test_headings_of_three_languages(tmp_path, heading, names):
    found = read_record(write(tmp_path, heading, [f"{t};{t};{t};1" for t in range(20)]))
    assert list(found.data_vars) == names


# --- blocks -----------------------------------------------------------------------------------------------------------

HEAD = "T;Ff;Normal force;a\nms;N;N;m/s2\n\n"


def block(load, rows=20):
    return HEAD + "".join(f"{t};{(-1) ** t};{-load};{t % 3}\n" for t in range(rows))


def test_each_block_is_a_record_with_its_load_and_what_the_top_of_the_file_says(tmp_path):
    path = tmp_path / "strokes.csv"
    path.write_text(f"# mass: 100 g\nRig 7\n\nStep 3\n{block(10)}\nStep 4\n{block(20)}")
    first, second = read_records(path)
    assert [float(record["normal_load"]) for record in (first, second)] == [10.0, 20.0]
    assert [str(record["material"].values) for record in (first, second)] == ["strokes, Step 3", "strokes, Step 4"]
    assert float(first["mass"]) == float(second["mass"]) == 0.1
    assert second["time"].values[0] == 0.0 and second["friction_force"].values.tolist() == [1.0, -1.0] * 10
    with pytest.raises(ConfigError, match="come again") as refused:
        read_record(path)
    assert refused.value.problems[0].place.line == 30


def test_commands_take_each_block_and_say_which_load_holds(tmp_path):
    path = tmp_path / "strokes.csv"
    path.write_text(block(10) + block(20) + block(20))
    done = invoke("rig", "features", path, "--load", "20 N", "--speed", "1 mm/s", "--json")
    answer = json.loads(done.stdout)["records"]
    assert [row["normal_load"] for row in answer] == [10.0, 20.0, 20.0]
    assert {row["file"] for row in answer} == {str(path)} and "10 N holds, not the 20 N" in done.stderr
    done = invoke("rig", "friction", path, "--stiffness", "5 N/mm", "--mass", "1 g", "--speed", "1 mm/s", "--json")
    assert [row["record"] for row in json.loads(done.stdout)["records"]] == [f"strokes, step {i}" for i in (1, 2, 3)]


@pytest.mark.parametrize(("second", "line"), [(block(20)[:-4], 46), (block(20, 5), None), (HEAD, 24)])
def test_a_block_that_is_no_record_is_refused_by_its_line(second, line, tmp_path):
    path = tmp_path / "strokes.csv"
    path.write_text(block(10) + second)
    with pytest.raises(ConfigError) as refused:
        read_records(path)
    place = refused.value.problems[0].place
    assert place is None if line is None else place.line == line


def test_a_speed_above_a_block_needs_its_unit_or_an_option(tmp_path):
    path = tmp_path / "strokes.csv"
    path.write_text(f"Velocity = 240\n{block(10)}Velocity = 120\n{block(20)}")
    with pytest.raises(ConfigError, match="give --speed"):
        read_records(path)
    assert [float(each["drive_speed"]) for each in read_records(path, None, {"drive_speed": 0.01})] == [0.01, 0.01]
    path.write_text(f"Velocity = 240 mm/s\n{block(10)}Velocity = 120 mm/s\n{block(20)}")
    assert [float(each["drive_speed"]) for each in read_records(path)] == [0.24, 0.12]


def test_a_normal_force_that_changes_its_sign_is_no_load(tmp_path):
    path = write(tmp_path, "t [s];F [N];FN [N]", [f"{t};1;{10 * (-1) ** t}" for t in range(20)])
    with pytest.raises(ConfigError, match="goes from -10 to 10 N"):
        read_record(path)


def test_a_column_may_be_named_the_load(tmp_path):
    path = write(tmp_path, "time [ms];Fx [N];Fz [kN]", [f"{t};1;-0.02" for t in range(20)])
    record = read_record(path, RecordSettings({"spring_force": "Fx", "normal_load": "Fz"}))
    assert float(record["normal_load"]) == 20.0
