"""`stickslip rig features` and `stickslip rig calibrate`, and the plots."""

import json

import numpy as np
import pandas as pd
import pytest

from helpers.commands import invoke
from helpers.rig_signals import record, saw_tooth, times
from stickslip.files import reading
from stickslip_rig.api import RPN_NAME, Risk, load_settings
from stickslip_rig.plots import plot_records
from stickslip_rig.risk import INPUTS


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
    done = invoke("rig", "features", *files, "--speed", "10 mm/s", "--plot", plot, "--beside", "-o", output)
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


def test_a_configuration_sets_bandwidth_and_risk(tmp_path, files):
    config = tmp_path / "rig.yaml"
    config.write_text("features: {bandwidth: 100 Hz}\nrisk: {base: 10}\n")
    output = tmp_path / "features.nc"
    assert invoke("rig", "features", files[0], "-c", config, "-o", output).exit_code == 0
    with reading.open(output) as ds:
        assert int(ds["model_rpn"][0]) == 10
        assert ds["acceleration_max_limited"][0] < ds["acceleration_max"][0]


@pytest.mark.parametrize(
    "arguments, expected",
    [
        (["nothing.csv"], "nothing.csv: no such file"),
        (["--load", "heavy"], "normal_load: got 'heavy', expected a force"),
        (["--bandwidth", "600 Hz"], "needs more than 1200 samples per second"),
        (["--plot", "x.bmp"], "plots end in"),
        (["-c", "nothing.yaml"], "nothing.yaml: no such file"),
        (["-o", "features.txt"], "features.txt"),
    ],
)
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
    assert done.exit_code == 0 and "30 pairs: leave-one-out error" in done.stderr
    config = tmp_path / "risk.yaml"
    config.write_text(done.stdout)
    assert load_settings(config).risk.weight_acceleration_max == pytest.approx(1.7, abs=0.3)
    assert "At least five pairs" in invoke("rig", "calibrate", "--help").stdout


@pytest.mark.parametrize(
    "heading, row, expected",
    [
        (f"{FEATURES}, model_rpn", "#, #, #, 3", "model_rpn is computed by this program"),
        (f"{FEATURES}, rpn", "#, #, #, 11", ":2:10: got 11, expected a number from 1 to 10"),
        (f"{FEATURES}, rpn", "#, #, #, 0.5", ":2:10: got 0.5"),
        (f"{FEATURES}, rpn", "#, -#, #, 5", ":2:4: got -1"),
        (f"{FEATURES}, rpn", "#, x, #, 5", ":2:4: "),
        (f"{FEATURES}, rpn", "#, #, 5", ":2:"),
        (f"{FEATURES}, rpn, rpn", "#, #, #, 3, 4", "'rpn', expected it once"),
        ("sticks, acceleration_max [N], acceleration_integral [m/s], rpn", "#, #, #, 3", "acceleration_max [N]"),
        ("sticks, acceleration_max [furlong], acceleration_integral, rpn", "#, #, #, 3", "acceleration_max [furlong]"),
        ("sticks, rpn", "#, 3", "no column is called acceleration_max and acceleration_integral"),
        (f"{FEATURES}, rpn", "#, #, , 3", "no row has a number and features\n  hint: left out: row 1"),
        (f"{FEATURES}, rpn", "#, #, #, ", "no row has a number"),
        (f"{FEATURES}, rpn", "1, 1, 1, 3", "6 pairs, 1 of different features, for 4 parameters, expected at least 5"),
    ],
)
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
    for beside in (False, True):
        axes = plot_records(two_records(), beside=beside, numbers={"a": 7, "b": 2}).axes
        for force, acceleration in zip(axes[: len(axes) // 2], axes[len(axes) // 2 :], strict=True):
            (low, high), (least, most) = force.get_ylim(), acceleration.get_ylim()
            assert low / high == pytest.approx(least / most)
            assert least <= -1.0 and most >= 1.0
            assert high >= 5.0


def test_records_beside_each_other_have_names_and_their_own_times():
    axes = plot_records(two_records(), beside=True, numbers={"a": 7, "b": np.nan}, window=(1.0, 2.0)).axes[:2]
    assert [panel.get_title() for panel in axes] == ["a: 7", "b: ?"]
    for panel in axes:
        assert panel.get_lines()[0].get_xdata()[[0, -1]] == pytest.approx([1.0, 2.0], abs=1e-3)


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
    assert "normal_load = 10 N holds, not the 30 N of the option" in result.output
    assert "felt" in result.stdout and "bare " not in result.stdout
    target = str(tmp_path / "f.nc")
    result = invoke("rig", "features", path, "--speed", "25 mm/s", "-o", target)
    assert result.exit_code == 0 and "of the option" not in result.output
    result = invoke("plot", target)
    assert result.exit_code == 2 and "features of rig tests" in result.output and "--plot" in result.output


# --- features in tables -----------------------------------------------------------------------------------------------

MATRIX = """
title: pairs
system: {mass: 100 g, stiffness: 5 N/mm, damping: 2 N s/m, normal_load: 10 N, belt_speed: 10 mm/s}
friction: {mu_reversal: 0.35, v_reversal: 100 mm/s, a4: 20 mm/s}
axes: {mu_start: [0.4, 0.45, 0.5, 0.55, 0.6, 0.7]}
drive: {stroke: 4 mm, strokes: 2}
sensor: {rate: 2 kHz}
"""


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
    assert "gap" in line and "record it again" in line and fit["pairs"]["rpn"] == [3, 4, 5, 6, 8, 9]


def test_what_was_understood_of_files_is_said_once_for_those_alike(tmp_path):
    for name, unit, scale in (("a", "N", 1), ("b", "N", 1), ("c", "mN", 1000)):
        rows = [f"{i};{round(scale * (i % 50) / 10, 3)};0,1".replace(".", ",") for i in range(400)]
        head = ["Normalkraft;10;N", "Geschwindigkeit;10;mm/s", "", f"Zeit [ms];Kraft [{unit}];Beschleunigung [m/s2]"]
        (tmp_path / f"{name}.csv").write_text("\n".join([*head, *rows]))
    done = invoke("rig", "features", *(tmp_path / f"{name}.csv" for name in "abc"))
    first, second = done.stdout.partition("read ")[2].split("read ")
    assert "a, b\n" in first and "drive_speed 10 mm/s" in first and "spring_force in N" in first
    assert " c\n" in second and "normal_load 10 N" in second and "spring_force in mN" in second


def test_a_speed_above_the_heading_that_nobody_understands_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    rows = [f"{i};1;0" for i in range(40)]
    path.write_text("\n".join(["Geschwindigkeit;10;N", "Zeit [ms];Kraft [N];Beschleunigung [m/s2]", *rows]))
    done = invoke("rig", "features", path)
    assert done.exit_code == 2 and "a.csv:1:1" in done.stderr, done.stderr
