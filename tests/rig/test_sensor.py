"""What sensors record of a motion."""

import numpy as np
import pytest

from stickslip_rig import simulation as apparatus
from stickslip_rig.sections import Sensor

RATE, OVER = 2000.0, 8
FINE = RATE * OVER
SETTLED = slice(300, -300)  # samples of the record: far from its ends


def sensor(**more):
    return Sensor(**{"rate": RATE, "oversampling": OVER} | more)


def sine(frequency, duration=4.0, over=OVER):
    """A sine between the samples of a motion, and its times."""
    time = (np.arange(round(duration * RATE * over)) + 0.5) / (RATE * over)
    return np.sin(2 * np.pi * frequency * time), time


def gain(frequency, **more):
    """Amplitude recorded of a sine of amplitude 1, at whatever frequency it appears."""
    return float(np.std(apparatus.sensed(sine(frequency)[0], sensor(**more))[SETTLED])) * np.sqrt(2)


def test_what_does_not_change_is_seen_as_it_is():
    for more in ({}, {"bandwidth": 300.0}, {"oversampling": 1}):
        assert apparatus.sensed(np.full(9000, -3.7), sensor(**more)) == pytest.approx(-3.7, rel=1e-9)


@pytest.mark.parametrize("frequency", [1.0, 50.0, 400.0, 800.0])
def test_slow_sines_are_seen_as_they_are_at_the_times_of_the_record(frequency):
    values, time = sine(frequency)
    seen = apparatus.sensed(values, sensor())
    at = apparatus.times(values.size + 1, sensor())
    assert at == pytest.approx(time[::OVER], rel=1e-12)
    assert seen[SETTLED] == pytest.approx(np.sin(2 * np.pi * frequency * at)[SETTLED], abs=2e-4)


@pytest.mark.parametrize("frequency", [1003.0, 1201.0, 1500.0, 1999.0, 2001.0, 3777.0, 7990.0])
@pytest.mark.parametrize("bandwidth", [None, 300.0, 800.0])
def test_nothing_above_half_the_rate_is_aliased(frequency, bandwidth):
    more = {} if bandwidth is None else {"bandwidth": bandwidth}
    assert gain(frequency, **more) < 1e-3  # 60 dB


@pytest.mark.parametrize("bandwidth", [20.0, 300.0, 800.0])
def test_a_sensor_is_3_db_down_at_its_bandwidth_and_falls_by_24_db_an_octave(bandwidth):
    assert gain(bandwidth, bandwidth=bandwidth) == pytest.approx(np.sqrt(0.5), rel=2e-3)
    if bandwidth < 300:
        assert gain(4 * bandwidth, bandwidth=bandwidth) == pytest.approx(4.0**-4, rel=0.02)


def test_a_sensor_with_a_bandwidth_lags_and_shows_nothing_before_it_happens():
    """But for the last low-pass, whose ringing before a jump ends 32 samples away."""
    step = (np.arange(16_000) >= 8000).astype(float)
    seen = apparatus.sensed(step, sensor(bandwidth=50.0))
    at = 8000 // OVER
    assert np.abs(seen[: at - 32]).max() < 1e-12 and np.abs(seen[:at]).max() < 1e-3
    assert 1.05 < seen.max() < 1.15  # the overshoot of a Butterworth filter of order 4 is 10.8 %
    half = int(np.argmax(seen > 0.5))
    assert 0.3 < (half - at) / RATE * 50.0 < 0.6  # it lags by 0.4 of its longest period


def test_times_are_evenly_spaced_at_the_rate_and_in_the_middle_of_a_difference():
    for samples in (130, 129, 137, 138):
        time = apparatus.times(samples, sensor())
        assert time.size == apparatus.sensed(np.zeros(samples - 1), sensor()).size
        assert time[0] == 0.5 / FINE
        assert np.diff(time) == pytest.approx(1 / RATE, rel=1e-12)
        assert time[-1] < (samples - 1) / FINE


def test_a_record_keeps_the_change_of_the_velocity_over_a_jump_of_the_acceleration():
    """The low-pass has the gain 1 for what lasts: the integral of a pulse shorter than a sample is there."""
    velocity = np.where(np.arange(80_001) > 40_003, 0.25, 0.0)
    for more in ({}, {"bandwidth": 300.0}):
        seen = apparatus.sensed(apparatus.accelerations(velocity, sensor(**more)), sensor(**more))
        assert seen.sum() / RATE == pytest.approx(0.25, rel=1e-4)


def test_noise_is_white_has_the_standard_deviation_asked_for_and_is_that_of_its_seed():
    values = np.linspace(0, 1, 100_000)

    def noise(*seed):
        return apparatus.sensed(values, sensor(oversampling=1), 0.3, np.random.default_rng(seed)) - values

    first = noise(1, 0)
    assert np.std(first) == pytest.approx(0.3, rel=0.01) and abs(first.mean()) < 0.005
    assert abs(np.mean(first[1:] * first[:-1])) < 0.005 * 0.3
    assert np.array_equal(first, noise(1, 0))
    for other in (noise(1, 1), noise(2, 0)):
        assert abs(np.corrcoef(first, other)[0, 1]) < 0.02
