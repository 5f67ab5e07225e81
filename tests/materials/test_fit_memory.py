"""Contacts with memory fitted to records that SciPy's Radau draws in other variables than the fit's."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stickslip.errors import ConfigError
from stickslip_materials.fit import fit_memory_file, fit_rate_state

A, B, DISTANCE, DRIVE = 0.01, 0.015, 1e-6, 5e4
STEPS = [(20.0, 1e-6), (15.0, 1e-5), (20.0, 1e-6), (30.0, 0.0), (20.0, 1e-6)]  # duration, speed


def record(law, noise=2e-4, every=0.2):
    """Time, speed and friction of steps and a hold, by ln w and ln theta."""
    v_0 = STEPS[0][1]
    columns, state, begin = [], [np.log(v_0), np.log(DISTANCE / v_0)], 0.0
    for duration, speed in STEPS:

        def slopes(_, s, speed=speed):
            w, theta = np.exp(s)
            x = w * theta / DISTANCE
            healing = (1.0 - x) / theta if law == "rate_state_ageing" else -w / DISTANCE * np.log(x)
            return [(DRIVE * (speed - w) - B * healing) / A, healing]

        times = np.arange(0.0, duration, every)
        solved = solve_ivp(slopes, (0.0, duration), state, "Radau", [*times, duration], rtol=1e-9, atol=1e-11)
        mu = 0.6 + A * (solved.y[0] - np.log(v_0)) + B * (solved.y[1] + np.log(v_0 / DISTANCE))
        columns.append(np.column_stack([begin + times, np.full(times.size, speed), mu[:-1]]))
        state, begin = solved.y[:, -1], begin + duration
    time, speed, mu = np.concatenate(columns).T
    return time, speed, mu + np.random.default_rng(0).normal(0.0, noise, mu.size)


@pytest.mark.parametrize(
    ("law", "stiffness"), [("rate_state_ageing", None), pytest.param("rate_state_slip", DRIVE, marks=pytest.mark.slow)]
)
def test_the_law_is_that_which_drew_the_record(law, stiffness):
    fit = fit_rate_state(*record(law), law=law, stiffness=stiffness)
    assert fit.good, fit.quality
    truth = {"mu_0": 0.6, "a": A, "b": B, "D_c": DISTANCE} | ({} if stiffness else {"drive_stiffness": DRIVE})
    for name, value in truth.items():
        low, high = fit.interval[name]
        assert abs(value - fit.values[name]) < high - low, name  # twice what holds with 95 %
        assert fit.values[name] == pytest.approx(value, rel=0.02)
    assert fit.residual_rms == pytest.approx(2e-4, rel=0.1)


@pytest.mark.slow
def test_another_law_than_that_of_the_record_is_said():
    fit = fit_rate_state(*record("rate_state_ageing"), law="rate_state_slip", stiffness=DRIVE)
    assert not fit.good and "another law" in fit.quality


@pytest.mark.parametrize(("columns", "expected"), [
    ({"speed": np.full(40, 1e-6)}, "1 steps"),
    ({"speed": np.random.default_rng(0).uniform(1.0, 2.0, 40)}, "steps in 40 samples"),
    ({"speed": -np.ones(40)}, "steady sliding at first"),
    ({"time": np.zeros(40)}, "increasing"),
    ({"mu": np.full(40, np.nan)}, "finite"),
    ({"mu": np.ones(39)}, "one for each point"),
])  # fmt: skip
def test_impossible_records_are_refused(columns, expected):
    usual = {"time": np.arange(40.0), "speed": np.repeat([1e-6, 1e-5], 20), "mu": np.full(40, 0.6)}
    with pytest.raises(ValueError, match=expected):
        fit_rate_state(**usual | columns)


def test_files_say_what_they_lack(tmp_path):
    path = tmp_path / "steps.csv"
    path.write_text("time [s], speed [um/s]\n" + "1, 2\n" * 30)
    with pytest.raises(ConfigError, match=r"steps.csv: no column of mu"):
        fit_memory_file(path, "rate_state_ageing")
    path.write_text("time [s], speed [um/s], friction force [N]\n" + "1, 2, 3\n" * 30)
    with pytest.raises(ConfigError, match="load is not known"):
        fit_memory_file(path, "rate_state_ageing")
