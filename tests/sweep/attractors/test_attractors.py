"""The call, the section, the commands and the pictures of attractors."""

import re

import numpy as np
import pytest
import xarray as xr

import stickslip
from helpers.commands import call, told
from stickslip import plots
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError, PlotError
from stickslip.vocabulary.quantities import REGIMES, SHARE_METHODS

CELL = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
BOX = {"displacement": (0.0, 2.0), "velocity": (-1.0, 1.0)}
PAIR = """
system: {mass: 1, stiffness: 1, normal_load: 1}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes:
  belt_speed: {start: 0.2, stop: 1, num: 33}
"""
SECTION = "attractors: {displacement: [0, 200 cm], velocity: [-1 m/s, 1 m/s]}\n"


@pytest.fixture(scope="module")
def band():
    """The attractors over the belt speed."""
    return stickslip.attractors(parse_config(PAIR), BOX)


def test_a_dataset_says_what_its_numbers_are(band, tmp_path):
    assert band["coexisting"].dtype == np.int8 and band["coexisting"].attrs["flag_masks"].dtype == np.int8
    masks = band["coexisting"].attrs["flag_masks"].tolist()
    assert masks == [1 << i for i in range(7)]
    assert band["coexisting"].attrs["flag_meanings"].split() == list(REGIMES[1:])
    assert band.attrs["box_displacement"].tolist() == [0, 2] and band.attrs["box_velocity"].tolist() == [-1, 1]
    assert (band["share_method"] == SHARE_METHODS.index("exact")).all()
    assert parse_config(band.attrs["configuration"]).study.velocity == (-1.0, 1.0)
    assert all({"units", "long_name"} <= set(variable.attrs) for variable in band.data_vars.values())
    assert not {"displacement", "velocity"} & set(band.coords)


def test_a_section_asks_run_for_the_same(band, tmp_path):
    config = tmp_path / "my.yaml"
    config.write_text(PAIR + SECTION)
    ds = stickslip.run(config, tmp_path / "attractors.nc")
    xr.testing.assert_equal(ds.load(), band)
    ds.close()
    called = stickslip.attractors(config)  # the box of the section
    xr.testing.assert_equal(called, band)


def test_an_axis_of_starting_states_is_refused():
    text = PAIR + "  velocity: [0, 1]\n"
    with pytest.raises(ConfigError, match="axes.velocity: expected no axis: the starting states are those of the box"):
        parse_config(text + SECTION)
    with pytest.raises(ValueError, match="velocity: expected no axis"):
        stickslip.attractors(parse_config(text), BOX)


@pytest.fixture
def config(tmp_path):
    path = tmp_path / "my.yaml"
    path.write_text(PAIR.replace("{start: 0.2, stop: 1, num: 33}", "[0.3, 0.5, 0.9]") + SECTION)
    return path


def test_the_command_tells_a_line_per_cell_or_a_summary(config, tmp_path):
    said = told("attractors", config)
    for row in (r"0.3 m/s +stick_slip +any +0", r"0.5 m/s +stick_slip or damped +0.39\d+ m/s +0.128\d+",
                r"0.9 m/s +damped +none is enough +1"):  # fmt: skip
        assert re.search(rf"^{row} +exact$", said, re.MULTILINE)
    config.write_text(PAIR)
    said = told("attractors", config, "--displacement", "0", "2 m", "--velocity", "-1", "1", "-o", tmp_path / "a.nc")
    assert re.search(r"^stick_slip or damped +\d+$", said, re.MULTILINE)
    assert "shares   33 of 33 exact" in said and "written  " in said
    assert "plot     " in told("plot", tmp_path / "a.nc", "-o", tmp_path / "a.png")


def test_the_ramp_command_tells_where_the_regime_changes(config, tmp_path):
    config.write_text(PAIR)
    said = told("ramp", config, "--along", "belt_speed", "-o", tmp_path / "r.nc", "--plot", tmp_path / "r.png")
    assert re.search(r"^up +stick_slip +damped +0.79\d+ m/s +0.79\d+ m/s$", said, re.MULTILINE)
    assert re.search(r"^down +damped +stick_slip +0.34\d+ m/s +0.33\d+ m/s$", said, re.MULTILINE)
    assert "plot     " in told("plot", tmp_path / "r.nc", "-o", tmp_path / "again.png")
    done = call("ramp", config, "--along", "belt_sped")
    assert done.exit_code == 2 and "did you mean belt_speed?" in done.output


def test_plots_show_the_band_and_refuse_what_is_no_line(band, tmp_path):
    figure = plots.plot_attractors(band)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"bistable", "no shock is enough", "shock along the belt", "shock against the belt"} <= set(labels)
    loop = stickslip.ramp(parse_config(PAIR), "belt_speed", points=33)
    rising, falling = plots.plot_ramp(loop, "period").axes[0].lines
    for line, direction in ((rising, "up"), (falling, "down")):
        np.testing.assert_array_equal(line.get_ydata(), loop["period"].sel(direction=direction))
    with pytest.raises(PlotError, match="not a ramp"):
        plots.plot_ramp(band)
    with pytest.raises(PlotError, match="no settling_share"):
        plots.plot_attractors(loop)
    with pytest.raises(PlotError, match="nothing to draw a line through"):
        plots.plot_attractors(band.isel(belt_speed=0))
    two = xr.concat([band, band], xr.Variable("damping", [0.0, 1.0]))
    with pytest.raises(PlotError, match="more than one dimension: damping, belt_speed"):
        plots.plot_attractors(two)
    assert plots.plot_map(two, "settling_share").axes
