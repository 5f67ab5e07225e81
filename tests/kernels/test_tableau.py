"""The pair is of order 5, its embedded one of order 4: Butcher's conditions, not trust in digits typed in."""

import numpy as np
import pytest

from stickslip_kernels.tableau import TSITOURAS_54, ButcherTableau

A = np.array([row + (0.0,) * (7 - len(row)) for row in TSITOURAS_54.matrix])
C = np.array(TSITOURAS_54.nodes)
AC, AC2, AC3 = A @ C, A @ C**2, A @ C**3

# Elementary differentials and 1/density of the rooted trees up to order 5 (Hairer, Norsett & Wanner I, II.2).
TREES = {
    1: [(np.ones(7), 1)],
    2: [(C, 1 / 2)],
    3: [(C**2, 1 / 3), (AC, 1 / 6)],
    4: [(C**3, 1 / 4), (C * AC, 1 / 8), (AC2, 1 / 12), (A @ AC, 1 / 24)],
    5: [
        (C**4, 1 / 5), (C**2 * AC, 1 / 10), (AC**2, 1 / 20), (C * AC2, 1 / 15), (C * (A @ AC), 1 / 30),
        (AC3, 1 / 20), (A @ (C * AC), 1 / 40), (A @ AC2, 1 / 60), (A @ A @ AC, 1 / 120),
    ],
}  # fmt: skip


@pytest.mark.parametrize("order", TREES)
def test_weights_meet_the_conditions_of_order_five(order):
    for differential, density in TREES[order]:
        assert np.dot(TSITOURAS_54.weights, differential) == pytest.approx(density, abs=1e-14)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_embedded_weights_meet_the_conditions_of_order_four(order):
    embedded = np.subtract(TSITOURAS_54.weights, TSITOURAS_54.error_weights)
    for differential, density in TREES[order]:
        assert np.dot(embedded, differential) == pytest.approx(density, abs=1e-13)


def test_embedded_weights_are_not_of_order_five():
    embedded = np.subtract(TSITOURAS_54.weights, TSITOURAS_54.error_weights)
    assert max(abs(np.dot(embedded, tree) - density) for tree, density in TREES[5]) > 1e-4


def test_last_stage_is_the_first_of_the_next_step():
    assert TSITOURAS_54.first_same_as_last


def test_a_row_that_does_not_sum_to_its_node_is_refused():
    with pytest.raises(ValueError, match=r"row 1 .* sum to 0\.5"):
        ButcherTableau((0.0, 0.5), ((), (0.4,)), (0.0, 1.0), (-1.0, 1.0), 2)


@pytest.mark.parametrize(
    ("weights", "errors", "named"), [((0.0, 0.9), (1.0, -1.0), "weights"), ((0.0, 1.0), (1.0, -0.9), "error_weights")]
)
def test_weights_with_wrong_sums_are_refused(weights, errors, named):
    with pytest.raises(ValueError, match=f"^{named} must sum"):
        ButcherTableau((0.0, 0.5), ((), (0.5,)), weights, errors, 2)
