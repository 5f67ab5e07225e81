"""The regime alone: decided as soon as it is certain, and that of the whole motion."""

import numpy as np
import pytest

from helpers.kernel_runs import NAN, block_of, cell, run
from helpers.nightly import few
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck.laws import LAWS


def draw(law, count, seed):
    """Cells over decades, half of them near where steady sliding loses its stability, half of them in motion."""
    random, columns = np.random.default_rng([seed, *map(ord, law)]), []
    for _ in range(count):
        a1, a3, belt = random.uniform(0.05, 0.6), random.uniform(0.02, 0.6), 10 ** random.uniform(-2.0, 0.7)
        a2, a4, gamma = 10 ** random.uniform([-4.0, -2.5, -5.0], [0.0, 0.7, 0.7])
        if random.random() < 0.15 and law != "cubic":
            a2, a3 = random.choice([-1.0, 1.0], 2) * (a2, a3)
        if random.random() < 0.5:
            steepest = a3 / a4 * np.exp(-belt / a4)
            gamma = max(0.0, (steepest - a2) * (1.0 + random.choice([-1.0, 1.0]) * 10 ** random.uniform(-4.0, -0.3)))
        moving = random.random() < 0.5
        columns.append(cell(
            belt, (a1, a2, a3, a4), gamma, mu_static=max(a1 + a3, 0.01) * random.choice([1.0, 1.3]),
            mu_stop=a1 * random.uniform(0.3, 1.5) if random.random() < 0.3 else NAN, delta=random.uniform(1.0, 2.5),
            ageing=0.05 * (random.random() < 0.15), xi=random.uniform(-3.0, 3.0) if moving else 0.0,
            eta=random.uniform(-2.0, 2.0) * belt if moving else NAN,
        ))  # fmt: skip
    return block_of(*columns)


def compare(law, count, seed):
    """Alone against followed to the end."""
    cells = draw(law, count, seed)
    full, alone = (run(cells, until=until, max_steps=2e4, law=law) for until in (at.UNTIL_METRICS, at.UNTIL_REGIME))
    decided = full[at.REGIME] != at.UNRESOLVED
    np.testing.assert_array_equal(alone[at.REGIME, decided], full[at.REGIME, decided])
    sticks = decided & (full[at.REGIME] == at.STICK_SLIP)
    np.testing.assert_allclose(alone[at.RESTICK_MARGIN, sticks], full[at.RESTICK_MARGIN, sticks], rtol=1e-4)
    off = (alone[at.RESTICK_MARGIN] - full[at.RESTICK_MARGIN])[decided] / np.abs(cells[at.BELT, decided])
    assert np.nanmax(np.abs(off)) < 1e-4
    damped = decided & (full[at.REGIME] == at.DAMPED)
    assert damped.sum() > count / 20 and alone[at.STEPS, damped].sum() < 0.9 * full[at.STEPS, damped].sum()


@pytest.mark.parametrize("law", few(LAWS, 1))
def test_the_regime_alone_is_that_of_the_motion_followed_to_its_end(law):
    compare(law, 1500, 1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("law", LAWS)
def test_the_same_of_many(law, seed):
    compare(law, 20_000, 100 + seed)
