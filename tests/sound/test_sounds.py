"""The sound of a cell: pitch, length, level, silence, and the file."""

import io
import re

import numpy as np
import pytest
from scipy import signal
from scipy.io import wavfile

import stickslip
from helpers.cycles import COULOMB, OTHERS, PAIR, STICKING, UNIT, common_first, coulomb_harmonics, faster, hard_cells
from helpers.data import cases
from stickslip import sound
from stickslip.theory.contacts import coulomb_cycle

SQUEAL = COULOMB | {"stiffness": 2e6, "belt_speed": 0.5}  # 600 Hz
FREE = UNIT | {"a1": 0.5, "a2": 0.0, "a3": 0.0, "a4": 1.0, "belt_speed": 5.0, "velocity": 0.0, "displacement": 0.6}


def tone(samples, rate):
    """The frequency of the strongest line, between the bins of a long transform."""
    spectrum = np.abs(np.fft.rfft(samples * np.hanning(samples.size), 8 * samples.size))
    return np.argmax(spectrum) * rate / (8 * samples.size)


def at_stiffness(frequency):
    return {"stiffness": (2.0 * np.pi * frequency) ** 2}


@pytest.mark.parametrize(("slow", "rate"), [(1.0, 44_100), (1.0, 48_000), (4.0, 44_100), (0.5, 22_050)])
def test_a_free_vibration_sounds_at_its_frequency_over_slow(slow, rate):
    cell = FREE | at_stiffness(1000.0) | {"normal_load": 1e4}
    heard = sound.of(cell, 1.0, slow=slow, rate=rate)
    assert heard.regime == "sustained" and heard.rate == rate and heard.acceleration.size == rate
    assert heard.frequency == pytest.approx(1000.0, rel=1e-8)
    assert tone(heard.acceleration, rate) == pytest.approx(1000.0 / slow, rel=1e-3)


def test_a_decaying_vibration_is_the_exact_exponential():
    """A linear damper, no weakening: a(t) = A exp(-zeta w t) cos(w' t + phase), from the start."""
    k, zeta = at_stiffness(500.0)["stiffness"], 0.005
    cell = FREE | {"stiffness": k, "damping": 2.0 * zeta * np.sqrt(k), "normal_load": 1e4, "displacement": 0.0}
    heard = sound.of(cell, 0.5, full_scale=1e6)
    w, lead = np.sqrt(k), round(0.02 * heard.rate)
    steady = 0.5 * 1e4 / k - 0.0
    lam = w * complex(-zeta, np.sqrt(1.0 - zeta**2))
    # x - x_steady = Re(c exp(lam t)), from x = 0 and v = 0; the acceleration is its second derivative.
    c = -steady * complex(1.0, lam.real / lam.imag)
    times = np.arange(heard.acceleration.size - lead) / heard.rate
    exact = (c * lam**2 * np.exp(lam * times)).real
    inside = slice(200, 10_000)
    error = heard.acceleration[lead:][inside] - exact[inside]
    assert np.abs(error).max() < 2e-3 * np.abs(exact).max()  # what is left of the onset, cut at 20 kHz
    assert heard.frequency == pytest.approx(500.0 * np.sqrt(1.0 - zeta**2), rel=1e-9)
    assert not heard.repeats and "from the start" in heard.described()
    assert np.abs(heard.acceleration[: lead - 100]).max() < 0.02 * heard.peak


def test_stick_slip_has_the_period_of_the_closed_form_and_its_harmonics():
    heard = sound.of(SQUEAL, 1.0, full_scale=1e5)
    period = float(coulomb_cycle(0.1, 2e6, 10.0, 0.5, 0.5, 0.3).period)
    assert heard.frequency == pytest.approx(1.0 / period, rel=1e-8)
    assert tone(heard.acceleration, heard.rate) == pytest.approx(1.0 / period, rel=1e-3)
    exact, _ = coulomb_harmonics(SQUEAL, 0.0, int(20e3 * period), 0.0)
    middle = heard.acceleration[2000:-2000]
    assert np.mean(middle**2) == pytest.approx((2.0 * np.abs(exact) ** 2).sum(), rel=2e-3)


def test_nothing_is_folded_down_from_above_the_band():
    """A naive sampling of the jumps puts lines between the harmonics; here there are none within 100 dB."""
    heard = sound.of(SQUEAL, 2.0, full_scale=1e5)
    spectrum = np.abs(np.fft.rfft(heard.acceleration * signal.windows.blackmanharris(heard.acceleration.size)))
    bins = np.arange(spectrum.size) / 2.0 / heard.frequency  # in harmonics
    between = np.abs(bins - np.rint(bins)) > 0.05
    assert spectrum[between & (bins > 0.5)].max() < 1e-4 * spectrum.max()
    assert spectrum[bins * heard.frequency > 20.1e3].max() < 1e-4 * spectrum.max()


def test_a_cycle_that_lasts_longer_than_the_sound_is_a_stretch_of_it():
    """0.1 Hz: two seconds around one break-away, of the same motion as the cycle."""
    heard, longer = sound.of(PAIR, 2.0, rate=8000), sound.of(PAIR, 12.0, rate=8000)
    assert heard.repeats and heard.frequency == pytest.approx(0.1006, rel=1e-3)
    inside = slice(200, 15_000)
    np.testing.assert_allclose(heard.acceleration[inside], longer.acceleration[inside], atol=2e-3 * longer.peak)


@pytest.mark.parametrize("name", common_first(STICKING))
def test_the_peak_is_that_of_the_cell_but_for_the_overshoot_of_a_limited_band(name):
    law, cell = STICKING[name]
    fast = faster(cell)
    found = stickslip.evaluate(fast, law=law)
    heard = sound.of(fast, 0.5, law=law, full_scale=1e6)
    assert heard.regime == "stick_slip"
    assert 0.7 * float(found["acceleration_max"][0]) < heard.peak < 1.2 * float(found["acceleration_max"][0])


@OTHERS
def test_every_hard_cell_has_a_sound_and_one_that_settles_the_peak_of_its_trajectory(others):
    """Started in slip, thrown at once, sticking for minutes first; of every law."""
    compared = 0
    for regime in ("stick_slip", "settles"):
        for law, cell, row in list(hard_cells(regime, others))[1 :: 3 if regime == "settles" else 8]:
            heard = sound.of(cell, 0.5, law=law)
            assert np.isfinite(heard.acceleration).all() and heard.acceleration.size == 22_050, row
            natural = np.sqrt(cell["stiffness"] / cell["mass"]) / (2.0 * np.pi)
            first = float(stickslip.evaluate(cell, law=law, rtol=1e-9)["breakaway_time"][0])
            if regime == "settles" and 2.0 < natural < 2000.0 and (np.isnan(first) or first < 5.0):
                over = (0.0 if np.isnan(first) else first) + 0.4
                motion = stickslip.simulate(duration=over, samples=40_001, law=law, rtol=1e-9, **cell)
                assert heard.peak == pytest.approx(float(np.abs(motion["acceleration"]).max()), rel=0.35), row
                compared += 1
    assert compared > 5


def test_a_start_that_is_thrown_at_once_is_heard_from_there():
    """A spring too far back for the contact to hold; the first break-away after a stick phase comes later."""
    cell = PAIR | {"mass": 1e-4, "belt_speed": 10.0, "a2": 1e-3, "a4": 10.0, "displacement": -2.0, "damping": 0.02}
    heard = sound.of(cell, 0.5, full_scale=1e6)
    assert not heard.repeats
    motion = stickslip.simulate(duration=0.4, samples=40_001, **cell)
    assert heard.peak == pytest.approx(float(np.abs(motion["acceleration"]).max()), rel=0.15)


def test_a_stuck_cell_is_silent():
    heard = sound.of(PAIR | {"belt_speed": 0.0})
    assert heard.regime == "stuck" and not heard.acceleration.any()


def test_what_is_below_and_above_hearing_is_said():
    assert "below hearing" in sound.of(PAIR).described()
    cell = FREE | at_stiffness(60e3) | {"normal_load": 1e9}
    high, slower = sound.of(cell, 0.5), sound.of(cell, 0.5, slow=10.0)
    assert high.peak == 0.0 and "above hearing" in high.described()
    assert slower.peak > 0.0 and "hearing" not in slower.described()


def test_a_decay_above_hearing_is_not_folded_down_into_it():
    """1 kHz, so much faster that it lies at 1 MHz: silence, not a tone that sampling made."""
    k = at_stiffness(1000.0)["stiffness"]
    cell = FREE | {"stiffness": k, "damping": 0.01 * np.sqrt(k), "normal_load": 1e4}
    assert sound.of(cell, 0.5).peak > 0.0
    heard = sound.of(cell, 0.5, slow=0.001)
    assert heard.peak == 0.0


def test_sounds_of_one_scale_have_levels_in_proportion_to_their_accelerations():
    once, twice = (sound.of(SQUEAL | {"mass": m, "stiffness": 2e7 * m}, 0.3, full_scale=1e4) for m in (0.2, 0.1))
    assert twice.peak / once.peak == pytest.approx(np.abs(twice.samples).max() / np.abs(once.samples).max(), rel=1e-12)
    np.testing.assert_array_equal(once.samples, once.acceleration / 1e4)
    assert not once.clips and "compressed" not in once.described()


def test_clipping_is_soft_and_said():
    heard = sound.of(SQUEAL, 0.3, full_scale=1.0)
    assert heard.clips and np.abs(heard.samples).max() <= 1.0
    quiet = np.abs(heard.acceleration) < 0.9
    np.testing.assert_array_equal(heard.samples[quiet], heard.acceleration[quiet])
    order = np.argsort(heard.acceleration)
    assert (np.diff(heard.samples[order]) >= 0.0).all()
    assert "compressed above 0.9 m/s2" in heard.described()


def test_ends_are_faded():
    heard = sound.of(FREE | at_stiffness(200.0) | {"normal_load": 1e4}, 0.5)
    assert heard.acceleration[0] == heard.acceleration[-1] == 0.0
    assert np.abs(heard.acceleration[:20]).max() < 0.05 * heard.peak


def test_the_file_is_read_back_as_it_was_written():
    heard = sound.of(SQUEAL, 0.25, full_scale=1e3, rate=48_000)
    rate, stored = wavfile.read(io.BytesIO(heard.wav()))
    assert rate == 48_000 and stored.shape == (12_000,) and stored.dtype == np.int16
    np.testing.assert_allclose(stored / 32767.0, heard.samples, atol=0.51 / 32767.0)


def test_it_plays_in_a_notebook():
    html = sound.of(SQUEAL, 0.2)._repr_html_()
    assert html.startswith('<audio controls src="data:audio/wav;base64,UklGR')


@cases("sound.yaml")
def test_numbers_that_make_no_sound_are_refused(wrong, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        sound.of(PAIR, **wrong)


def test_a_cell_of_a_law_that_this_process_does_not_know_names_register_law():
    ds = stickslip.evaluate(PAIR | {"belt_speed": [0.1, 0.2]})
    ds.attrs["configuration"] = ds.attrs["configuration"].replace("stribeck", "elsewhere")
    with pytest.raises(ValueError, match="registered in another process, call register_law here"):
        ds.stickslip.sound(cell=0)
