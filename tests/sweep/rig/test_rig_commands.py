"""`stickslip rig-features` and `stickslip calibrate`, and the plots."""

import numpy as np
import pytest
from click.testing import CliRunner

from helpers.rig_signals import record, saw_tooth, times
from stickslip.cli import main
from stickslip.cli.rig import feature_screen_table
from stickslip.files import reading
from stickslip.rig import RPN_NAME, Risk, feature_table, load_settings, read_record
from stickslip.rig.report.traces import plot_records
from stickslip.rig.risk import INPUTS


def invoke(*arguments):
    done = CliRunner().invoke(main, [str(a) for a in arguments])
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


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
    done = invoke("rig-features", *files, "--speed", "10 mm/s", "--plot", plot, "--beside", "-o", output)
    assert done.exit_code == 0, done.output
    lines = done.output.splitlines()
    assert any(line.startswith("dry") for line in lines) and any(line.startswith("felt") for line in lines)
    assert RPN_NAME in done.output and "19" in done.output
    assert max(map(len, lines[:4])) <= 80 and "…" not in done.output
    assert plot.stat().st_size > 10_000
    with reading.open(output) as ds:
        assert ds["record"].values.tolist() == ["dry", "felt"]
        assert (ds["model_rpn"] >= 1).all() and ds["model_rpn"].dtype == np.int8
        assert RPN_NAME in ds["model_rpn"].attrs["long_name"]
        assert ds["static_friction"].values == pytest.approx([0.5, 0.15], rel=0.01)
        assert "weight_sticks" in ds.attrs["configuration"] and "rig-features" in ds.attrs["history"]


def test_a_table_in_a_pipe_has_all_its_columns(tmp_path, monkeypatch):
    """However narrow the terminal in which it was started."""
    monkeypatch.setenv("COLUMNS", "50")
    file = write(tmp_path / "a rather long name of a pair of materials at eighty degrees.csv")
    lines = invoke("rig-features", file).stdout.splitlines()
    assert lines[1].split()[-2:] == ["mu_s", "mu_d"] and file.stem in lines[2]


@pytest.mark.parametrize(("width", "tables"), [(30, 5), (50, 3), (80, 2), (1000, 1)])
def test_columns_that_do_not_fit_a_screen_are_in_a_table_below(files, width, tables):
    parts = feature_screen_table(feature_table({"dry": read_record(files[0])}), width).renderables
    assert len(parts) == tables
    headings = [column.header for table in parts for column in table.columns]
    assert headings.count("record") == headings.count("RPN") == tables and len(headings) == 2 * tables + 9


def test_a_configuration_sets_bandwidth_and_risk(tmp_path, files):
    config = tmp_path / "rig.yaml"
    config.write_text("features: {bandwidth: 100 Hz}\nrisk: {base: 10}\n")
    output = tmp_path / "features.nc"
    assert invoke("rig-features", files[0], "-c", config, "-o", output).exit_code == 0
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
    done = invoke("rig-features", files[0], *arguments)
    assert done.exit_code == 2
    assert expected in done.output


def test_the_same_file_twice_is_refused_and_the_same_name_is_not(tmp_path, files):
    assert "named twice" in invoke("rig-features", files[0], files[0]).output
    (tmp_path / "other").mkdir()
    other = write(tmp_path / "other" / "dry.csv")
    done = invoke("rig-features", files[0], other)
    assert done.exit_code == 0 and "other" in done.output


def test_calibrate_prints_a_configuration_and_keeps_its_remarks_apart(tmp_path):
    random = np.random.default_rng(8)
    features = 10 ** random.uniform([0, -1, -1.5], [2.7, 2.2, 2], (30, 3))
    truth = Risk(0.5, 0.8, 1.7, 0.6)
    rpn = truth.number(dict(zip(INPUTS, features.T, strict=True)))
    pairs = tmp_path / "pairs.csv"
    rows = [f"{n:.6g}, {a:.6g}, {i:.6g}, {r}" for (n, a, i), r in zip(features, rpn, strict=True)]
    pairs.write_text("\n".join(["sticks, acceleration_max [m/s2], acceleration_integral [m/s], rpn", *rows]))
    done = invoke("calibrate", pairs)
    assert done.exit_code == 0
    config = tmp_path / "risk.yaml"
    config.write_text(done.stdout)
    assert load_settings(config).risk.weight_acceleration_max == pytest.approx(1.7, abs=0.3)
    assert "residual" in done.stderr and "numbers reproduced" in done.stderr
    assert invoke("calibrate", pairs, "--scales").exit_code == 0


def test_calibrate_says_what_is_wrong_with_the_pairs(tmp_path):
    pairs = tmp_path / "pairs.csv"
    pairs.write_text("sticks, acceleration_max, rpn\n1, 1, 1\n")
    done = invoke("calibrate", pairs)
    assert done.exit_code == 2 and "no column is called acceleration_integral" in done.output
    pairs.write_text("sticks, acceleration_max, acceleration_integral, rpn\n" + "1, 1, 1, 12\n" * 9)
    assert "got the RPN 12, expected 1 to 10" in invoke("calibrate", pairs).output


# --- plots ------------------------------------------------------------------------------------------------------------


def two_records():
    time = times(3.0, 2000)
    return {
        name: record(time, size * saw_tooth(time), size * np.sin(300 * time)) for name, size in (("a", 1.0), ("b", 0.3))
    }


def test_zero_is_at_one_height_and_no_acceleration_is_cut_off():
    for shifted in (False, True):
        force, acceleration = plot_records(two_records(), shifted=shifted, numbers={"a": 7, "b": 2}).axes
        (low, high), (least, most) = force.get_ylim(), acceleration.get_ylim()
        assert low / high == pytest.approx(least / most)
        assert least <= -1.0 and most >= 1.0
        assert high >= 5.0


def test_records_beside_each_other_do_not_overlap_in_time():
    force, _ = plot_records(two_records(), shifted=True).axes
    first, second = (line.get_xdata() for line in force.get_lines())
    assert first[-1] < second[0]


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
    result = CliRunner().invoke(main, ["rig", "features", str(path), "--load", "30 N", "--speed", "25"])
    assert "drive_speed: 25 is read as 25 m/s; did you mean 25 mm/s?" in result.output
    assert "normal_load = 10 N holds, not the 30 N of the option" in result.output
    assert "felt" in result.stdout and "bare " not in result.stdout
    target = str(tmp_path / "f.nc")
    result = CliRunner().invoke(main, ["rig", "features", str(path), "--speed", "25 mm/s", "-o", target])
    assert result.exit_code == 0 and "of the option" not in result.output
    result = CliRunner().invoke(main, ["plot", target])
    assert result.exit_code == 2 and "features of rig tests" in result.output and "--plot" in result.output
