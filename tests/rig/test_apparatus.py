"""How the plate of a simulated rig moves, and what its sensors record of a motion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.scipy_rig import trapezoidal
from stickslip_rig import simulation as apparatus
from stickslip_rig.sections import Drive, Sensor
from stickslip_rig.simulation import motion, segments

SPEED, STROKE, RAMP = 0.02, 0.01, 0.05


def made(profile="trapezoid", strokes=2, stroke=STROKE, ramp=RAMP, dwell=0.0, wait=0.0):
    quantities = {"belt_speed": SPEED, "stroke": stroke, "ramp": ramp, "dwell": dwell, "waiting_time": wait}
    return segments(Drive(profile=profile, strokes=strokes), quantities)


def ways(drive):
    """How far each segment goes."""
    duration, speed, acceleration = drive.T
    return duration * (speed + 0.5 * acceleration * duration)


def turns(drive):
    """Where the plate is whenever it stands still."""
    ends = np.cumsum(ways(drive))
    return ends[np.isclose(drive[:, 1] + drive[:, 0] * drive[:, 2], 0.0, atol=1e-15)]


drives = st.builds(
    made,
    profile=st.sampled_from(["trapezoid", "sine"]),
    strokes=st.integers(1, 7),
    stroke=st.floats(1e-3, 0.5),
    ramp=st.floats(1e-4, 0.05),
    dwell=st.sampled_from([0.0, 0.1, 2.0]),
    wait=st.sampled_from([0.0, 0.3, 600.0]),
)


@given(drives)
def test_speed_is_continuous_and_starts_and_ends_at_standstill(drive):
    end_speeds = drive[:, 1] + drive[:, 0] * drive[:, 2]
    assert drive[0, 1] == 0.0
    assert end_speeds[:-1] == pytest.approx(drive[1:, 1], abs=1e-14)
    assert end_speeds[-1] == pytest.approx(0.0, abs=1e-14)
    assert (drive[:, 0] > 0).all() and np.abs(drive[:, 1]).max() <= SPEED


@given(drives)
def test_motion_is_the_integral_of_the_segments(drive):
    whole = drive[:, 0].sum()
    ends = np.cumsum(drive[:, 0])
    speed, way = motion(drive, ends)
    assert way == pytest.approx(np.cumsum(ways(drive)), abs=1e-12)
    assert speed == pytest.approx(drive[:, 1] + drive[:, 0] * drive[:, 2], abs=1e-10)
    # the speed is linear between the ends of segments, so a trapezoid between any two times of one is exact
    middle = ends - 0.5 * drive[:, 0]
    time = np.sort(np.concatenate([[0.0], middle, ends]))
    speed, way = motion(drive, time)
    assert way[-1] == pytest.approx(np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time)), abs=1e-9)
    assert motion(drive, np.array([0.0, whole]))[1][0] == 0.0


@pytest.mark.parametrize("profile", ["trapezoid", "sine"])
@pytest.mark.parametrize("stroke", [RAMP * SPEED, STROKE, 0.3])
def test_strokes_are_exact_in_length_and_come_back_to_where_they_began(profile, stroke):
    drive = made(profile, 5, stroke)
    rest = turns(drive)
    assert rest == pytest.approx([stroke, 0.0, stroke, 0.0, stroke], rel=1e-12, abs=1e-15)


def test_a_sine_reaches_its_top_speed_in_the_middle_of_a_stroke():
    drive = made("sine", 1)
    whole = drive[:, 0].sum()
    speed, way = motion(drive, np.array([0.25, 0.5, 0.75]) * whole)
    assert speed == pytest.approx(SPEED * np.sin(np.pi * np.array([0.25, 0.5, 0.75])), rel=1e-12)
    assert way[1] == pytest.approx(STROKE / 2, rel=1e-12)
    # the segments lie inside the sine, so a stroke takes a little longer than its pi/2 stroke/speed: (pi/64)^2/12
    assert 0 < whole / (0.5 * np.pi * STROKE / SPEED) - 1 < 3e-4
    fine = np.linspace(0, whole, 10_001)
    assert motion(drive, fine)[0] == pytest.approx(SPEED * np.sin(np.pi * fine / whole), abs=SPEED * (np.pi / 64) ** 2)


@given(
    st.sampled_from(["trapezoid", "sine"]), st.integers(1, 6), st.floats(1e-3, 0.5), st.floats(0, 3), st.floats(0, 9)
)
def test_the_duration_is_that_of_the_segments_after_the_waiting_time(profile, strokes, stroke, dwell, wait):
    quantities = {"belt_speed": SPEED, "stroke": stroke, "ramp": RAMP, "dwell": dwell, "waiting_time": wait}
    whole = made(profile, strokes, stroke, dwell=dwell, wait=wait)[:, 0].sum()
    arrays = {name: np.array([value]) for name, value in quantities.items()}
    assert Drive(profile=profile, strokes=strokes).duration(arrays) == pytest.approx([whole - wait], rel=1e-9)


def test_a_trapezoid_is_that_of_the_reference():
    drive = made(strokes=3, dwell=0.1, wait=2.0)
    assert drive == pytest.approx(np.array(trapezoidal(STROKE, SPEED, RAMP, 0.1, 3, 2.0)), rel=1e-12)


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
