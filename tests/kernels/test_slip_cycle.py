"""Slip cycles by the amplitude map: as when every loop is followed, and as SciPy has them."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from helpers.kernel_runs import block_of, cell, run
from stickslip_kernels import layout as at

pytestmark = pytest.mark.slow  # cycles of slip need the Gaussian law
ATTRACTOR = (at.PERIOD, at.CYCLE_HEAT, at.CYCLE_XI_MAX, at.CYCLE_XI_MIN, at.CYCLE_SPEED_RANGE)
WHOLE = (at.XI_MAX, at.XI_MIN, at.SPEED_MAX, at.ACCELERATION_MAX, at.RESTICK_MARGIN)


def draw(count, weakest=-2.7, strongest=-1.0, law="gaussian"):
    """Cells over decades whose steady sliding repels, and whose loops from rest stay clear of standstill."""
    random, columns = np.random.default_rng(8), []
    while len(columns) < count:
        tried = []
        for _ in range(400):
            a3, a4, belt = 10 ** random.uniform([-2.0, -2.0, -2.0], [0.0, 0.5, 0.7])
            friction = (0.3, 10 ** random.uniform(-3.0, 0.0), a3, a4)
            tried.append(cell(belt, friction, gamma=10 ** random.uniform(-4.0, -0.3)))
        cells = block_of(*tried)
        seen = run(cells, until=at.UNTIL_REGIME, law=law)
        ratio = seen[at.DAMPING_RATIO]
        fits = (seen[at.REGIME] == at.SUSTAINED) & (-(10**strongest) < ratio) & (ratio < -(10**weakest))
        columns += [cells[:, i] for i in np.flatnonzero(fits)]
    return np.ascontiguousarray(np.stack(columns[:count], axis=1))


@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
def test_cycles_are_those_of_motions_whose_loops_are_followed(rtol):
    """A cell with a horizon follows every loop, however far away that is; errors grow as loops differ less and less."""
    cells = draw(24)
    mapped = run(cells, rtol, law="gaussian")
    cells[at.HORIZON] = 1e9
    followed = run(cells, 1e-10, law="gaussian")
    assert (mapped[at.REGIME] == at.SUSTAINED).all() and (followed[at.REGIME] == at.SUSTAINED).all()
    allowed = rtol * (1.0 + 0.05 / np.abs(followed[at.DAMPING_RATIO]))
    for row in ATTRACTOR:
        off = np.abs(mapped[row] - followed[row]) / np.abs(followed[row])
        assert (off <= allowed).all(), row
    for row in WHOLE:
        np.testing.assert_allclose(mapped[row], followed[row], rtol=rtol, atol=rtol)
    assert np.median(mapped[at.STEPS]) < 0.35 * np.median(run(cells, rtol, law="gaussian")[at.STEPS])


@pytest.mark.parametrize(("b", "a2", "a3", "a4", "gamma"), [
    (1.3, 0.01, 0.2, 1.3, 0.093), (-1.3, 0.01, 0.2, 1.3, 0.093), (0.6, 0.09, 0.24, 0.5, 0.176),
])  # fmt: skip
def test_a_cycle_is_that_of_scipy(b, a2, a3, a4, gamma):
    """SciPy integrates one loop; the cycle is where it closes."""
    found = run(block_of(cell(b, (0.3, a2, a3, a4), gamma=gamma)), law="gaussian")[:, 0]
    assert found[at.REGIME] == at.SUSTAINED and found[at.STEPS] < 300

    def mu(w):
        return np.sign(w) * (0.3 + a2 * abs(w) + a3 * np.exp(-((w / a4) ** 2)))

    def motion(_, state):
        u, v = state
        return [v, mu(b - v) - u - gamma * v]

    def top(_, state):
        return state[1]

    top.direction = -1.0

    def loop(amplitude):
        tight = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 0.1}
        solved = solve_ivp(motion, (0.0, 8.0), [mu(b) + amplitude, 0.0], events=top, **tight)
        late = solved.t_events[0] > 1.0
        return solved.t_events[0][late][0], solved.y_events[0][late][0, 0] - mu(b)

    amplitude = brentq(lambda a: loop(a)[1] - a, 0.2 * abs(b), 0.99 * abs(b), xtol=1e-12)
    assert found[at.PERIOD] == pytest.approx(loop(amplitude)[0], rel=1e-8)
    assert found[at.CYCLE_XI_MAX] - mu(b) == pytest.approx(amplitude, rel=2e-6)
