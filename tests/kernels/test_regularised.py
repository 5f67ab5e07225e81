"""Rate-and-state friction where slip may rest or turn round: against the other form, and against its mirror image."""

import numpy as np

from helpers.kernel_runs import run
from kernels.test_rate_and_state import EVERY_LAW, LAWS, NAMES, columns, draw
from stickslip_kernels import layout as at

TURNED = (at.BELT, at.XI_START, at.ETA_START)


@EVERY_LAW
def test_belts_that_run_backwards_give_the_mirror_image_to_the_bit(law):
    """By either form: a quarter of the cells start at rest on the belt."""
    cells = columns(draw(300, 9))
    cells[at.ETA_START, ::4] = cells[at.BELT, ::4]
    there = run(cells, max_steps=2e4, law=LAWS[law])
    cells[list(TURNED)] *= -1.0
    back = run(cells, max_steps=2e4, law=LAWS[law])
    mirrored = back.copy()
    for high, low in ((at.XI_MAX, at.XI_MIN), (at.CYCLE_XI_MAX, at.CYCLE_XI_MIN)):
        mirrored[high], mirrored[low] = -back[low], -back[high]
    for row in (at.XI_END, at.ETA_END, at.XI_SETTLED):
        mirrored[row] = -back[row]
    np.testing.assert_array_equal(mirrored, there)


@EVERY_LAW
def test_cells_from_rest_on_the_belt_come_to_the_cycles_of_the_logarithms(law):
    """Where friction stays above 20 a both forms are the same law; starts differ, with much inertia steps too."""
    p = draw(500, 14)
    cells = columns(p)
    found = run(cells, 1e-7, max_steps=4e4, law=LAWS[law])
    cells[at.ETA_START] = cells[at.BELT]
    from_rest = run(cells, 1e-7, max_steps=4e4, law=LAWS[law])
    cycles = np.isin(found[at.REGIME], (at.STICK_SLIP, at.SUSTAINED)) & (found[at.STATUS] != at.IRREGULAR)
    cycles &= found[at.CYCLE_XI_MIN] > 20.0 * p["a"]
    same = cycles & (from_rest[at.REGIME] == found[at.REGIME])
    assert same.sum() > 0.9 * cycles.sum() > 40
    for row, off in ((at.PERIOD, 1e-5), (at.CYCLE_XI_MAX, 1e-6), (at.CYCLE_XI_MIN, 1e-6), (at.CYCLE_HEAT, 1e-5)):
        np.testing.assert_allclose(from_rest[row, same], found[row, same], rtol=off)
    rests = np.isin(found[at.REGIME], (at.DAMPED, at.CREEP)) & (found[at.XI_SETTLED] > 20.0 * p["a"])
    assert np.isin(from_rest[at.REGIME, rests], (at.DAMPED, at.CREEP)).mean() > 0.9
    both = rests & np.isfinite(from_rest[at.XI_SETTLED])
    np.testing.assert_allclose(from_rest[at.XI_SETTLED, both], found[at.XI_SETTLED, both], rtol=1e-12)


@EVERY_LAW
def test_the_largest_acceleration_counts_that_at_rest_on_the_belt(law):
    """There nothing but the load acts, and only for a moment."""
    cells = columns(draw(300, 21), 10 ** np.random.default_rng(22).uniform(-3.0, 1.0, 300))
    cells[at.ETA_START] = cells[at.BELT]
    found = run(cells, max_steps=2e4, law=LAWS[law])
    whole = np.isin(found[at.REGIME], (at.DAMPED, at.CREEP))  # of cycles the extremes are theirs
    load = cells[at.XI_START] + cells[at.GAMMA] * cells[at.BELT]
    assert whole.sum() > 100
    assert (found[at.ACCELERATION_MAX, whole] >= load[whole]).all()
    assert (found[at.ACCELERATION_MAX, whole] == load[whole]).any()  # often nothing later is as steep


@EVERY_LAW
def test_no_cell_fails_where_a_heavy_mass_shoots_past_the_belt(law):
    """Thrown a hundred belt speeds past it, so far that the spring pulls backwards harder than friction holds."""
    one = dict(zip(NAMES, (10.0, 1e3, 0.0, 0.0, 1e-2, 0.6, 1e-6, 0.01, 0.018, 1e-6), strict=True))
    n = 40
    p = {name: np.full(n, value) for name, value in one.items()} | {"k": np.geomspace(1e2, 1e6, n)}
    speed = np.sqrt(p["k"] * p["m"]) / p["N"]
    found = run(columns(p, 0.5, -p["v_b"] * np.geomspace(1.0, 1e4, n) * speed), max_steps=2e4, law=LAWS[law])
    assert not np.isin(found[at.REGIME], (at.FAILED, at.NOT_COMPUTED)).any()
    first = run(columns(p, -2.0), max_steps=2e4, law=LAWS[law])  # more than friction from the start
    assert not np.isin(first[at.REGIME], (at.FAILED, at.NOT_COMPUTED)).any()


def test_a_cell_is_the_same_in_any_company():
    """Those of one form among those of the other."""
    cells = columns(draw(120, 15))
    cells[at.ETA_START, ::3] = 1.5 * cells[at.BELT, ::3]
    whole = run(cells, max_steps=1e4, law=LAWS["ageing"])
    for i in (0, 1, 3):
        alone = run(np.ascontiguousarray(cells[:, i : i + 1]), max_steps=1e4, law=LAWS["ageing"])
        np.testing.assert_array_equal(alone[:, 0], whole[:, i])
