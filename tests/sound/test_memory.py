"""The sound of contacts with memory: of bristles, of rate and state."""

import numpy as np
import pytest

import stickslip
from stickslip import sound
from stickslip_sound.loudness import a_weighting

SQUEAL = {
    "mass": 0.1, "damping": 1.0, "normal_load": 10.0, "stiffness": 5e3, "belt_speed": 0.01, "a1": 0.25, "a2": 0.0,
    "a3": 0.05, "a4": 0.02, "contact_stiffness": 2e4, "contact_damping": 5.0,
}  # fmt: skip
PAIR = {"mass": 1.0, "normal_load": 10.0, "mu_0": 0.6, "v_0": 1e-6, "a": 0.01, "b": 0.018, "D_c": 1e-6}


@pytest.mark.slow
def test_the_sound_of_bristles_is_that_of_their_motion_over_time():
    """Of the last second of a long one."""
    heard = sound.of(SQUEAL, 1.0)
    assert heard.repeats and heard.regime == "sustained"
    found = float(sound.levels(SQUEAL)["acceleration_level_a"][0])
    last = stickslip.simulate(duration=4.0, samples=80_001, rtol=1e-9, **SQUEAL)["acceleration"].values[-20_000:]
    window = np.hanning(last.size)
    power = np.square(np.abs(np.fft.rfft(last * window)) * a_weighting(np.fft.rfftfreq(last.size, 5e-5)))
    wanted = 10.0 * np.log10(2.0 * power.sum() / last.size / np.square(window).sum() / 1e-12)
    assert found == pytest.approx(wanted, abs=0.05)
    assert heard.peak == pytest.approx(np.abs(last).max(), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [1e-4, 1e-6])
def test_the_sound_of_rate_and_state_friction_begins_with_a_slip(speed):
    """Of periods of a second, and of half an hour, of which all but milliseconds is silence."""
    cell = PAIR | {"belt_speed": speed, "stiffness": 2e4 if speed == 1e-4 else 2e3}
    largest = float(stickslip.evaluate(cell, law="rate_state_ageing")["acceleration_max"][0])
    assert sound.of(cell, 1.0, law="rate_state_ageing").peak == pytest.approx(largest, rel=5e-3)
    assert np.isfinite(sound.levels(cell, law="rate_state_ageing")["acceleration_level_a"].values).all()
