"""Small motions of contacts with memory, 10,000 random contacts: against the roots of their equation, found again."""

import numpy as np
import pytest

import stickslip
from stickslip.theory import contacts

COUNT = 10_000
ROUNDING = 1e-11  # relative margin of Hurwitz' determinant below which a sign is one of rounding


def contacts_of(seed):
    """Mass, stiffness and slopes over decades, all four signs of E and S; half of the springs close to critical."""
    random = np.random.default_rng(seed)

    def decades(low, high):
        return 10.0 ** random.uniform(low, high, COUNT)

    mass, stiffness, rate = decades(-6, 6), decades(-6, 8), decades(-6, 8)
    slopes = contacts.Slopes(*(decades(-6, 6) * random.choice([-1.0, 1.0], COUNT) for _ in range(2)), rate)
    critical = contacts.critical_stiffness(mass, slopes)
    near = np.isfinite(critical) & (critical > 0.0) & (random.random(COUNT) < 0.5)
    side = 1.0 + random.choice([-1.0, 1.0], COUNT) * decades(-8, -1)
    return mass, np.where(near, critical * side, stiffness), slopes, critical


def hurwitz(mass, stiffness, slopes):
    """Whether all roots of m s^3 + (m r + E) s^2 + (k + r S) s + k r decay, and by what relative margin."""
    square, linear = mass * slopes.rate + slopes.at_once, stiffness + slopes.rate * slopes.steady
    ahead, behind = square * linear, mass * stiffness * slopes.rate
    return (square > 0.0) & (ahead > behind), np.abs(ahead - behind) / (np.abs(ahead) + behind)


def test_the_critical_stiffness_separates_growth_from_decay_for_all_signs_of_the_slopes():
    mass, stiffness, slopes, critical = contacts_of(1)
    stable, margin = hurwitz(mass, stiffness, slopes)
    certain, at_once, steady = margin > ROUNDING, slopes.at_once > 0.0, slopes.steady > 0.0
    below = np.isfinite(critical) & (stiffness < critical)
    predicted = np.where(at_once, stiffness > critical, below)  # E < 0: unstable above
    np.testing.assert_array_equal(stable[certain], predicted[certain])
    assert (critical[at_once & steady] == 0.0).all() and np.isinf(critical[~at_once & ~steady]).all()
    assert np.isfinite(critical[at_once & ~steady]).all()
    for signs in (at_once & steady, at_once & ~steady, ~at_once & steady, ~at_once & ~steady):
        assert (signs & certain).sum() > 2000
    growth = contacts.small_motions(mass, stiffness, slopes).growth
    fastest = slopes.rate + np.abs(slopes.at_once) / mass + np.sqrt(stiffness / mass)
    certain &= np.abs(growth) > 1e-13 * fastest  # eigenvalues are known to rounding of the largest
    assert certain.mean() > 0.8
    np.testing.assert_array_equal((growth < 0.0)[certain], stable[certain])


def test_growth_and_frequency_are_the_leading_root():
    mass, stiffness, slopes, _ = contacts_of(2)
    ours = contacts.small_motions(mass, stiffness, slopes)
    polynomials = np.stack(
        [mass, mass * slopes.rate + slopes.at_once, stiffness + slopes.rate * slopes.steady, stiffness * slopes.rate],
        axis=1,
    )
    scale = np.cbrt(polynomials[:, 3] / mass)  # s = scale x
    for i in range(COUNT):
        roots = np.roots(polynomials[i] / mass[i] / scale[i] ** np.arange(4)) * scale[i]
        leading = roots[np.argmax(roots.real)]
        size = np.abs(roots).max()
        assert (
            abs(ours.growth[i] - leading.real) < 1e-9 * size
            and abs(ours.frequency[i] - abs(leading.imag)) < 1e-7 * size
        )


def test_at_the_critical_stiffness_motions_neither_grow_nor_decay():
    """i omega is a root there, and where Hurwitz' determinant changes its sign is that stiffness, to 1e-8."""
    mass, _, slopes, critical = contacts_of(3)
    chosen = np.isfinite(critical) & (critical > 0.0)
    omega = contacts.critical_frequency(slopes)[chosen]
    m, k = mass[chosen], critical[chosen]
    r, at_once, steady = slopes.rate[chosen], slopes.at_once[chosen], slopes.steady[chosen]
    even, odd = (m * r + at_once) * omega**2 - k * r, omega * (k + r * steady - m * omega**2)
    assert chosen.sum() > 3000
    np.testing.assert_allclose(even / (k * r), 0.0, atol=1e-9)
    np.testing.assert_allclose(odd / (omega * (k + np.abs(r * steady))), 0.0, atol=1e-9)


def test_a_dataset_says_of_small_motions_what_the_equation_says():
    random, n = np.random.default_rng(5), 64
    cells = {
        "mass": 10.0 ** random.uniform(-2, 2, n), "stiffness": 10.0 ** random.uniform(3, 5, n),
        "damping": random.choice([0.0, 5.0], n), "normal_load": 10.0, "belt_speed": 10.0 ** random.uniform(-3, 0, n),
        "a1": 0.25, "a2": 0.01, "a3": 0.2, "a4": 0.05, "contact_stiffness": 1e5, "contact_damping": 30.0,
        "contact_damping_speed": 0.5,
    }  # fmt: skip
    ds = stickslip.evaluate(cells, max_steps=10)
    v = cells["belt_speed"]
    g, slope = 10.0 * (0.25 + 0.2 * np.exp(-v / 0.05)), -10.0 * 0.2 / 0.05 * np.exp(-v / 0.05)
    drag, rate = cells["damping"] + 0.1, 1e5 * v / g
    at_once, steady = drag + 30.0 * np.exp(-((v / 0.5) ** 2)) * v * slope / g, drag + slope
    for i in range(n):
        m, k = cells["mass"][i], cells["stiffness"][i]
        roots = np.roots([m, m * rate[i] + at_once[i], k + rate[i] * steady[i], k * rate[i]])
        leading = roots[np.argmax(roots.real)]
        assert float(ds["growth_rate"][i]) == pytest.approx(leading.real, abs=1e-9 * np.abs(roots).max())
        assert float(ds["growth_frequency"][i]) == pytest.approx(abs(leading.imag), abs=1e-6 * np.abs(roots).max())
        assert float(ds["damping_ratio"][i]) == pytest.approx(-leading.real / abs(leading), abs=1e-6)
