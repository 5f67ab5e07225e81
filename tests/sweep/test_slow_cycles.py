"""Cycles of contacts with memory to which motions grow, or close, slowly: none is irregular, and none counts twice."""

import numpy as np
import pytest

import stickslip
from helpers.adversary_cells import log_uniform
from helpers.first_return import Bristles, RateAndState, cycle_near, first_cycle, returned
from stickslip.vocabulary.results import STATUSES

CYCLES = [STATUSES.index(name) for name in ("cycle_closed", "slip_cycle")]
GROWS = {  # by 0.7 % a loop, and its slip turns round once it is as large as the speed of the belt
    "mass": 1652.6099745472063, "stiffness": 5310861.751606606, "damping": 0.9084546617531093, "normal_load": 10.0,
    "belt_speed": 0.0020071662193526497, "velocity": 0.0020071662193526497, "mu_0": 0.27489094455069396,
    "v_0": 5.2393098997918666e-05, "a": 0.026254467123302504, "b": 0.0910453606756909, "D_c": 2.077727635550067e-05,
    "contact_time": 0.01035154744792474,
}  # fmt: skip
CLOSES = {  # two loops, of which a deviation keeps 0.94
    "mass": 1.0196171699108263, "stiffness": 24646.50445717706, "normal_load": 88.1090304736023,
    "belt_speed": 0.12325000376998128, "damping": 0.0, "a1": 0.1435715921277015, "a2": 0.0, "a3": 0.3328239845632869,
    "a4": 0.02501722502228063, "contact_stiffness": 72647.87615677272, "contact_damping": 0.0,
}  # fmt: skip


@pytest.mark.parametrize(
    ("cell", "law", "contact", "loops"),
    [
        pytest.param(GROWS, "rate_state_slip", RateAndState, 20, id="grows", marks=pytest.mark.slow),
        pytest.param(CLOSES, "stribeck", Bristles, 200, id="closes", marks=pytest.mark.slow),
    ],
)
def test_a_motion_that_grows_or_closes_slowly_comes_to_its_cycle(cell, law, contact, loops):
    here = contact(cell)
    _, time, (u_high, u_low, w_high, w_low), multipliers = first_cycle(here, loops)
    assert 0.9 < np.abs(multipliers).max() < 1.0
    ds = stickslip.evaluate(cell, law=law).squeeze("cell")
    assert STATUSES[int(ds["status"])] == "cycle_closed"
    assert float(ds["period"]) == pytest.approx(time * here.time, rel=1e-5)
    width = (u_high - u_low) * here.load  # extremes of SciPy are those of its steps
    assert float(ds["cycle_force_max"]) == pytest.approx(u_high * here.load, abs=1e-3 * width)
    assert float(ds["cycle_force_min"]) == pytest.approx(u_low * here.load, abs=1e-3 * width)
    assert 2.0 * float(ds["velocity_amplitude"]) == pytest.approx((w_high - w_low) * here.speed, rel=1e-3)


def slow_cells(seed, n):
    """Cells of the slip law with much inertia and little growth, whose slip rests or runs backwards at the start."""
    rng = np.random.default_rng(seed)
    load, distance, a = log_uniform(rng, 0.1, 1e3, n), log_uniform(rng, 1e-6, 1e-4, n), log_uniform(rng, 3e-3, 0.05, n)
    speed, b = log_uniform(rng, 1e-5, 1e-2, n), a * rng.uniform(1.1, 4.0, n)
    mass = log_uniform(rng, 1.0, 1e5, n) * a * load * distance / speed**2
    critical = (b - a) * load / distance * (1.0 + mass * speed**2 / (distance * a * load))
    cells = {
        "mass": mass, "stiffness": critical * log_uniform(rng, 1e-4, 0.999, n), "normal_load": load, "a": a, "b": b,
        "belt_speed": speed, "mu_0": rng.uniform(0.2, 0.7, n), "v_0": log_uniform(rng, 1e-6, 1e-4, n), "D_c": distance,
        "velocity": speed * rng.choice([1.0, 1.3], n),
        "contact_time": distance / speed * log_uniform(rng, 0.01, 100.0, n),
    }  # fmt: skip
    ratio = stickslip.evaluate(cells, law="rate_state_slip", horizon=1e-9)["damping_ratio"].values
    chosen = (-2e-2 < ratio) & (ratio < -2e-4)
    return {name: values[chosen] for name, values in cells.items()}


def off_periods(cells, which):
    """By how much periods differ from those of the cycle of one loop beside them; NaN where SciPy comes to none.

    It is begun at a contact as in steady slip, from which some of the largest cycles cannot be reached.
    """
    ds = stickslip.evaluate(cells, law="rate_state_slip")
    off = np.full(len(which), np.nan)
    for n, i in enumerate(which):
        here = RateAndState({name: float(values[i]) for name, values in cells.items()})
        try:
            place = returned(here, (float(ds["cycle_force_max"][i]) / here.load, 0.0), 3)[0]
            cycle = cycle_near(here, place)
        except (ArithmeticError, Warning):
            continue
        if cycle is not None:
            time, _, multipliers = cycle
            assert np.abs(multipliers).max() < 1.0
            off[n] = abs(float(ds["period"][i]) / (time * here.time) - 1.0)
    return off


@pytest.mark.slow
def test_cells_with_much_inertia_have_the_period_of_one_loop():
    cells = slow_cells(41, 120)
    ds = stickslip.evaluate(cells, law="rate_state_slip")
    cycles = np.flatnonzero(np.isin(ds["status"].values, CYCLES))
    assert not (ds["status"] == STATUSES.index("irregular")).any()
    assert cycles.size > 0.8 * ds.sizes["cell"] and off_periods(cells, cycles[:1]).max() < 1e-5


@pytest.mark.slow
def test_many_such_cells():
    cells = slow_cells(42, 4000)
    ds = stickslip.evaluate(cells, law="rate_state_slip")
    cycles = np.flatnonzero(np.isin(ds["status"].values, CYCLES))
    assert not (ds["status"] == STATUSES.index("irregular")).any()
    off = off_periods(cells, cycles[::25])
    assert cycles.size > 0.9 * ds.sizes["cell"] and np.nanmax(off) < 1e-5 and np.isfinite(off).mean() > 0.8
