"""Measured points in files: as a curve of a configuration, and fitted by the command."""

import os
import subprocess
import sys
import warnings

import numpy as np
import pytest

import stickslip
from helpers.commands import call
from helpers.data import cases
from stickslip.config.reader import load_config, parse_config
from stickslip.errors import ConfigError, FitWarning

SPEED = np.array([0.1, 20, 50, 100, 200, 340, 500, 800, 1200])  # mm/s
CURVE = (1.0, 0.1, 0.3, 0.1)
CONFIG = """\
system: {mass: 1, normal_load: 1, stiffness: 10, belt_speed: 0.1}
friction: {fit: points.csv}
"""


def friction(speed):
    a1, a2, a3, a4 = CURVE
    return a1 + a2 * speed + a3 * np.exp(-speed / a4)


@pytest.fixture
def folder(tmp_path):
    rows = [f"{w}, {mu:.6f}" for w, mu in zip(SPEED, friction(SPEED / 1000), strict=True)]
    (tmp_path / "points.csv").write_text("\n".join(["speed [mm/s], mu", *rows]))
    (tmp_path / "map.yaml").write_text(CONFIG)
    return tmp_path


def test_a_configuration_uses_the_curve_fitted_to_its_points(folder):
    found = load_config(folder / "map.yaml").friction
    assert (found.a1, found.a2, found.a3, found.a4) == pytest.approx(CURVE, rel=1e-4)
    ds = stickslip.run(folder / "map.yaml")
    assert float(ds["a1"]) == found.a1


def test_the_resolved_configuration_names_the_file_and_needs_it_no_more(folder):
    config = load_config(folder / "map.yaml")
    (folder / "points.csv").unlink()
    again = parse_config(config.to_yaml())
    assert again == config
    assert again.friction.fit == "points.csv"


def test_the_file_is_looked_for_beside_the_configuration(folder, monkeypatch):
    monkeypatch.chdir("/")
    assert load_config(folder / "map.yaml").friction.a4 == pytest.approx(0.1, rel=1e-3)


def test_a_curve_its_points_do_not_bear_out_is_used_with_a_warning(folder):
    mu = [1.0, 1.4, 0.9, 1.3, 1.1, 0.8, 1.5, 1.0, 1.2]
    (folder / "points.csv").write_text("\n".join(["speed [mm/s], mu", *map("{}, {}".format, SPEED, mu)]))
    with pytest.warns(FitWarning, match=r"points\.csv: "):
        load_config(folder / "map.yaml")
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        done = call("validate", folder / "map.yaml")
    assert done.exit_code == 0
    assert done.stderr.startswith("warning: points.csv: ")


def test_the_command_fits_a_curve_with_its_intervals(folder):
    done = call("fit", folder / "points.csv")
    assert done.exit_code == 0, done.output
    row = next(line.split() for line in done.stdout.splitlines() if line.strip().startswith("a4"))
    assert float(row[1]) == pytest.approx(0.1, rel=1e-3)
    assert row[2:4] == ["m/s", "95"]


def test_a_configuration_warns_of_points_without_a_unit(folder):
    points = (folder / "points.csv").read_text().replace(" [mm/s]", "")
    (folder / "points.csv").write_text(points)
    with pytest.warns(FitWarning, match="no unit of speed, so the numbers were read in m/s"):
        load_config(folder / "map.yaml")


def test_the_command_fits_ageing_and_ranks_lubricants(folder):
    waits = np.array([1, 10, 60, 300, 1000])
    for name, level, slope in (("dry", 0.2, 0.03), ("grease", 0.1, 0.01)):
        rows = [f"{t}, {level + slope * np.log10(1 + t):.6f}" for t in waits]
        (folder / f"{name}.csv").write_text("\n".join(["time [s], mu", *rows]))
    done = call("fit", folder / "dry.csv", folder / "grease.csv", "--at", "5 min")
    assert done.exit_code == 0, done.output
    assert "by static friction after 300 s: grease (0.125), dry (0.274)" in done.stdout
    assert "by growth per decade: grease (0.010), dry (0.030)" in done.stdout


FILES = {  # by name and text: what is said of it
    "none.csv": (None, "none.csv: no such file"),
    "map.yaml": (None, "map.yaml"),
    "dry.csv": ("time [s], mu\n1, 0.2\n10, 0.23\n", "dry.csv: time: got 2 distinct waiting times, expected at least 3"),
}


@pytest.mark.parametrize("name", FILES)
def test_the_command_explains_a_file_that_will_not_do(folder, name):
    text, said = FILES[name]
    if text:
        (folder / name).write_text(text)
    done = call("fit", folder / name)
    assert done.exit_code == 2 and said in done.stderr and "Traceback" not in done.output


# --- several materials ------------------------------------------------------------------------------------------------

SEVERAL = """\
system: {mass: 1, normal_load: 1, stiffness: 10}
friction: {fit: [points.csv, oil.csv]}
axes:
  belt_speed: [0.1, 0.5, 2.0]
"""
IN_GROUP = """\
system: {mass: 1, stiffness: 10, belt_speed: 0.1}
axes:
  pair: {zip: {fit: [points.csv, oil.csv], normal_load: [1 N, 3 N]}}
"""


@pytest.fixture
def materials(folder):
    rows = "".join(f"{w}; {0.5 * mu:.6f}\n" for w, mu in zip(SPEED, friction(SPEED / 1000), strict=True))
    (folder / "oil.csv").write_text("Speed [mm/s]; COF\n" + rows.replace(".", ","))
    both = "".join(f"{w}, {mu:.6f}, {mu / 2:.6f}\n" for w, mu in zip(SPEED, friction(SPEED / 1000), strict=True))
    (folder / "table.csv").write_text("v [mm/s], dry, oil\n" + both)
    return folder


def test_a_list_of_files_is_an_axis_of_materials_with_their_names(materials):
    (materials / "map.yaml").write_text(SEVERAL)
    ds = stickslip.run(materials / "map.yaml")
    assert ds["regime"].dims == ("material", "belt_speed")
    assert list(ds["material"].values) == ["points", "oil"]
    assert ds["a1"].values == pytest.approx([1.0, 0.5], rel=1e-3) and ds["a4"].values == pytest.approx(
        [0.1, 0.1], rel=1e-3
    )
    one = load_config(materials / "map.yaml")
    assert parse_config(one.to_yaml()) == one and one.friction.fit == ("points.csv", "oil.csv")


def test_a_table_of_several_materials_is_an_axis_as_well(materials):
    (materials / "map.yaml").write_text(SEVERAL.replace("[points.csv, oil.csv]", "table.csv"))
    (axis, _) = load_config(materials / "map.yaml").axes
    assert axis.labels == ("dry", "oil") and axis.members[0].values == pytest.approx((1.0, 0.5), rel=1e-3)


def test_fits_vary_together_with_other_quantities_in_a_group(materials):
    (materials / "map.yaml").write_text(IN_GROUP)
    ds = stickslip.run(materials / "map.yaml")
    assert ds["pair"].values.tolist() == ["points", "oil"] and ds["normal_load"].values.tolist() == [1.0, 3.0]
    assert ds["a3"].values == pytest.approx([0.3, 0.15], rel=1e-3)
    (materials / "map.yaml").write_text(IN_GROUP.replace("3 N]}", "3 N]}, labels: [first, second]"))
    assert load_config(materials / "map.yaml").axes[0].labels == ("first", "second")


FIT = "friction: {fit: points.csv}"
HEAD = "speed [mm/s], mu\n"


@cases("materials.yaml")
def test_points_that_will_not_do_are_explained(materials, text, points, said):
    (materials / "map.yaml").write_text(text)
    if points:
        (materials / "points.csv").write_text(points)
    with pytest.raises(ConfigError) as caught:
        load_config(materials / "map.yaml")
    assert said in str(caught.value)


def test_points_that_come_with_the_package_are_found_from_a_copied_configuration(tmp_path):
    (tmp_path / "map.yaml").write_text(SEVERAL.replace("[points.csv, oil.csv]", "measured/dry.csv"))
    assert load_config(tmp_path / "map.yaml").friction.a1 == pytest.approx(0.27, abs=0.02)


@pytest.mark.slow
def test_a_command_that_finds_its_map_complete_ends(materials):
    """It read the map with threads of dask, which wait until they are told that there is no more to do."""
    (materials / "map.yaml").write_text(SEVERAL)
    command = [sys.executable, "-m", "stickslip", "run", "map.yaml", "-o", "map.nc"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    for _ in range(2):
        done = subprocess.run(command, cwd=materials, env=environment, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
    assert "complete already" in done.stdout
