"""Features of signals made by hand, whose values are known, with noise and at any sampling rate."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers.rig_signals import record, saw_tooth, times, to_and_fro
from stickslip_rig.api import FeatureSettings, feature_table, features, find_sticks
from stickslip_rig.signals import find_drops, noise_of, spectrum_peak, turning_points

STICK, SLIP, LOW, HIGH, CYCLES = 0.2, 0.01, 2.0, 5.0, 20
PERIOD = STICK + SLIP


def saw_record(rate, noise=0.0, seed=3, **conditions):
    time = times(CYCLES * PERIOD, rate)
    random = np.random.default_rng(seed)
    force = saw_tooth(time, LOW, HIGH, STICK, SLIP) + random.normal(0, noise, time.size)
    return record(time, force, random.normal(0, 1.0, time.size), **conditions)


# --- stick and slip ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [600, 1000, 2500, 10_000, 40_000])
@pytest.mark.parametrize("noise", [0.0, 0.003, 0.02], ids=["clean", "0.1 %", "0.7 %"])
def test_a_saw_tooth_gives_its_sticks_drops_and_forces(rate, noise):
    found = features(saw_record(rate, noise * (HIGH - LOW), normal_load=10.0, drive_speed=0.01))
    blur = 6 * noise * (HIGH - LOW) + (HIGH - LOW) * 2.5 / (rate * SLIP) ** 2  # noise; a peak between two samples
    assert found["sticks"] == CYCLES
    assert CYCLES - 1 <= found["slips"] <= CYCLES
    assert CYCLES - 1 <= found["drops"] <= CYCLES  # the last one does not end within the record
    assert float(found["drop_mean"]) == pytest.approx(HIGH - LOW, abs=2 * blur)
    assert float(found["drop_max"]) == pytest.approx(HIGH - LOW, abs=2 * blur)
    assert float(found["static_force"]) == pytest.approx(HIGH, abs=blur)
    assert float(found["static_friction"]) == pytest.approx(HIGH / 10, abs=blur / 10)
    assert float(found["dynamic_force"]) == pytest.approx((HIGH + LOW) / 2, abs=0.15)
    assert float(found["stick_fraction"]) == pytest.approx(STICK / PERIOD, abs=0.03)
    assert float(found["impulse_rate"]) == pytest.approx(1 / (0.01 * PERIOD), rel=1.01 / CYCLES)  # 1/(v T)
    assert float(found["stick_slip_period"]) == pytest.approx(PERIOD, rel=0.01)


@pytest.mark.parametrize("noise", [0.0, 0.03])
@pytest.mark.parametrize("teeth", [0.0, 2.0], ids=["sliding", "stick-slip"])
def test_a_drive_that_reverses_needs_no_record_of_its_motion(teeth, noise):
    time, half, loading = times(12.0, 2000), 2.0, 20.0
    force = to_and_fro(time, half, loading, 5.0, teeth) + np.random.default_rng(1).normal(0, noise, time.size)
    found = features(record(time, force))
    first, then, per_tooth = 5 / loading, 10 / loading, teeth / loading
    if not teeth:
        assert found["sticks"] == found["slips"] == 6  # one at the start and one after each reversal
        assert found["drops"] == 0
        share = (first + 5 * then) / 12
        assert float(found["stick_fraction"]) == pytest.approx(share, abs=0.02)
    else:
        expected = math.floor((half - first) / per_tooth) + 5 * math.floor((half - then) / per_tooth)
        assert abs(int(found["drops"]) - expected) <= 6  # a slip at a reversal may fall to either side
        assert abs(int(found["sticks"]) - expected) <= 7


def test_the_motion_of_the_drive_distinguishes_standstill_from_sliding():
    """The drive stops for a second while the force stays: stick if the drive is known to be at rest, else sliding."""
    time = times(4.0, 1000)
    velocity = np.where((time > 1.5) & (time < 2.5), 0.0, 0.01)
    moved = np.concatenate([[0], np.cumsum(velocity[:-1]) * 1e-3])
    force = np.minimum(1000.0 * moved, 8.0)
    sliding = (force >= 8.0) & (velocity > 0)
    known = find_sticks(record(time, force, drive_velocity=velocity))
    assert known.count == 2
    assert np.mean(known.flags() == ~sliding) > 0.98
    place = find_sticks(record(time, force, drive_displacement=moved))
    assert np.mean(place.flags() == ~sliding) > 0.95
    assert find_sticks(record(time, force)).count == 1


def test_a_stick_flag_is_believed():
    time = times(2.0, 100)
    flag = (np.mod(time, 0.5) < 0.3).astype(int)
    found = find_sticks(record(time, np.ones_like(time), stick=flag))
    assert found.count == 5
    assert (found.flags() == flag.astype(bool)).all()
    assert found.broke.tolist() == [True] * 4 + [False]


def test_a_stiffness_that_the_force_contradicts_hides_no_stick():
    """A force that often rises just as fast as it ever does sticks then, whatever stiffness times speed may be."""
    time = times(3.0, 1000)
    force = saw_tooth(time, LOW, HIGH, STICK, SLIP)
    rate = (HIGH - LOW) / STICK
    assert find_sticks(record(time, force, stiffness=rate / 0.01, drive_speed=0.01)).count == 15
    for wrong in (1e-3, 0.5, 2.0, 3.0, 1e3):
        found = find_sticks(record(time, force, stiffness=wrong * rate / 0.01, drive_speed=0.01))
        assert found.count == 15 and found.loading == pytest.approx(rate) == found.expected / wrong


def test_where_nothing_breaks_away_nothing_is_made_up():
    time = times(1.0, 500)
    for force in (1e-6 * time, 3.0 + 1e-6 * time):
        found = features(record(time, force, normal_load=10.0))
        assert found["slips"] == 0 and found["drops"] == 0
        for name in ("static_force", "dynamic_force", "time_to_sliding", "drop_mean", "static_friction"):
            assert np.isnan(found[name]), name
        for name in ("energy_per_stroke", "travel", "impulse_rate", "acceleration_max_limited"):
            assert np.isnan(found[name]), name


@settings(max_examples=30)
@given(st.floats(0.01, 100), st.floats(1e-3, 1e3), st.booleans())
def test_features_scale_with_force_and_time(force_scale, time_scale, backward):
    """Units do not matter, nor the direction of the drive."""
    base = features(saw_record(2000))
    time = times(CYCLES * PERIOD, 2000)
    sign = -1.0 if backward else 1.0
    scaled = record(time * time_scale, sign * force_scale * saw_tooth(time, LOW, HIGH, STICK, SLIP))
    found = features(scaled)
    for name, factor in (("sticks", 1.0), ("drops", 1.0), ("stick_fraction", 1.0), ("static_force", force_scale),
                         ("drop_mean", force_scale), ("dynamic_force", force_scale),
                         ("time_to_sliding", time_scale)):  # fmt: skip
        assert float(found[name]) == pytest.approx(float(base[name]) * factor, rel=1e-6), name


# --- drops and turning points -----------------------------------------------------------------------------------------


def test_drops_are_counted_from_a_size_on_and_not_through_zero():
    force = np.array([0, 5, 4.5, 6, 3, 7, -7, -2, -6, -5.9, -6, 0.0])
    found = find_drops(force, 1.0)
    assert found.sizes.tolist() == [3.0, 5.0]
    assert find_drops(force, 0.4).sizes.tolist() == [0.5, 3.0, 5.0]
    assert find_drops(np.zeros(20)).sizes.size == 0


@given(st.lists(st.floats(-10, 10), min_size=3, max_size=60), st.floats(0.1, 5))
def test_turning_points_alternate_and_swing_far_enough(values, threshold):
    array = np.array(values)
    at = turning_points(array, threshold)
    if not at.size:
        assert np.ptp(array) < threshold or at.size == 0
        return
    swings = np.diff(array[at])
    assert (np.diff(at) > 0).all()
    assert (np.abs(swings) >= threshold).all()
    assert (swings[1:] * swings[:-1] < 0).all()
    assert np.ptp(array[at]) == pytest.approx(np.ptp(array))


def test_noise_is_measured_beside_a_signal():
    time = times(5.0, 2000)
    noise = np.random.default_rng(5).normal(0, 0.07, time.size)
    assert noise_of(saw_tooth(time) + noise) == pytest.approx(0.07, rel=0.05)


# --- acceleration -----------------------------------------------------------------------------------------------------


def test_maximum_and_integral_of_a_sine_are_those_of_the_textbook():
    time = times(4.0, 4000)
    found = features(record(time, np.ones_like(time), 3.0 * np.sin(2 * np.pi * 10 * time)))
    assert float(found["acceleration_max"]) == pytest.approx(3.0, rel=1e-4)
    assert float(found["acceleration_integral"]) == pytest.approx(4.0 * 3.0 * 2 / np.pi, rel=1e-4)


def test_uneven_samples_give_the_same_numbers():
    even = times(4.0, 4000)
    random = np.random.default_rng(2)
    uneven = np.sort(np.concatenate([[0.0, 4.0], random.uniform(0, 4.0, 24_000)]))
    results = []
    for time in (even, uneven):
        rec = record(time, saw_tooth(time), 3.0 * np.sin(2 * np.pi * 10 * time))
        results.append(features(rec, FeatureSettings(bandwidth=200.0)))
    names = ("acceleration_integral", "acceleration_max_limited", "static_force", "drop_mean", "stick_fraction")
    for name in names:
        assert float(results[0][name]) == pytest.approx(float(results[1][name]), rel=0.02), name
    assert results[0]["sticks"] == results[1]["sticks"]
    assert float(results[1]["peak_frequency"]) == pytest.approx(10.0, abs=0.05)


def test_an_offset_of_the_sensor_is_subtracted_only_on_request():
    time = times(2.0, 1000)
    rec = record(time, np.ones_like(time), 0.5 + 0.1 * np.sin(2 * np.pi * time))
    assert float(features(rec)["acceleration_integral"]) == pytest.approx(1.0)
    found = features(rec, FeatureSettings(subtract_offset=True))
    assert float(found["acceleration_integral"]) == pytest.approx(2 * 0.1 * 2 / np.pi, rel=1e-3)


def test_a_bandwidth_needs_enough_samples():
    time = times(1.0, 1000)
    with pytest.raises(ValueError, match="600 Hz needs more than 1200 samples per second"):
        features(record(time, np.ones_like(time)), FeatureSettings(bandwidth=600.0))


@given(st.floats(20, 200), st.floats(0.1, 10), st.floats(0, 6))
def test_the_spectrum_shows_a_sine_with_its_frequency_and_amplitude(frequency, amplitude, phase):
    time = times(4.0, 1000)
    wave = amplitude * np.sin(2 * np.pi * frequency * time + phase)
    found, height = spectrum_peak(wave, 1000.0)
    assert found == pytest.approx(frequency, abs=0.05)
    assert height == pytest.approx(amplitude, rel=0.05)


def test_the_spectrum_of_two_sines_shows_the_larger_one():
    time = times(10.0, 1000)
    wave = np.sin(2 * np.pi * 30 * time) + 2 * np.sin(2 * np.pi * 90 * time)
    assert spectrum_peak(wave, 1000.0) == pytest.approx((90, 2), rel=0.02)
    assert np.isnan(spectrum_peak(np.zeros(100), 1000.0)).all()


# --- the drive --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("known", ["drive_velocity", "drive_displacement"])
def test_work_per_stroke_is_force_times_way(known):
    """Coulomb's loop without a spring: force of either sign over a stroke of 20 mm."""
    time = times(8.0, 1000)
    velocity = np.where(np.mod(time, 4.0) < 2.0, 0.01, -0.01)
    place = np.concatenate([[0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1])) * 1e-3])
    signal = {"drive_velocity": velocity, "drive_displacement": place}[known]
    found = features(record(time, 4.0 * np.sign(velocity), **{known: signal}))
    assert found["strokes"] == 4
    assert float(found["travel"]) == pytest.approx(0.08, rel=1e-3)
    assert float(found["energy_per_stroke"]) == pytest.approx(4.0 * 0.02, rel=2e-3)


# --- tables -----------------------------------------------------------------------------------------------------------


def test_a_table_holds_every_record_with_its_conditions_and_units():
    table = feature_table({"a": saw_record(1000, material="felt", normal_load=10.0), "b": saw_record(2000)})
    assert table["record"].values.tolist() == ["a", "b"]
    assert table["material"].values.tolist() == ["felt", ""]
    assert table["normal_load"].values[0] == 10.0 and np.isnan(table["normal_load"].values[1])
    assert all(array.attrs["units"] for array in table.data_vars.values())
    assert "not the rig maker's" in table["model_rpn"].attrs["long_name"]
