"""A cell's numbers are its own: they depend on no neighbour, lane, block or unit."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers.kernel_runs import NAN, block_of, cell, run
from stickslip_kernels import layout as at

columns = st.builds(
    cell,
    belt=st.floats(-1.5, 1.5),
    curve=st.tuples(st.floats(0.1, 1.5), st.floats(0.0, 1.0), st.floats(0.0, 0.8), st.floats(0.02, 1.0)),
    gamma=st.sampled_from([0.0, 0.05, 2.0]),
    mu_stop=st.one_of(st.just(NAN), st.floats(0.1, 1.5)),
    xi=st.floats(-2.0, 2.0),
    eta=st.one_of(st.just(NAN), st.floats(-2.0, 2.0)),
    horizon=st.floats(0.1, 60.0),
)


@settings(max_examples=50)
@given(st.lists(columns, min_size=1, max_size=90), st.randoms(use_true_random=False), st.integers(0, 2))
def test_numbers_do_not_depend_on_lane_neighbours_or_block(cells, random, until):
    order = list(range(len(cells)))
    random.shuffle(order)
    few = {"until": until, "max_steps": 2e3}  # cells of a belt speed of 1e-308 would take a million
    together = run(block_of(*cells), **few)
    shuffled = run(block_of(*(cells[i] for i in order)), **few)
    np.testing.assert_array_equal(shuffled, together[:, order])
    alone = [run(block_of(c), **few)[:, 0] for c in cells[:3]]
    np.testing.assert_array_equal(np.array(alone).T, together[:, :3])


def test_a_stopped_block_leaves_its_cells_not_computed_and_an_empty_one_is_done_at_once():
    results = run(block_of(*(cell(0.1) for _ in range(100))), stop=1)
    assert (results[at.STATUS] == at.NOT_RUN).all()
    assert (results[at.REGIME] == at.NOT_COMPUTED).all()
    assert run(np.empty((at.CELL_ROWS, 0))).shape == (at.RESULT_ROWS, 0)
