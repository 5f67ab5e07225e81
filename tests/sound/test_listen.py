"""`listen` and `simulate`: what they say, and what they write."""

import json
from io import BytesIO

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner
from scipy.io import wavfile

import stickslip
from helpers.configs import write_config
from helpers.data import cases
from stickslip import plots, sound
from stickslip.api.cells import CYCLES, time_span
from stickslip.cli import main
from stickslip.errors import PlotError

STICKS = ("--at", "stiffness=1", "--at", "belt_speed=0.1")
SETTLES = ("--at", "stiffness=1", "--at", "belt_speed=0.9")
PADS = """\
title: pads
system: {mass: 100 g, normal_load: 10 N}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes: {stiffness: [1 N/mm, 5 N/mm, 20 N/mm], belt_speed: [20 mm/s, 0.1 m/s, 0.5 m/s, 3 m/s]}
"""


@pytest.fixture
def config(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return str(write_config(tmp_path, num=4))


def call(*words, code=0):
    done = CliRunner().invoke(main, list(words))
    assert done.exit_code == code, done.output
    return done.stderr if code else done.stdout


# --- simulate ---------------------------------------------------------------------------------------------------------


def cell(**more):
    return {"mass": 1, "normal_load": 1, "a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1, "stiffness": 1} | more


def test_simulate_speaks_json_alone_with_the_names_of_evaluate(config):
    said = json.loads(call("simulate", config, *STICKS, "--json"))
    found = stickslip.evaluate(cell(belt_speed=0.1))
    assert said["regime"] == "stick_slip" and said["status"] == "cycle_closed"
    for name in ("period", "stick_fraction", "spring_force_max", "displacement_amplitude"):
        assert said[name] == float(found[name][0])
    assert said["settling_time"] is None and "output" not in said
    said = json.loads(call("simulate", config, *STICKS, "--json", "-o", "trace.nc"))
    with xr.open_dataset("trace.nc") as ds:
        assert said["output"] == "trace.nc" and said["duration"] == float(ds["time"][-1])


@pytest.mark.parametrize("at", [STICKS, SETTLES])
def test_a_duration_that_nobody_gave_shows_what_becomes_of_the_cell(config, at):
    call("simulate", config, *at, "-o", "trace.nc")
    with xr.open_dataset("trace.nc") as ds:
        found = stickslip.evaluate(cell(belt_speed=float(ds["belt_speed"])))
        end = float(ds["time"][-1])
        if at is STICKS:
            began = float(found["breakaway_time"][0])
            assert (
                began + CYCLES * float(found["period"][0]) <= end <= 1.2 * (began + CYCLES * float(found["period"][0]))
            )
            assert (np.diff((ds["mode"].values == 0).astype(int)) == 1).sum() == CYCLES
        else:
            late = ds["displacement"].values[ds["time"] > 0.97 * end]
            assert np.ptp(late) < 3e-4 * np.ptp(ds["displacement"].values)
        assert ds["time"].size >= 50 * end / (2.0 * np.pi)


def test_every_regime_has_a_duration():
    cells = cell(belt_speed=[0.1, 0.9, 0.0, 0.3, 0.5], damping=[0.0, 0.0, 0.0, 0.0, 5.0], a3=[0.3, 0.3, 0.3, 0.0, 0.3])
    cells |= {"a2": [0.1, 0.1, 0.1, 0.0, 0.1], "velocity": [np.nan, np.nan, np.nan, 0.0, np.nan]}
    found = stickslip.evaluate(cells)
    kinds = {stickslip.vocabulary.quantities.REGIMES[i] for i in found["regime"].values}
    assert kinds == {"stick_slip", "damped", "stuck", "sustained", "creep"}
    for i in range(5):
        look = time_span(found.isel(cell=[i]))
        assert 0.0 < look.duration < 1e4 and 2001 <= look.samples <= 40_001 and look.why


def test_pictures_of_a_cell_name_what_was_set(config, tmp_path):
    call("simulate", config, *STICKS, "--at", "mass=1 kg", "--plot", "trace.svg", "-t", "20")
    shown = (tmp_path / "trace.svg").read_text(encoding="utf-8")
    assert "mass 1 kg, stiffness 1 N/m, normal load 1 N, belt speed 100 mm/s" in shown
    ds = stickslip.simulate(duration=20.0, **cell(belt_speed=0.02, stiffness=5000.0, mass=0.1))
    (title,) = plots.plot_trace(ds)._suptitle.get_text().splitlines()[1:]
    assert title == "mass 100 g, stiffness 5 N/mm, normal load 1 N, belt speed 20 mm/s"


# --- listen -----------------------------------------------------------------------------------------------------------


def test_listen_writes_the_sound_and_says_what_is_heard(config, tmp_path):
    said = call("listen", config, *STICKS, "--slow", "0.001", "-o", "squeak.wav", "--seconds", "500 ms")
    rate, stored = wavfile.read("squeak.wav")
    heard = sound.of(cell(belt_speed=0.1), 0.5, slow=0.001)
    np.testing.assert_array_equal(stored, np.rint(heard.samples * 32767).astype(np.int16))
    assert rate == 44_100 and stored.size == 22_050
    assert "stick-slip, 0.101 Hz" in said and "0.001 times slower" in said and "dB(A)" in said
    assert sorted(p.name for p in tmp_path.iterdir()) == ["small.yaml", "squeak.wav"]


def test_listen_speaks_json_alone(config):
    said = json.loads(call("listen", config, *STICKS, "--json", "-o", "squeak.wav", "--full-scale", "2 m/s2"))
    assert said["regime"] == "stick_slip" and said["full_scale"] == 2.0 and said["output"] == "squeak.wav"
    assert said["acceleration_level_a"] == float(sound.levels(cell(belt_speed=0.1))["acceleration_level_a"][0])


def test_a_result_is_listened_to_as_its_configuration_is(config, tmp_path):
    call("run", config, "-o", "map.nc", "--plot", "map.png")
    call("listen", "map.nc", *STICKS, "-o", "one.wav", "--seconds", "1")
    call("listen", config, *STICKS, "-o", "two.wav", "--seconds", "1")
    assert (tmp_path / "one.wav").read_bytes() == (tmp_path / "two.wav").read_bytes()


def test_silence_clipping_and_nothing_written_are_said(config):
    assert "stuck, peaks of 0 m/s2" in call("listen", config, "--at", "stiffness=1", "--at", "belt_speed=0")
    said = call("listen", config, *STICKS, "--full-scale", "0.01 m/s2", "--slow", "0.001")
    assert "compressed above" in said and "nothing was written" in said


@cases("sound.yaml")
def test_what_cannot_be_is_refused_before_anything_is_computed(config, tmp_path, words, message):
    assert message in call("listen", config, *STICKS, *words, code=2)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["small.yaml"]


def test_a_cell_that_failed_is_not_listened_to_and_the_reason_is_given(config):
    said = call("listen", config, "--at", "stiffness=1", "--at", "belt_speed=1", "--at", "a2=-5", code=1)
    assert "no motion to listen to, negative_friction" in said


def test_what_is_not_heard_is_written_as_minus_infinity(here):
    """50 kHz, without friction that changes."""
    (here / "free.yaml").write_text(
        "title: free\nsystem: {mass: 1 g, normal_load: 1 N, belt_speed: 1 m/s}\n"
        "friction: {a1: 0.5, a2: 0, a3: 0, a4: 1 m/s}\nstart: {velocity: 0.5 m/s}\n"
        "axes: {stiffness: [1 N/mm, 1e8 N/m]}\n"
    )
    assert json.loads(call("listen", "free.yaml", "--level", "-o", "levels.nc", "--json"))["not_heard"] == 1
    with xr.open_dataset("levels.nc") as ds:
        assert np.isneginf(ds["acceleration_level_a"].values).tolist() == [False, True]
    call("plot", "levels.nc", "--variable", "acceleration_level_a", "-o", "levels.png")


def test_levels_of_a_map_are_written_said_and_drawn(here):
    config = here / "pads.yaml"
    config.write_text(PADS)
    said = call("listen", "pads.yaml", "--level", "-o", "levels.nc")
    with xr.open_dataset("levels.nc") as ds:
        level = ds["acceleration_level_a"]
        assert level.shape == (3, 4) and f"{float(level.max()):.6g}" in said
        np.testing.assert_array_equal(level, sound.levels(config)["acceleration_level_a"])
    call("plot", "levels.nc", "--variable", "acceleration_level_a", "-o", "levels.png")
    said = json.loads(call("listen", "pads.yaml", "--level", "--json"))
    assert said["cells"] == 12 == said["with_level"] + said["without_cycle"] + said["not_heard"]


def test_a_picture_of_a_sound_shows_its_tone():
    rate, times = 44_100, np.arange(44_100) / 44_100
    figure = plots.plot_sound(np.sin(2.0 * np.pi * 1000.0 * times), rate, title="a tone", slow=10.0)
    mesh = figure.axes[1].collections[0]
    levels = mesh.get_array().reshape(mesh.get_coordinates().shape[0] - 1, -1)
    row = int(np.nanargmax(levels[:, levels.shape[1] // 2]))
    centres = mesh.get_coordinates()[:-1, 0, 1]
    assert centres[row] == pytest.approx(1000.0, rel=0.02)
    assert np.nanmax(levels) == pytest.approx(10.0 * np.log10(0.5 / 1e-12), abs=0.5)
    assert "10 times slower" in figure.axes[1].get_xlabel()
    with pytest.raises(PlotError, match="needs"):
        plots.plot_sound(np.ones(100), rate)
    plots.plot_sound(np.zeros(44_100), rate).savefig(BytesIO(), format="png")  # silence
