"""Cycles are closed at their first return, and starts beside a separatrix re-stick where they should: by SciPy."""

import numpy as np
import pytest

import stickslip
from helpers.adversary_cells import log_uniform
from helpers.plain_slip import PlainSlip
from stickslip.vocabulary.quantities import REGIMES

UNIT = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0}
BOX = {"displacement": (-50.0, 50.0), "velocity": (-50.0, 50.0)}


def row(cells, i):
    return {name: float(values[i]) for name, values in cells.items()}


def bistable_cells(seed, n):
    """Stribeck curves with damping beyond the loss of stability by a hundredth of a percent to twice."""
    rng = np.random.default_rng(seed)
    a3, a4 = log_uniform(rng, 1e-2, 1.0, n), log_uniform(rng, 1e-3, 1.0, n)
    damping = a3 / a4 * log_uniform(rng, 1e-4, 0.95, n)  # that of the curve included
    a2 = damping * rng.choice([0.0, 0.3, 1.0], n)
    belt = a4 * np.log(a3 / (a4 * damping)) * (1.0 + log_uniform(rng, 1e-4, 2.0, n))
    return {"a1": rng.uniform(0.05, 1.0, n), "a2": a2, "a3": a3, "a4": a4, "belt_speed": belt, "damping": damping - a2}


SEVERAL = [  # a1 to a4, belt speed, damping: gone through 3, 2 and 4 times once, as Newton's method began far off
    (0.2577093104782871, 1.046042442541132, 0.06467213033636238, 0.010797417510143499, 0.023016403259083953,
     0.014182657090878568),
    (0.7530015214924147, 0.0, 0.2892585112275274, 0.008897085645654425, 0.027276204835365556, 1.835018959484461),
    (0.30510423684400834, 0.0, 0.719251920894166, 0.022761029664226815, 0.06291744847175307, 2.080336491509417),
]  # fmt: skip


def unstable_cycles(cells):
    """Those of the cells that have one, and what `attractors` says of it."""
    sticks = stickslip.evaluate(UNIT | cells, variables=["regime"])["regime"].values == REGIMES.index("stick_slip")
    cells = {name: values[sticks] for name, values in cells.items()}
    ds = stickslip.attractors(UNIT | cells, box=BOX, samples=16)
    known = np.isfinite(ds["unstable_period"].values)
    return {name: values[known] for name, values in cells.items()}, ds.isel(cell=known)


@pytest.mark.parametrize("n", [30, pytest.param(1400, marks=pytest.mark.slow)])
def test_unstable_cycles_are_closed_at_their_first_return(n):
    names = ("a1", "a2", "a3", "a4", "belt_speed", "damping")
    several = dict(zip(names, np.transpose(SEVERAL), strict=True))
    cells, ds = unstable_cycles(
        {name: np.append(several[name], values) for name, values in bistable_cells(5, n).items()}
    )
    assert ds.sizes["cell"] > 0.7 * n and np.isin(several["a1"], cells["a1"]).all()
    for i in range(ds.sizes["cell"]):
        motion, reach = PlainSlip(row(cells, i), way=-1.0), float(ds["critical_shift_along"][i])
        period, states = motion.loop(motion.steady + reach)
        assert float(ds["unstable_period"][i]) == pytest.approx(period, rel=1e-5), row(cells, i)
        assert states[0, -1] - motion.steady == pytest.approx(reach, rel=1e-5)
        assert np.isfinite(ds["critical_shock"][i])


def test_starts_beside_a_separatrix_restick_where_scipy_says():
    """Errors of 1e-6 grow there by up to a hundred thousand until the motion comes to rest on the belt."""
    cells, ds = unstable_cycles(bistable_cells(6, 400))
    chosen = ds["damping_ratio"].values > 0.03  # others turn hundreds of times
    cells = {name: values[chosen] for name, values in cells.items()}
    beyond = ds["critical_shift_along"].values[chosen] * (
        1.0 + log_uniform(np.random.default_rng(7), 1e-5, 0.1, chosen.sum())
    )
    motions = [PlainSlip(row(cells, i)) for i in range(beyond.size)]
    starts = {"displacement": beyond + [motion.steady for motion in motions], "velocity": np.zeros(beyond.size)}
    ours = stickslip.evaluate(UNIT | cells | starts)["restick_displacement"].values
    assert beyond.size > 20
    for i, motion in enumerate(motions):
        place, loops = motion.restick(starts["displacement"][i])
        assert abs(ours[i] - place) < (1e-5 + 1e-6 * loops) * motion.static, row(cells | starts, i)
