"""`stickslip rig`: a test matrix from a file to a table, plots and records."""

import numpy as np
import pytest

from helpers.commands import invoke
from stickslip.files import reading
from stickslip_rig.api import RPN_NAME, RigTests, features, load_rig, read_record
from stickslip_rig.sections import sections_of

TEXT = """\
title: Three loads
system: {mass: 100 g, stiffness: 5 N/mm, damping: 2 N s/m, belt_speed: 10 mm/s}
friction: {a1: 0.28, a2: 0, a3: 0.12, a4: 20 mm/s}
drive: {stroke: 4 mm, strokes: 2, waiting_time: 1 s}
sensor: {rate: 1 kHz, force_noise: 5 mN, bandwidth: 300 Hz}
features: {bandwidth: 200 Hz}
axes: {normal_load: [5 N, 10 N, 2 kN]}
"""


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
    for name, more in (("over.png", []), ("beside.png", ["--beside", "--from", "0", "--to", "0.2 s"])):
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


def test_a_page_shows_the_matrix_and_its_size_is_said(tmp_path, config):
    done = invoke("rig", config, "--report", tmp_path / "matrix.html")
    assert done.exit_code == 0 and f"report   {tmp_path / 'matrix.html'} (" in done.output
    assert "Three loads" in (tmp_path / "matrix.html").read_text(encoding="utf-8")


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


@pytest.mark.parametrize(
    "arguments, expected",
    [
        (["--test", "3", "--plot", "a.png"], "--test 3: tests are numbered from 0 to 2"),
        (["--test", "-1", "--plot", "a.png"], "--test -1: tests are numbered from 0 to 2"),
        (["--test", "1"], "name a plot with --plot"),
        (["--plot", "a.bmp"], "a.bmp: plots end in"),
        (["--plot", "nowhere/a.png"], "no folder nowhere"),
        (["--report", "a.txt"], "a.txt: pages end in .html, .htm"),
        (["--report", "nowhere/a.html"], "a.html: no folder nowhere"),
        (["-o", "a.txt"], "a.txt"),
        (["--records", "file"], "file: expected a folder"),
        (["--records", "file/inside"], "file/inside: expected a folder"),
        (["--from", "soon"], "got 'soon', expected a time"),
    ],
)
def test_what_is_wrong_ends_with_exit_code_2_before_anything_is_computed(
    tmp_path, config, monkeypatch, arguments, expected
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    done = invoke("rig", config, *arguments)
    assert done.exit_code == 2
    assert expected in done.output
    assert "tests:" not in done.output and {p.name for p in tmp_path.iterdir()} == {"rig.yaml", "file"}
