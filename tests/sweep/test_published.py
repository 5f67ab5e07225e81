"""Published or independently derived numbers, reproduced through the public calls. m = k = N = 1 throughout."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import i1e

import stickslip
from helpers.nightly import few
from stickslip.vocabulary.models import CURVE_LAWS
from stickslip.vocabulary.results import REGIMES

STICK_SLIP = REGIMES.index("stick_slip")
UNIT = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0}
ARTICLE = {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}

# Stender's bSTAB (case_friction): mu = mud + mud (musd - 1) exp(-v/v0), mud = v0 = 0.5, musd = 2, damping ratio 0.05.
BSTAB = {"damping": 0.1, "a1": 0.5, "a2": 0.0, "a3": 0.5, "a4": 0.5}
# Share of starts, uniform in x in [-2, 2] and x' in [0, 2], that settle to steady sliding, by belt speed (pyBasin).
BASIN = {1.1: 0.0, 1.175: 0.018, 1.25: 0.080, 1.325: 0.1535, 1.4: 0.226, 1.475: 0.298, 1.5: 0.3165, 1.55: 0.382,
         1.625: 0.450, 1.7: 0.5085, 1.775: 0.568, 1.85: 1.0}  # fmt: skip


@pytest.mark.parametrize(("belt_speed", "published"), BASIN.items())
def test_basin_stability_of_steady_sliding_is_that_of_bstab(belt_speed, published):
    """A Monte-Carlo estimate with its own standard error, of at most 0.011; ours has one of 0.007."""
    random = np.random.default_rng(11)
    start = {"displacement": random.uniform(-2, 2, 5000), "velocity": random.uniform(0, 2, 5000)}
    ds = stickslip.evaluate(UNIT | BSTAB | start | {"belt_speed": belt_speed})
    slides = float((ds["regime"] != STICK_SLIP).mean())
    assert slides == pytest.approx(published, abs=3 * np.hypot(0.011, 0.007))
    if published in (0.0, 1.0):
        assert slides == published


def article(belt_speed):
    return ARTICLE | {"belt_speed": belt_speed}


# Derived by SciPy's DOP853 at rtol 1e-9: T, T_slip, T_stick, x_max, x_min, max v_rel.
CYCLES = {
    "bSTAB, slow": (BSTAB | {"belt_speed": 0.8}, 6.5473621, 5.2660418, 1.2813203, 1.6245196, -0.4182350, 1.8212436),
    "bSTAB, fast": (BSTAB | {"belt_speed": 1.775}, 6.3028845, 6.1009293, 0.2019553, 2.4411220, -1.1562127, 3.5726856),
    "article, 0.02": (article(0.02), 28.368513, 4.3147428, 24.053771, 1.3130098, 0.81849223, 0.26349932),
    "article, 0.05": (article(0.05), 14.717913, 4.2313630, 10.486550, 1.3329842, 0.77307565, 0.32875414),
    "article, 0.1": (article(0.1), 9.9445782, 4.3221695, 5.6224087, 1.3674863, 0.72749712, 0.41982039),
    "article, 0.4": (article(0.4), 6.5749247, 5.1425827, 1.4323420, 1.6021826, 0.56006606, 0.92077171),
}  # fmt: skip


@pytest.mark.parametrize("row", CYCLES.values(), ids=CYCLES)
def test_stick_slip_cycles_are_the_tabulated_ones(row):
    cell, period, slip, stick, x_max, x_min, speed = row
    ds = stickslip.evaluate(UNIT | cell, rtol=1e-9).isel(cell=0)
    found = [ds["period"], ds["restick_time"] - ds["breakaway_time"], ds["period"] * ds["stick_fraction"],
             ds["spring_force_max"], ds["spring_force_min"], ds["slip_speed_max"]]  # fmt: skip
    assert list(map(float, found)) == pytest.approx([period, slip, stick, x_max, x_min, speed], rel=2e-7)


def test_energy_per_cycle_is_the_tabulated_one():
    ds = stickslip.evaluate(UNIT | BSTAB | {"belt_speed": [0.8, 1.775]})
    np.testing.assert_allclose(ds["energy_per_cycle"], [2.8845, 5.7828], rtol=2e-5)


def test_coulomb_cycle_has_the_tabulated_numbers():
    flat = {"a1": 0.3, "a2": 0.0, "a3": 0.0, "a4": 1.0, "mu_static": 0.4, "belt_speed": 0.05}
    ds = stickslip.evaluate(UNIT | flat, rtol=1e-10).isel(cell=0)
    assert float(ds["period"]) == pytest.approx(4 + 4.068887872, rel=1e-9)
    assert float(ds["slip_speed_max"]) == pytest.approx(0.1618033989, rel=1e-9)
    assert float(ds["acceleration_max"]) == pytest.approx(0.1118033989, rel=1e-9)
    assert float(ds["energy_per_cycle"]) == pytest.approx(0.1210333, rel=1e-6)


@pytest.mark.parametrize("zeta", [0.01, 0.05, 0.2])
def test_a_damper_ends_coulomb_stick_slip_at_its_exact_critical_speed(zeta):
    """Stick-slip persists iff kappa = d/v exceeds -e^(zeta s) sin(b s)/b, s being the root of e^(zeta s)
    (cos b s - (zeta/b) sin b s) = 1 in (pi/b, 2 pi/b), b = sqrt(1 - zeta^2)."""
    b = np.sqrt(1 - zeta**2)
    s = brentq(lambda s: np.exp(zeta * s) * (np.cos(b * s) - zeta / b * np.sin(b * s)) - 1, np.pi / b, 2 * np.pi / b)
    critical = 0.1 / (-np.exp(zeta * s) * np.sin(b * s) / b)
    flat = {"damping": 2 * zeta, "a1": 0.3, "a2": 0.0, "a3": 0.0, "a4": 1.0, "mu_static": 0.4}
    ds = stickslip.evaluate(UNIT | flat | {"belt_speed": critical * np.array([0.999, 1.001])}, rtol=1e-9)
    assert [REGIMES[r] for r in ds["regime"].values] == ["stick_slip", "damped"]


@pytest.mark.parametrize("stiffness", [1e2, 1e4])
def test_stick_slip_from_stick_ends_where_the_near_harmonic_theory_says(stiffness):
    """I1(z) e^-z / z = a4 (a2 + c/N)/(2 a3), z = v/a4: exact as the stiffness grows."""
    a2, a3, a4 = (ARTICLE[name] for name in ("a2", "a3", "a4"))
    edge = a4 * brentq(lambda z: i1e(z) / z - a4 * a2 / (2 * a3), 1.0, 50.0)
    allowed = 0.01 / np.sqrt(stiffness)
    belts = edge * np.array([1 - allowed, 1 + allowed])
    ds = stickslip.evaluate(UNIT | ARTICLE | {"stiffness": stiffness, "belt_speed": belts})
    assert [REGIMES[r] for r in ds["regime"].values] == ["stick_slip", "damped"]


def test_four_groups_of_numbers_decide_the_motion():
    """Two dimensional sets with equal v/a4, N a3/(a4 sqrt(k m)), damping ratio and a2 a4/a3, and any a1."""
    base = UNIT | ARTICLE | {"belt_speed": 0.1}
    other = {
        "mass": 2.0,
        "stiffness": 8.0,
        "normal_load": 4.0,
        "a1": 0.5,
        "a2": 0.1,
        "a3": 0.06,
        "a4": 0.02,
        "belt_speed": 0.02,
    }
    for cell, rate in ((base, 1.0), (base | {"a1": 0.2}, 1.0), (other, 2.0)):
        ds = stickslip.evaluate(cell, rtol=1e-9).isel(cell=0)
        assert float(ds["period"]) * rate == pytest.approx(9.9445782, rel=1e-7)
        assert float(ds["slip_speed_max"]) / cell["a4"] == pytest.approx(4.1982039, rel=1e-7)


# --- other laws -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_leines_cycle_is_the_derived_one():
    """Leine et al. 1998: mu = 1/(1 + 3 |v|), m = k = 1, c = 0, v = 0.2; the nine digits are derived by SciPy."""
    curve = {"a1": 0.0, "a2": 0.0, "a3": 1.0, "a4": 1 / 3, "belt_speed": 0.2}
    ds = stickslip.evaluate(UNIT | curve, rtol=1e-10, law="rational").isel(cell=0)
    expected = {"period": 12.0010313, "stick_fraction": 0.6420308, "spring_force_max": 1.13394468,
                "spring_force_min": -0.555432688, "slip_speed_max": 1.03990205, "restick_displacement": -0.541006354,
                "acceleration_max": 1.54100635, "energy_per_cycle": 0.758034974}  # fmt: skip
    for name, value in expected.items():
        assert float(ds[name]) == pytest.approx(value, rel=1e-7), name


# Thomsen & Fidlin 2003: mu_s = 0.4, mu_m = 0.25, v_m = 0.5, beta = 0.05, the cubic law.
CUBIC = {"damping": 0.1, "a1": 0.25, "a2": 0.0, "a3": 0.15, "a4": 0.5}


@pytest.mark.slow
@pytest.mark.parametrize(("belt_speed", "period", "stick", "speed"), [
    (0.1, 7.2092968, 2.1488845, 0.26496347),
    (0.2, 6.7994214, 1.6295584, 0.48609553),
    (0.3, 6.4612498, 1.0205796, 0.65839143),
])  # fmt: skip
def test_thomsen_and_fidlins_cycles_are_the_derived_ones(belt_speed, period, stick, speed):
    ds = stickslip.evaluate(UNIT | CUBIC | {"belt_speed": belt_speed}, rtol=1e-9, law="cubic").isel(cell=0)
    found = [float(x) for x in (ds["period"], ds["period"] * ds["stick_fraction"], ds["slip_speed_max"])]
    assert found == pytest.approx([period, stick, speed], rel=3e-8)


@pytest.mark.slow
def test_the_cubic_law_has_a_border_between_stick_slip_and_oscillation_without_sticking():
    """The exact border is 0.395789 (derived); their formula gives 0.3944053. Above v_b1 sliding is stable."""
    threshold = 0.5 * np.sqrt(1 - 4 * 0.05 * 0.5 / (3 * 0.15))
    assert threshold == pytest.approx(0.4409586, abs=1e-7)
    belts = [0.39575, 0.39583, 0.99 * threshold, 1.01 * threshold]
    ds = stickslip.evaluate(UNIT | CUBIC | {"belt_speed": belts}, rtol=1e-8, law="cubic")
    assert [REGIMES[r] for r in ds["regime"].values] == ["stick_slip", "sustained", "sustained", "damped"]


@pytest.mark.slow
@pytest.mark.parametrize(("belt_speed", "amplitude"), [(0.40, 0.379336)])
def test_the_amplitude_of_pure_slip_is_the_derived_one(belt_speed, amplitude):
    """Derived by simulation; their A1 = 2 sqrt(v_b1^2 - v^2) = 0.371184 is 2 % below."""
    cell = UNIT | CUBIC | {"belt_speed": belt_speed}
    ds = stickslip.simulate(duration=2000.0, samples=200_001, rtol=1e-8, law="cubic", **cell)
    settled = ds["displacement"].sel(time=slice(1900, None))
    assert float(settled.max() - settled.min()) / 2 == pytest.approx(amplitude, rel=2e-5)


@pytest.mark.parametrize("law", few(CURVE_LAWS, 1))
def test_every_law_keeps_the_scales(law):
    """A change of the units of mass, length and time changes nothing, ageing and exponent included."""
    cell = UNIT | ARTICLE | {"belt_speed": 0.05, "ageing_rate": 0.05, "ageing_time": 0.3, "contact_time": 2.0}
    cell |= {"delta": 1.7} if law == "stribeck_delta" else {}
    here = stickslip.evaluate(cell, law=law).isel(cell=0)
    m, x, t = 3.0, 0.01, 0.2
    factors = {"mass": m, "stiffness": m / t**2, "normal_load": m * x / t**2, "belt_speed": x / t, "a2": t / x,
               "a4": x / t, "ageing_time": t, "contact_time": t}  # fmt: skip
    there = stickslip.evaluate({name: value * factors.get(name, 1.0) for name, value in cell.items()}, law=law)
    for name, factor in {"period": t, "breakaway_time": t, "spring_force_max": m * x / t**2}.items():
        assert float(there[name][0]) == pytest.approx(float(here[name]) * factor, rel=1e-9), (law, name)
