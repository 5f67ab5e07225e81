"""`stickslip rig`, `rig features` and `rig calibrate`: from files to tables, plots and records."""

import json

import numpy as np
import pandas as pd
import pytest

from helpers.commands import call, completed, invoke
from helpers.data import cases, rows
from helpers.rig_signals import record, saw_tooth, times
from stickslip.files import reading
from stickslip_rig.api import RPN_NAME, RigTests, Risk, features, load_rig, load_settings, read_record
from stickslip_rig.plots import plot_records
from stickslip_rig.risk import INPUTS
from stickslip_rig.sections import sections_of

TEXT = rows("rig.yaml")["test_commands"]["TEXT"]


@pytest.fixture
def config(tmp_path):
    path = tmp_path / "rig.yaml"
    path.write_text(TEXT)
    return path


def test_a_matrix_becomes_a_table_a_file_and_a_plot(tmp_path, config):
    output, plot = tmp_path / "matrix.nc", tmp_path / "signals.png"
    done = invoke("rig", config, "-o", output, "--plot", plot)
    assert done.exit_code == 0, done.output
    assert done.output.startswith("Three loads\n3 tests: normal_load (3)\n")
    assert RPN_NAME in done.output and "2000 N" in done.output and "warning" not in done.output
    assert plot.stat().st_size > 10_000
    with reading.open(output) as found:
        assert found["normal_load"].values.tolist() == [5.0, 10.0, 2000.0]
        assert found["sticks_exact"].values[2] == 1 and (found["model_rpn"] >= 1).all()
        assert found.attrs["history"].endswith(": run") and "stroke: 0.004" in found.attrs["configuration"]


def test_chosen_tests_are_drawn_in_a_window(tmp_path, config):
    for name, more in (("over.png", []), ("start.png", ["--from", "0", "--to", "0.2 s"])):
        done = invoke("rig", config, "--plot", tmp_path / name, "--test", 0, "--test", 2, *more)
        assert done.exit_code == 0 and (tmp_path / name).stat().st_size > 10_000, done.output


def test_records_read_back_with_the_features_of_the_matrix(tmp_path, config):
    """To the nine digits of the files."""
    folder, output = tmp_path / "new" / "signals", tmp_path / "read.nc"
    done = invoke("rig", config, "--records", folder)
    assert done.exit_code == 0, done.output
    files = sorted(folder.iterdir())
    assert [file.name for file in files] == ["test0.csv", "test1.csv", "test2.csv"]
    assert invoke("rig", "features", *files, "--bandwidth", "200 Hz", "-o", output).exit_code == 0
    made = load_rig(config)
    for test, file in zip(RigTests(made).tests(range(3)), files, strict=True):
        expected = features(test.record, sections_of(made).features)
        record = read_record(file)
        assert set(record.coords) == set(test.record.coords)
        found = features(record, sections_of(made).features)
        for name in expected.data_vars:
            assert found[name].values == pytest.approx(expected[name].values, rel=1e-6, nan_ok=True), name
    with reading.open(output) as table:
        assert table["normal_load"].values.tolist() == [5.0, 10.0, 2000.0]
        assert np.isfinite(table["acceleration_max_limited"]).all()


def test_of_a_large_matrix_the_first_rows_are_shown_and_the_rest_counted(config):
    config.write_text(TEXT.replace("[5 N, 10 N, 2 kN]", "{start: 5, stop: 10, num: 62}"))
    done = invoke("rig", config, "--plot", config.with_suffix(".png"), "-o", config.with_suffix(".csv"))
    assert done.exit_code == 0 and "... and 2 more" in done.output
    assert config.with_suffix(".png").stat().st_size > 10_000  # a heat map
    assert len(config.with_suffix(".csv").read_text().splitlines()) == 1 + 62


def test_an_interrupted_matrix_is_resumed_by_the_same_command(tmp_path, config, monkeypatch):
    evaluated = []

    def interrupted(record, settings):
        evaluated.append(features(record, settings))
        if len(evaluated) == 2:
            raise KeyboardInterrupt
        return evaluated[-1]

    config.write_text(TEXT + "execution: {threads: 1}\n")
    monkeypatch.setattr("stickslip_rig.simulation.features", interrupted)
    done = invoke("rig", config, "-o", tmp_path / "matrix.nc")
    assert done.exit_code == 1 and "1 of 3 tests" in done.output and not (tmp_path / "matrix.nc").exists()
    done = invoke("rig", config, "-o", tmp_path / "matrix.nc")
    assert done.exit_code == 0 and len(evaluated) == 4, done.output
    assert not (tmp_path / "matrix.nc.parts").exists()
    assert "is complete already" in invoke("rig", config, "-o", tmp_path / "matrix.nc").output and len(evaluated) == 4


def test_shards_of_a_matrix_are_collected_into_the_file_of_an_undivided_run(tmp_path, config):
    whole, parts = tmp_path / "whole.nc", tmp_path / "parts.nc"
    assert invoke("rig", config, "-o", whole).exit_code == 0
    for shard in ("1/2", "2/2"):
        done = invoke("rig", "run", config, "-o", parts, "--shard", shard)
        assert done.exit_code == 0 and not parts.exists(), done.output
    assert "3 of 3" in invoke("status", f"{parts}.parts").output
    assert invoke("collect", f"{parts}.parts").exit_code == 0
    with reading.open(whole) as one, reading.open(parts) as other:
        assert one.drop_attrs(deep=False).identical(other.drop_attrs(deep=False))
    shown = invoke("inspect", parts)
    assert shown.exit_code == 0 and RPN_NAME in shown.output


def test_a_test_not_integrated_to_its_end_is_reported(tmp_path, config):
    config.write_text(TEXT + "solver: {max_steps: 20}\n")
    done = invoke("rig", config, "--records", tmp_path / "signals")
    assert done.exit_code == 0
    assert "warning: 2 not integrated to the end (5 N, 10 N): the step budget ran out" in done.stderr
    assert [file.name for file in (tmp_path / "signals").iterdir()] == ["test2.csv"]


@cases("rig.yaml")
def test_what_is_wrong_ends_with_exit_code_2_before_anything_is_computed(here, config, arguments, expected):
    (here / "file").write_text("")
    done = invoke("rig", config, *arguments)
    assert done.exit_code == 2
    assert expected in done.output
    assert "tests:" not in done.output and {p.name for p in here.iterdir()} == {"rig.yaml", "file"}


def write(path, size=1.0, drive=True):
    time = times(4.0, 1000)
    force = size * saw_tooth(time)
    acceleration = size * np.gradient(np.gradient(force, time), time) * 1e-4
    columns = [time, force, acceleration, *([np.full_like(time, 0.01)] if drive else [])]
    head = "time; force [N]; acceleration [m/s2]" + ("; drive speed" if drive else "")
    np.savetxt(path, np.column_stack(columns), delimiter=";", header=f"# load: 10 N\n{head}", comments="")
    return path


@pytest.fixture
def files(tmp_path):
    return [write(tmp_path / "dry.csv"), write(tmp_path / "felt.csv", 0.3, drive=False)]


def test_records_stand_in_one_table_one_file_and_one_plot(tmp_path, files):
    plot, output = tmp_path / "traces.png", tmp_path / "features.nc"
    done = invoke("rig", "features", *files, "--speed", "10 mm/s", "--plot", plot, "-o", output)
    assert done.exit_code == 0, done.output
    lines = done.output.splitlines()
    assert any(line.startswith("dry") for line in lines) and any(line.startswith("felt") for line in lines)
    assert RPN_NAME in done.output and "19" in done.output
    assert lines[0].split()[-2:] == ["mu_s", "mu_d"]
    assert plot.stat().st_size > 10_000
    with reading.open(output) as ds:
        assert ds["record"].values.tolist() == ["dry", "felt"]
        assert (ds["model_rpn"] >= 1).all()
        assert RPN_NAME in ds["model_rpn"].attrs["long_name"]
        assert ds["static_friction"].values == pytest.approx([0.5, 0.15], rel=0.01)
        assert "weight_sticks" in ds.attrs["configuration"] and "rig-features" in ds.attrs["history"]


@cases("rig.yaml")
def test_what_is_wrong_ends_with_exit_code_2(files, arguments, expected):
    done = invoke("rig", "features", files[0], *arguments)
    assert done.exit_code == 2
    assert expected in done.output


def test_the_same_file_twice_is_refused_and_the_same_name_is_not(tmp_path, files):
    assert "named twice" in invoke("rig", "features", files[0], files[0]).output
    (tmp_path / "other").mkdir()
    other = write(tmp_path / "other" / "dry.csv")
    done = invoke("rig", "features", files[0], other)
    assert done.exit_code == 0 and "other" in done.output


FEATURES = "sticks, acceleration_max [m/s2], acceleration_integral [m/s]"


def pairs_table(folder, row, count=6, heading=f"{FEATURES}, rpn", more=""):
    path = folder / "pairs.csv"
    path.write_text("\n".join([heading, *[row.replace("#", str(i)) for i in range(1, count + 1)]]) + more)
    return path


def test_calibrate_prints_a_configuration_and_keeps_its_remarks_apart(tmp_path):
    random = np.random.default_rng(8)
    features = 10 ** random.uniform([0, -1, -1.5], [2.7, 2.2, 2], (30, 3))
    truth = Risk(base=0.5, weight_sticks=0.8, weight_acceleration_max=1.7, weight_acceleration_integral=0.6)
    rpn = truth.number(dict(zip(INPUTS, features.T, strict=True)))
    rows = [f"\n{n:.6g}, {a:.6g}, {i:.6g}, {r}" for (n, a, i), r in zip(features, rpn, strict=True)]
    done = invoke("rig", "calibrate", pairs_table(tmp_path, "9, 9, 9,", 1, more="".join(rows)))
    assert done.exit_code == 0 and "30 pairs: leave-one-out error" in done.stdout
    config = tmp_path / "risk.yaml"
    config.write_text(done.stdout)
    assert load_settings(config).risk.weight_acceleration_max == pytest.approx(1.7, abs=0.3)
    assert "At least five pairs" in invoke("rig", "calibrate", "--help").stdout


@cases("rig.yaml")
def test_tables_that_are_no_pairs_are_refused(tmp_path, heading, row, expected):
    done = invoke("rig", "calibrate", pairs_table(tmp_path, row, heading=heading))
    assert done.exit_code == 2 and expected in done.stderr, done.stderr


# --- plots ------------------------------------------------------------------------------------------------------------


def two_records():
    time = times(3.0, 2000)
    return {
        name: record(time, size * saw_tooth(time), size * np.sin(300 * time)) for name, size in (("a", 1.0), ("b", 0.3))
    }


def test_zero_is_at_one_height_and_no_acceleration_is_cut_off():
    force, acceleration = plot_records(two_records(), numbers={"a": 7, "b": np.nan}).axes
    (low, high), (least, most) = force.get_ylim(), acceleration.get_ylim()
    assert low / high == pytest.approx(least / most)
    assert least <= -1.0 and most >= 1.0
    assert high >= 5.0
    assert [text.get_text() for text in force.figure.legends[0].get_texts()][:2] == ["a: 7", "b: ?"]


def test_nothing_is_drawn_across_a_gap():
    whole = two_records()["a"]
    part = whole.isel(time=(whole.time < 1.0) | (whole.time > 1.5))
    force, _ = plot_records({"a": part}).axes
    pieces = [line.get_xdata() for line in force.get_lines()]
    assert len(pieces) == 2 and pieces[0][-1] < 1.0 and pieces[1][0] > 1.5
    assert len(force.patches) == 1 and "no samples" in force.figure.legends[0].get_texts()[0].get_text()


def test_a_window_and_many_samples_keep_peaks():
    time = times(5.0, 20_000)
    spike = np.where(np.arange(time.size) == 70_001, 40.0, 0.0)
    records = {"a": record(time, np.ones_like(time), spike)}
    _, whole = plot_records(records).axes
    assert max(whole.get_lines()[0].get_ydata()) == 40.0
    force, _ = plot_records(records, window=(1.0, 2.0)).axes
    assert force.get_lines()[0].get_xdata()[[0, -1]] == pytest.approx([1.0, 2.0], abs=1e-2)


@pytest.mark.filterwarnings("always::stickslip.errors.UnitWarning")
def test_options_without_units_and_remarks_that_overrule_them_are_said_and_a_material_names_its_row(tmp_path):
    path = tmp_path / "bare.csv"
    write(path, drive=False)
    path.write_text("# material: felt\n" + path.read_text())
    result = invoke("rig", "features", path, "--load", "30 N", "--speed", "25")
    assert "drive_speed: 25 is read as 25 m/s; did you mean 25 mm/s?" in result.output
    assert "normal_load of 10 N holds, not the 30 N of the option" in result.output
    assert "felt" in result.stdout and "bare " not in result.stdout
    target = str(tmp_path / "f.nc")
    result = invoke("rig", "features", path, "--speed", "25 mm/s", "-o", target)
    assert result.exit_code == 0 and "of the option" not in result.output
    assert invoke("plot", target, "-o", tmp_path / "f.png").exit_code == 0


# --- features in tables -----------------------------------------------------------------------------------------------

MATRIX = rows("rig.yaml")["test_commands"]["MATRIX"]


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    """Six records and one with a gap."""
    folder = tmp_path_factory.mktemp("rated")
    (folder / "rig.yaml").write_text(MATRIX)
    assert invoke("rig", "run", folder / "rig.yaml", "--records", folder / "records").exit_code == 0
    lines = (folder / "records" / "test3.csv").read_text().splitlines(keepends=True)
    (folder / "records" / "gap.csv").write_text("".join(lines[:600] + lines[900:]))
    return [*sorted((folder / "records").glob("test*.csv")), folder / "records" / "gap.csv"]


@pytest.mark.parametrize("suffix", [".csv", ".xlsx"])
@pytest.mark.parametrize("bandwidth", [[], ["--bandwidth", "200 Hz"]], ids=["plain", "limited"])
def test_features_with_a_column_of_numbers_are_pairs_but_for_a_record_without_them_which_is_named(
    tmp_path, records, suffix, bandwidth
):
    features, pairs = tmp_path / f"features{suffix}", tmp_path / f"pairs{suffix}"
    told = json.loads(invoke("rig", "features", *records, "-o", features, *bandwidth, "--json").stdout)["records"]
    table = pd.read_csv(features) if suffix == ".csv" else pd.read_excel(features, sheet_name="data")
    assert len(table) == len(told) == 7 and told[0]["file"] == str(records[0])
    for name, key in (("static_force [N]", "static_force"), ("peak_frequency_3 [Hz]", "peak_frequency_3")):
        assert table[name][0] == pytest.approx(told[0][key], rel=1e-5)
    assert table["model_rpn_band"][0] == told[0]["model_rpn_band"] == "yellow"
    table["rpn"] = [3, 4, 5, 6, 8, 9, 7]
    table.to_csv(pairs, index=False) if suffix == ".csv" else table.to_excel(pairs, index=False)
    done = invoke("rig", "calibrate", pairs, "--json")
    assert done.exit_code == 0, done.stderr
    fit = json.loads(done.stdout)
    (line,) = fit["omitted"]
    assert "gap" in line and fit["pairs"]["rpn"] == [3, 4, 5, 6, 8, 9]


def test_what_was_understood_of_files_is_said_once_for_those_alike(tmp_path):
    for name, unit, scale in (("a", "N", 1), ("b", "N", 1), ("c", "mN", 1000)):
        rows = [f"{i};{round(scale * (i % 50) / 10, 3)};0,1".replace(".", ",") for i in range(400)]
        head = ["Normalkraft;10;N", "Geschwindigkeit;10;mm/s", "", f"Zeit [ms];Kraft [{unit}];Beschleunigung [m/s2]"]
        (tmp_path / f"{name}.csv").write_text("\n".join([*head, *rows]))
    done = invoke("rig", "features", *(tmp_path / f"{name}.csv" for name in "abc"))
    first, second = done.stdout.partition("read ")[2].split("read ")
    assert "a, b\n" in first and "drive_speed 10 mm/s" in first and "spring_force in N" in first
    assert " c\n" in second and "normal_load 10 N" in second and "spring_force in mN" in second


@pytest.mark.parametrize("words", [["rig"], ["rig", "run"]])
def test_a_rig_is_computed_with_and_without_the_word_run(here, words):
    done = call(*words, "rig/materials", "--plot", "none/x.png")
    assert done.exit_code == 2 and "no folder none" in done.stderr  # it was the command, and it read its options
    first_an_option = call(*words, "--plot", "none/x.png", "rig/materials")
    assert first_an_option.exit_code == 2 and "no folder none" in first_an_option.stderr


def test_the_commands_of_the_group_are_completed_and_without_a_file_the_ones_here_are_named(here):
    assert "rig" in completed([], "r") and completed(["rig"]) == ["run", "features", "friction", "calibrate"]
    (here / "small.yaml").write_text(TEXT)
    done = call("rig", "run")
    assert done.exit_code == 2 and "Configurations in this folder: small.yaml" in done.stderr


def test_a_rig_that_ships_is_listed_and_copied_with_its_command(here):
    assert "stickslip rig rig/materials " in call("init", "--list").stdout
    done = call("init", "my.yaml", "--from", "rig/materials")
    assert done.stdout == "wrote my.yaml; next: stickslip rig my.yaml\n"
