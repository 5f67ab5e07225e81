"""Draws: points, distributions, order; Sobol indices against closed forms, SciPy, and a double loop; their errors."""

import numpy as np
import pytest
from scipy import stats

from stickslip.studies.draws import BITS, Design, IndexSums, SobolPoints, index_sums, indices_of
from stickslip.theory.distributions import distribution

Z = np.array([-5.0, -2.0, -0.3, 0.0, 0.7, 3.0, 4.0])
PAIRS = [  # ours, SciPy's
    (distribution("normal", (0.8, 0.05)), stats.norm(0.8, 0.05)),
    (distribution("lognormal", (3.0, 1.2)), stats.lognorm(np.log(1.2), scale=3.0)),
    (distribution("uniform", (-1.0, 3.0)), stats.uniform(-1.0, 4.0)),
    (distribution("triangular", (1.0, 1.5, 4.0)), stats.triang(0.5 / 3.0, 1.0, 3.0)),
    (distribution("triangular", (1.0, 1.0, 4.0)), stats.triang(0.0, 1.0, 3.0)),
    (distribution("triangular", (1.0, 4.0, 4.0)), stats.triang(1.0, 1.0, 3.0)),
    (distribution("weibull_min", (2.0, 1.0, 3.0)), stats.weibull_min(2.0, 1.0, 3.0)),
    (distribution("expon", (0.0, 2.0), 1.0), stats.expon(1.0, 2.0)),
    (distribution("normal", (0.8, 0.05), 0.75), stats.truncnorm(-1.0, np.inf, 0.8, 0.05)),
    (distribution("normal", (0.0, 1.0), 4.0, 5.0), stats.truncnorm(4.0, 5.0)),
    (distribution("normal", (0.0, 1.0), high=-4.0), stats.truncnorm(-np.inf, -4.0)),
]


@pytest.mark.parametrize(("ours", "scipys"), PAIRS, ids=map(str, range(len(PAIRS))))
def test_distributions_are_those_of_scipy(ours, scipys):
    below, above = Z[Z <= 0], Z[Z > 0]
    assert ours.at(below) == pytest.approx(scipys.ppf(stats.norm.cdf(below)), rel=1e-9)
    assert ours.at(above) == pytest.approx(scipys.isf(stats.norm.sf(above)), rel=1e-9)


def test_far_in_a_tail_a_distribution_keeps_its_digits():
    assert distribution("normal", (0.8, 0.05)).at(9.0) == 0.8 + 0.05 * 9.0
    share = stats.norm.sf(9.0) * stats.norm.sf(-1.0)  # above 0.8 + 0.05 x, given that the value is above 0.75
    assert distribution("normal", (0.8, 0.05), 0.75).at(9.0) == pytest.approx(0.8 + 0.05 * stats.norm.isf(share))
    below = 4.0 - distribution("triangular", (1.0, 1.5, 4.0)).at(7.0)
    assert below == pytest.approx(np.sqrt(stats.norm.sf(7.0) * 3.0 * 2.5), rel=1e-9)


@pytest.mark.parametrize("count", [1, 2, 64, 2**17])
def test_points_are_those_of_scipy_in_any_order(count):
    ours = SobolPoints(3, count, 7)
    numbers = np.random.default_rng(1).permutation(count)
    for scrambling, child in enumerate(np.random.SeedSequence(7).spawn(2)):
        engine = stats.qmc.Sobol(3, scramble=True, bits=BITS, seed=np.random.default_rng(child))
        scipys = engine.random(count)[numbers] + 0.5**31
        assert np.array_equal(ours.at(np.full(count, scrambling), numbers), scipys)


def test_draws_do_not_depend_on_how_items_are_cut():
    design = Design(quantities=2, draws=16, scramblings=3, seed=1, indices=True)
    whole = design.normals(design.place(0, 2 * design.per_cell))
    parts = [design.normals(design.place(start, min(start + 7, len(whole)))) for start in range(0, len(whole), 7)]
    assert np.array_equal(whole, np.concatenate(parts))
    assert np.array_equal(whole[: design.per_cell], whole[design.per_cell :])  # the same draws in every cell


A, B = 7.0, 0.1  # of the Ishigami function


def ishigami(x):
    """(n, 3) to (n,)."""
    return np.sin(x[:, 0]) + A * np.sin(x[:, 1]) ** 2 + B * x[:, 2] ** 4 * np.sin(x[:, 0])


def ishigami_indices():
    """Closed form: Ishigami and Homma 1990; Saltelli et al. 2008, p. 179."""
    first = np.array([0.5 * (1 + B * np.pi**4 / 5) ** 2, A**2 / 8, 0.0])
    both = B**2 * np.pi**8 * 8 / 225
    variance = first.sum() + both
    return first / variance, np.array([first[0] + both, first[1], both]) / variance


def values_of(design, function):
    """(scramblings, matrices, draws) of a function of uniform numbers from -pi to pi."""
    normals = design.normals(design.place(0, design.per_cell))
    x = distribution("uniform", (-np.pi, np.pi)).at(normals)
    return function(x).reshape(design.scramblings, design.matrices, design.draws)


def estimated(values):
    """First-order and total indices."""
    sums = [index_sums(matrices[0], matrices[1], matrices[2:]) for matrices in values]
    return indices_of(IndexSums(*map(np.array, zip(*sums, strict=True)))).values()


def test_indices_of_the_ishigami_function_are_those_of_the_closed_form_within_their_errors():
    indices = estimated(values_of(Design(3, 4096, 8, 1, True), ishigami))
    for index, exact in zip(indices, ishigami_indices(), strict=True):
        assert (np.abs(index.value - exact) < 3.5 * index.error).all() and (index.error < 0.01).all()


def test_errors_of_indices_are_as_large_as_the_indices_are_wrong():
    off = []
    for seed in range(40):
        indices = estimated(values_of(Design(3, 256, 8, seed, True), ishigami))
        off += [(index.value - exact) / index.error for index, exact in zip(indices, ishigami_indices(), strict=True)]
    # Student's t with 7 degrees of freedom has the variance 7/5; of 240 numbers that vary together, with some leeway.
    assert 0.8 < np.std(off) < 1.6
    assert np.abs(np.mean(off)) < 0.35


def test_one_scrambling_gives_the_indices_of_scipy():
    values = values_of(Design(3, 1024, 1, 3, True), ishigami)[0]
    scipys = stats.sobol_indices(
        func={"f_A": values[0][None], "f_B": values[1][None], "f_AB": values[2:, None]}, n=1024
    )
    first, total = estimated(values[None])
    assert first.value == pytest.approx(scipys.first_order, rel=1e-9)
    assert total.value == pytest.approx(scipys.total_order, rel=1e-9)
    assert np.isnan(first.error).all()  # one scrambling has no error


def test_indices_of_what_does_not_vary_are_not_a_number():
    first, total = estimated(np.ones((4, 5, 16)))
    assert np.isnan(first.value).all() and np.isnan(total.error).all()


def test_one_quantity_alone_explains_all_of_the_variance():
    rng = np.random.default_rng(3)
    sums = IndexSums(rng.random((8, 2, 1)), rng.random((8, 2, 1)), np.stack([rng.random((8, 1)), np.zeros((8, 1))], 1))
    for index in indices_of(sums).values():
        np.testing.assert_array_equal(index.value, [[1.0], [np.nan]])
        np.testing.assert_array_equal(index.error, [[0.0], [np.nan]])
