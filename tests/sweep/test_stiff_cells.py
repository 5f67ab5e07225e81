"""Cells in which friction all but balances the load, and cells that change too little in a loop to be followed.

Both once ended at the step limit. Answers come from SciPy's Radau method, and from the engine with a large budget.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stickslip
from helpers.adversary_cells import draw
from helpers.nightly import few
from stickslip.vocabulary.results import REGIMES, STATUSES

UNIT = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0}
BAND = 1e-4
FEW = 5000  # steps; explicit ones were ten to a hundred times as many

CREEP = {
    "from above": {"belt_speed": 0.00555, "a1": 0.322, "a2": 0.00203, "a3": 0.898, "a4": 0.00343},
    "from above, steeper": {"belt_speed": 0.0104, "a1": 0.176, "a2": 0.0, "a3": 1.14, "a4": 0.0071},
    "with a damper": {"belt_speed": 0.00482, "damping": 3.05, "a1": 0.782, "a2": 0.0, "a3": 1.54, "a4": 0.00382},
    "from below": {"belt_speed": 0.1, "damping": 40.0, "a1": 0.5, "a2": 0.0, "a3": 0.1, "a4": 0.5, "displacement": 1.0},
}  # fmt: skip
RELAXATION = {
    "damped": {"belt_speed": 0.000191, "damping": 15.3, "a1": 0.406, "a2": 0.0392, "a3": 0.918, "a4": 0.00111},
    "not damped": {"belt_speed": 0.00104, "damping": 0.000178, "a1": 0.0402, "a2": 0.0267, "a3": 0.758, "a4": 0.00162},
    "slow belt": {"belt_speed": 0.00011, "damping": 0.000886, "a1": 0.242, "a2": 2.65e-5, "a3": 2.2, "a4": 0.00183},
}  # fmt: skip
BARRIER = {"damping": 0.00101, "belt_speed": 0.08883, "a1": 0.4034, "a2": -0.05841, "a3": -0.3516, "a4": 0.001083}


def evaluate(cell, law, rtol=1e-6, **options):
    """What the engine says of one cell, by name, with the words of its flags."""
    ds = stickslip.evaluate(UNIT | cell, law=law, rtol=rtol, **options).isel(cell=0)
    found = {name: ds[name].item() for name in ds.data_vars}
    return found | {"regime": REGIMES[found["regime"]], "status": STATUSES[found["status"]]}


def friction(cell, law):
    def mu(w):
        z = w / cell["a4"]
        shape = np.exp(-z) if law == "stribeck" else 1.0 - 1.5 * z + 0.5 * z**3
        return cell["a1"] + cell["a2"] * w + cell["a3"] * shape

    return mu


def slip(cell, law, state, until, **options):
    """Radau from (displacement, slip speed) to an event."""
    mu, b, gamma = friction(cell, law), cell["belt_speed"], cell.get("damping", 0.0)

    def motion(t, state):
        x, w = state
        return b - w, x + gamma * (b - w) - mu(w)

    until.terminal = True
    return solve_ivp(motion, (0.0, 1e7), state, method="Radau", events=until, rtol=1e-9, atol=1e-13, **options)


def breakaway(cell, law):
    mu = friction(cell, law)
    return mu(0.0) - cell.get("damping", 0.0) * cell["belt_speed"], 0.0


@pytest.mark.slow
@pytest.mark.parametrize("cell", CREEP.values(), ids=CREEP)
def test_stiff_creep_settles_in_few_steps_when_radau_says(cell):
    mu, b = friction(cell, "cubic"), cell["belt_speed"]
    start = breakaway(cell, "cubic") if "displacement" not in cell else (cell["displacement"], 1e-12)
    band = BAND * np.hypot(start[0] - mu(b), b)

    def enters(t, state):
        return np.hypot(state[0] - mu(b), state[1] - b) / band - 1.0

    found = evaluate(cell, "cubic")
    assert (found["regime"], found["status"]) == ("creep", "settled")
    assert found["steps"] < FEW
    assert found["settling_time"] == pytest.approx(slip(cell, "cubic", start, enters).t[-1], rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
@pytest.mark.parametrize("cell", RELAXATION.values(), ids=RELAXATION)
def test_relaxation_cycles_have_the_period_of_radau(cell, rtol):
    def stops(t, state):
        return state[1] if t > 0.0 else 1.0

    stops.direction = -1
    start = breakaway(cell, "cubic")
    motion = slip(cell, "cubic", start, stops)
    period = motion.t[-1] + (start[0] - motion.y[0, -1]) / cell["belt_speed"]
    found = evaluate(cell, "cubic", rtol)
    assert (found["regime"], found["status"]) == ("stick_slip", "cycle_closed")
    assert found["steps"] < FEW
    assert found["period"] == pytest.approx(period, rel=1e-5 if rtol > 1e-8 else 2e-8)


def test_a_cycle_that_has_converged_when_first_looked_at_is_pushed_off_and_come_back_to():
    def turns(t, state):
        return state[1] - BARRIER["belt_speed"]

    turns.direction = 1
    cycle = slip(BARRIER, "stribeck", (0.6, 0.0888301), turns, first_step=1e-3)
    while True:
        again = slip(BARRIER, "stribeck", (cycle.y[0, -1], BARRIER["belt_speed"] * (1 + 1e-12)), turns)
        if abs(again.y[0, -1] - cycle.y[0, -1]) < 1e-9:
            break
        cycle = again
    found = evaluate(BARRIER, "stribeck")
    assert (found["regime"], found["status"]) == ("sustained", "slip_cycle")
    assert found["period"] == pytest.approx(again.t[-1], rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("cell", [
    {"damping": 13.4, "a1": 0.662, "a2": 1.24, "a3": 0.00591, "a4": 0.00305, "displacement": -0.697, "velocity": 0.559},
    {"damping": 3.0, "a1": 0.5, "a2": 0.0, "a3": 0.01, "a4": 0.1, "displacement": 2.0},
], ids=["reverse", "forward"])  # fmt: skip
def test_slip_that_creeps_to_rest_on_a_belt_at_rest_is_stuck(cell):
    found = evaluate(cell | {"belt_speed": 0.0}, "cubic")
    assert (found["regime"], found["status"]) == ("stuck", "never_breaks_away")
    side = 1.0 if cell["displacement"] > 0.0 else -1.0
    assert found["settled_displacement"] == pytest.approx(side * (cell["a1"] + cell["a3"]), rel=1e-12)


SLOW = {  # law, budget, cell
    "decays": ("stribeck", 3000, {"belt_speed": 0.27, "a1": 0.157, "a2": 1.6e-3, "a3": 3.4e-3, "a4": 2.0}),
    "grows": (
        "rational",
        3000,
        {"belt_speed": 2.4, "a1": 1.0, "a2": 0.0, "a3": 0.02115, "a4": 0.0629, "velocity": 0.02, "displacement": 1.0},
    ),
    "slips both ways": (
        "stribeck",
        20_000,
        {"belt_speed": 0.00136, "a1": 0.0, "a2": 2.66e-5, "a3": 0.00285, "a4": 0.00226, "displacement": 0.2},
    ),
}


@pytest.mark.parametrize("case", few(SLOW, ["decays", "slips both ways"]))
def test_what_takes_too_many_loops_ends_as_it_does_when_followed(case):
    law, budget, cell = SLOW[case]
    followed, found = evaluate(cell, law, 1e-9, max_steps=3_000_000), evaluate(cell, law, max_steps=budget)
    assert followed["steps"] > 2 * budget
    assert found["steps"] <= budget
    assert found["regime"] == followed["regime"] in ("damped", "stick_slip")
    assert found["period"] == pytest.approx(followed["period"], rel=1e-5, nan_ok=True)
    assert np.isnan(found["settling_time"])


@pytest.mark.parametrize("law", few(["stribeck", "stribeck_delta", "rational", "cubic"], 1))
def test_of_cells_drawn_over_decades_few_are_unresolved(law):
    _, cells = draw("wide", 1500, np.random.default_rng(25))
    if law == "cubic":
        cells["a4"] = np.maximum(cells["a4"], np.abs(cells["belt_speed"]) / 1.5)
    regimes = np.array(REGIMES)[stickslip.evaluate(cells, law=law)["regime"]]
    assert (
        np.mean(regimes == "unresolved") <= 0.011
    )  # two of three near a border, out of steps at the tighter tolerance
