"""`friction: {table: felt.csv}`: points of a file as a curve."""

import subprocess
import sys

import numpy as np
import pytest

import stickslip
from helpers.data import cases
from stickslip.config.reader import load_config, parse_config
from stickslip.errors import ConfigError, ExtrapolationWarning

YAML = """
system: {mass: 100 g, normal_load: 10 N, damping: 2 N s/m}
friction: {table: felt.csv}
axes:
  stiffness: {start: 0.5 N/mm, stop: 50 N/mm, num: 4, spacing: log}
  belt_speed: {start: 1 mm/s, stop: 200 mm/s, num: 5}
"""
FELT = "# felt\nspeed [mm/s], mu\n1, 0.398\n3, 0.381\n10, 0.347\n30, 0.297\n60, 0.288\n100, 0.291\n200, 0.300\n"


@pytest.mark.parametrize(
    ("rows", "line"),
    [("1, .4\n3, .3\n2, .3", 4), ("1, .4\n\n# slow\n1, .3", 5), ("1, .4\n2, 0", 3), ("1, .4\n2, x", 3)],
)
def test_wrong_rows_of_a_file_are_named_by_their_line(tmp_path, rows, line):
    (tmp_path / "felt.csv").write_text(f"speed [mm/s], mu\n{rows}\n", encoding="utf-8")
    (tmp_path / "felt.yaml").write_text(YAML, encoding="utf-8")
    with pytest.raises(ConfigError, match=rf"felt\.csv:{line}:"):
        load_config(tmp_path / "felt.yaml")


@cases("materials.yaml")
def test_what_stands_beside_a_table_of_a_file_or_in_its_place_is_refused(tmp_path, friction, message):
    (tmp_path / "felt.csv").write_text(FELT, encoding="utf-8")
    (tmp_path / "felt.yaml").write_text(YAML.replace("{table: felt.csv}", friction), encoding="utf-8")
    with pytest.raises((ConfigError, OSError), match=message):
        load_config(tmp_path / "felt.yaml")


@pytest.mark.slow
def test_a_configuration_keeps_the_points_and_another_process_knows_them(tmp_path):
    (tmp_path / "felt.csv").write_text(FELT, encoding="utf-8")
    (tmp_path / "felt.yaml").write_text(YAML, encoding="utf-8")
    config = load_config(tmp_path / "felt.yaml")
    law = stickslip.Table(["1 mm/s", "3 mm/s", "10 mm/s", "30 mm/s", "60 mm/s", "100 mm/s", "200 mm/s"],
                          [0.398, 0.381, 0.347, 0.297, 0.288, 0.291, 0.300])  # fmt: skip
    assert config.friction.law == law
    assert parse_config(config.to_yaml()) == config
    with pytest.warns(ExtrapolationWarning, match="fastest point of the table is at 0.2 m/s"):
        found = stickslip.run(config, tmp_path / "felt.nc")
    cells = {name: found[name] for name in ("stiffness", "belt_speed")}
    cells |= {"mass": 0.1, "normal_load": 10.0, "damping": 2.0}
    with pytest.warns(ExtrapolationWarning, match="fastest point of the table is at 0.2 m/s"):
        same = stickslip.evaluate(cells, law=law)
    np.testing.assert_array_equal(found["spring_force_max"], same["spring_force_max"])
    same.to_netcdf(tmp_path / "cells.nc")
    script = (
        "import sys, stickslip; from stickslip.config.grid import shared_by as of\n"
        "for file in sys.argv[1:]: stickslip.Options(law=of(stickslip.open(file))['law'])"
    )
    subprocess.run([sys.executable, "-c", script, tmp_path / "felt.nc", tmp_path / "cells.nc"], check=True)
