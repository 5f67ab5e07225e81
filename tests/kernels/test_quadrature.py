import pytest

from stickslip_kernels.quadrature import gauss


@pytest.mark.parametrize("points", [1, 2, 5, 10])
def test_a_rule_integrates_every_polynomial_it_is_exact_for(points):
    nodes, weights = gauss(points)
    for degree in range(2 * points):
        integral = sum(weight * node**degree for node, weight in zip(nodes, weights, strict=True))
        assert integral == pytest.approx(1.0 / (degree + 1), rel=1e-14)
