"""Levels of cells: against closed forms, one another, and the sound itself; A-weighting against its standard."""

import numpy as np
import pytest
import xarray as xr

import stickslip
from helpers.cycles import (
    COULOMB,
    OTHERS,
    PAIR,
    SUSTAINED,
    UNIT,
    coulomb_harmonics,
    faster,
    hard_cells,
)  # fmt: skip
from helpers.plotted import draws_what_the_command_draws
from stickslip import sound
from stickslip.config.reader import parse_config
from stickslip.engine import Options
from stickslip.plots.pages import pictures_of
from stickslip.vocabulary.cells import as_cells
from stickslip.vocabulary.quantities import REGIMES
from stickslip_sound.loudness import a_weighting, decibels, levels, levels_of

LEVEL = "acceleration_level_a"
FREE = UNIT | {"a1": 0.5, "a2": 0.0, "a3": 0.0, "a4": 1.0, "belt_speed": 5.0, "velocity": 0.0}
SQUEAL = COULOMB | {"stiffness": 2e6, "belt_speed": 0.5}
PADS = """\
title: pads
system: {mass: 100 g, normal_load: 10 N}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes: {stiffness: [1 N/mm, 5 N/mm, 20 N/mm], belt_speed: [20 mm/s, 0.1 m/s, 0.5 m/s, 3 m/s]}
"""
LIST = COULOMB | {"stiffness": np.geomspace(10.0, 1e7, 300), "belt_speed": np.linspace(0.5, 0.01, 300)}


def level(cell, law="stribeck"):
    return float(levels(cell, law=law)[LEVEL][0])


@pytest.mark.parametrize("frequency", [31.5, 1000.0, 12_500.0])
def test_a_pure_tone_has_the_level_of_its_amplitude_and_its_weight(frequency):
    """0.1 m/s2 rms is 100 dB re 1e-6 m/s2 at 1 kHz."""
    omega = 2.0 * np.pi * frequency
    a = 0.1 * np.sqrt(2.0)
    cell = FREE | {"stiffness": omega**2, "displacement": 0.5 / omega**2 + a / omega**2}
    assert level(cell) == pytest.approx(100.0 + 20.0 * np.log10(a_weighting(frequency)), abs=1e-4)


@pytest.mark.parametrize("stiffness", [5.0, 5e3, 5e6])
@pytest.mark.parametrize("damping", [0.0, 0.2])
def test_the_level_of_a_coulomb_cycle_is_that_of_its_closed_form(stiffness, damping):
    """Below 1 Hz, where only the slip is sampled, at 15 Hz and at 1.1 kHz."""
    cell = COULOMB | {"stiffness": stiffness, "damping": damping}
    _, cycle = coulomb_harmonics(cell, damping, 1, 0.0)
    exact, _ = coulomb_harmonics(cell, damping, int(20e3 * float(cycle.period)), 0.0)
    weights = a_weighting(np.arange(1, exact.size + 1) / float(cycle.period))
    wanted = 10.0 * np.log10((2.0 * np.abs(exact * weights) ** 2).sum() / 1e-12)
    assert level(cell) == pytest.approx(wanted, abs=0.01)


def test_the_level_is_that_of_the_sound():
    heard = sound.of(SQUEAL, 1.0)
    middle = heard.acceleration[5000:-5000]
    window = np.hanning(middle.size)
    weights = a_weighting(np.fft.rfftfreq(middle.size, 1.0 / heard.rate))
    power = (
        2.0 * np.square(np.abs(np.fft.rfft(middle * window)) * weights).sum() / middle.size / np.square(window).sum()
    )
    assert level(SQUEAL) == pytest.approx(10.0 * np.log10(power / 1e-12), abs=0.01)


@OTHERS
def test_hard_cells_need_no_more_samples_either(others, monkeypatch):
    """Every tenth of those with stick-slip, all laws, parameters over decades."""
    some = [(law, cell) for law, cell, row in hard_cells("stick_slip", others) if float(row["period"]) < 3.0][::9]
    once = [level(cell, law) for law, cell in some]
    monkeypatch.setattr("stickslip_sound.loudness.OVERSAMPLING", 16)
    monkeypatch.setattr("stickslip_sound.loudness.FORGOTTEN", 10.0)
    np.testing.assert_allclose([level(cell, law) for law, cell in some], once, atol=0.02)
    assert len(some) > 3 and np.isfinite(once).all()


@pytest.mark.parametrize("stiffness", [1e6, 1e8, pytest.param(1e10, marks=pytest.mark.slow)])
def test_slips_far_shorter_than_the_period_of_any_tone_need_no_more_samples(stiffness, monkeypatch):
    """1 g: natural frequencies from 5 kHz to 500 kHz, ten slips a second."""
    cell = COULOMB | {"mass": 1e-3, "stiffness": stiffness, "belt_speed": 40.0 / stiffness}
    once = level(cell)
    monkeypatch.setattr("stickslip_sound.loudness.OVERSAMPLING", 16)
    assert level(cell) == pytest.approx(once, abs=0.02)


def test_only_cells_with_a_cycle_have_a_level():
    cells = {**PAIR, "belt_speed": [0.1, 0.9, 0.0], "damping": [0.0, 0.0, 0.0]}
    found = levels(cells)
    assert [REGIMES[i] for i in found["regime"].values] == ["stick_slip", "damped", "stuck"]
    np.testing.assert_array_equal(np.isnan(found[LEVEL]), [False, True, True])
    above = FREE | {"stiffness": (2.0 * np.pi * 30e3) ** 2, "displacement": 1.0}
    assert level(above) == -np.inf


@pytest.mark.parametrize("name", ["neutral_ringing", pytest.param("slip_cycle", marks=pytest.mark.slow)])
def test_a_vibration_too_slow_to_be_heard_is_not_given_the_level_of_rounding(name):
    """0.1 Hz without a jump: its harmonics above 20 Hz are far below what doubles hold of the displacement."""
    law, cell = SUSTAINED[name]
    assert level(cell, law) == -np.inf
    assert np.isfinite(level(faster(cell), law))


def test_twice_the_acceleration_is_six_decibels():
    """Load and speeds twice as large, at the same frequencies."""
    twice = {name: PAIR[name] * 2.0 for name in ("normal_load", "belt_speed", "a4")} | {"a2": PAIR["a2"] / 2.0}
    assert level(PAIR | twice) - level(PAIR) == pytest.approx(20.0 * np.log10(2.0), abs=1e-6)


def test_a_level_does_not_depend_on_its_block_or_its_threads():
    cells, options = as_cells(LIST), Options(rtol=1e-9)
    whole = levels_of(cells, options)[LEVEL]
    for part in (slice(0, 1), slice(37, 38), slice(100, 177), slice(299, 300)):
        alone = levels_of({name: values[part] for name, values in cells.items()}, options)
        np.testing.assert_array_equal(alone[LEVEL], whole[part])
    for threads in (1, 3):
        np.testing.assert_array_equal(levels(LIST, threads=threads)[LEVEL], whole)


def test_configurations_results_and_parts_of_them_have_the_same_levels(tmp_path):
    config = tmp_path / "pads.yaml"
    config.write_text(PADS)
    whole = levels(config)
    assert whole[LEVEL].dims == ("stiffness", "belt_speed") and whole["stiffness"].attrs["units"] == "N m-1"
    ds = stickslip.run(config)
    np.testing.assert_array_equal(whole["regime"], ds["regime"])
    np.testing.assert_array_equal(levels(ds)[LEVEL], whole[LEVEL])
    xr.testing.assert_allclose(levels(ds.isel(stiffness=2))[LEVEL], whole[LEVEL].isel(stiffness=2))
    ds[LEVEL] = levels(ds)[LEVEL]
    listed = stickslip.evaluate(COULOMB | {"stiffness": [50.0, 5000.0]})
    assert levels(listed)[LEVEL].dims == ("cell",)


def test_what_varies_by_names_or_as_measured_is_known(tmp_path):
    config = tmp_path / "some.yaml"
    config.write_text(
        "title: some\n"
        "system: {mass: 1, stiffness: 1, normal_load: 1, belt_speed: 0.1}\n"
        "friction: {mu_start: 1.3, v_reversal: 0.34, a4: 0.1}\n"
        "axes: {mu_reversal: [1.04, 1.1], mu_stop: [none, 1.2]}\n"
    )
    ds = stickslip.run(stickslip.load_config(config))
    np.testing.assert_array_equal(levels(ds)[LEVEL], levels(config)[LEVEL])


# --- A-weighting ------------------------------------------------------------------------------------------------------

# IEC 61672-1:2013, Table 3: nominal frequency of the third octave (Hz) and design goal (dB).
TABLE = {
    10: -70.4, 12.5: -63.4, 16: -56.7, 20: -50.5, 25: -44.7, 31.5: -39.4, 40: -34.6, 50: -30.2, 63: -26.2, 80: -22.5,
    100: -19.1, 125: -16.1, 160: -13.4, 200: -10.9, 250: -8.6, 315: -6.6, 400: -4.8, 500: -3.2, 630: -1.9, 800: -0.8,
    1000: 0.0, 1250: 0.6, 1600: 1.0, 2000: 1.2, 2500: 1.3, 3150: 1.2, 4000: 1.0, 5000: 0.5, 6300: -0.1, 8000: -1.1,
    10000: -2.5, 12500: -4.3, 16000: -6.6, 20000: -9.3,
}  # fmt: skip


def test_the_table_of_the_standard_is_met_at_all_third_octaves():
    """Its values are rounded to 0.1 dB, at the exact frequencies 1000 x 10^(n/10)."""
    for number, (nominal, goal) in zip(range(-20, 14), TABLE.items(), strict=True):
        exact = 1000.0 * 10.0 ** (number / 10.0)
        assert exact == pytest.approx(nominal, rel=0.03)
        assert abs(decibels(a_weighting(exact)) - goal) <= 0.0501, nominal


def test_a_tone_of_one_kilohertz_is_not_weighted_and_a_constant_not_heard():
    assert a_weighting(1000.0) == 1.0
    assert a_weighting(0.0) == 0.0 and decibels(0.0) == -np.inf


def test_a_map_of_levels_is_drawn_as_the_command_draws_it(tmp_path):
    found = sound.levels(parse_config(PADS))
    assert draws_what_the_command_draws(found, tmp_path) == "map"
    assert "level" in pictures_of(found)[0].caption
