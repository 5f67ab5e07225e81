"""Draws: Sobol points at random access, distributions, and the order of items."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from stickslip.studies.draws import BITS, Design, SobolPoints
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


def test_mixed_matrices_have_one_column_of_the_second_matrix():
    design = Design(quantities=3, draws=8, scramblings=2, seed=1, indices=True)
    matrices = design.normals(design.place(0, design.per_cell)).reshape(2, 5, 8, 3)
    a, b = matrices[:, 0], matrices[:, 1]
    assert not (a == b).any()
    for i in range(3):
        other = np.arange(3) != i
        assert np.array_equal(matrices[:, 2 + i][..., i], b[..., i])
        assert np.array_equal(matrices[:, 2 + i][..., other], a[..., other])
