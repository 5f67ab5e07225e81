"""A-weighting, against the table of the standard."""

import numpy as np
import pytest

from stickslip_sound.loudness import a_weighting, decibels

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
