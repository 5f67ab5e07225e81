"""The acceleration as a Fourier series, against closed forms, SciPy, and sums over many samples."""

import numpy as np
import pytest
from scipy import integrate

import stickslip
from helpers.cycles import COULOMB, OTHERS, STICKING, SUSTAINED, common_first, coulomb_harmonics, hard_cells
from helpers.scipy_oscillator import SHAPES
from stickslip.engine import Options, compute, sampled
from stickslip.vocabulary.cells import Cells, as_cells
from stickslip_sound.series import Series, cycles_of, samples_for, series_of

CASES = STICKING | SUSTAINED


def results_of(cell, options):
    """What becomes of a cell."""
    return compute(Cells.of(as_cells(cell)), options).results


def series(law, cell, count, oversampling=8, rtol=1e-9, lead=0.02):
    """The series of the cycle of a cell, and the cycle."""
    options = Options(law, rtol)
    cycles = cycles_of(as_cells(cell), results_of(cell, options), lead)
    intervals = samples_for(cycles.period, count / float(cycles.period[0]), np.zeros(1), oversampling)
    motions, ends, _ = sampled(cycles.cells, cycles.period / intervals, intervals + 1, options)
    return series_of(motions[0], ends[0], float(cycles.period[0]), count), cycles


def samples(law, cycles, count):
    """The motion over one period by `simulate`, the end left out."""
    start = {name: float(values[0]) for name, values in cycles.cells.items()}
    period = float(cycles.period[0])
    return stickslip.simulate(duration=period, samples=count + 1, law=law, rtol=1e-9, **start).isel(time=slice(-1))


@pytest.mark.parametrize("damping", [0.0, 2.0])
@pytest.mark.parametrize(("oversampling", "allowed"), [(4, 1e-5), (8, 1e-6), (16, 2e-7)])
def test_harmonics_of_a_coulomb_cycle_are_those_of_its_closed_form(damping, oversampling, allowed):
    """The acceleration jumps at break-away and at re-stick: harmonic 1000 is as far from aliasing as the first."""
    found, cycles = series("stribeck", COULOMB | {"damping": damping}, 1000, oversampling)
    slip = float(coulomb_harmonics(COULOMB, damping, 1, 0.0)[1].slip_time)
    exact, cycle = coulomb_harmonics(COULOMB, damping, 1000, float(cycles.moving[0]) - slip)
    assert found.duration == pytest.approx(float(cycle.period), rel=1e-9)
    assert np.abs(found.harmonics - exact).max() < allowed * np.abs(exact).max()


@pytest.mark.parametrize("name", common_first(CASES))
def test_harmonics_are_those_of_many_samples_of_the_acceleration(name):
    """64 samples a harmonic; those of a signal that jumps are worth 1/samples."""
    law, cell = CASES[name]
    found, cycles = series(law, cell, 500)
    many = samples(law, cycles, 64 * 500)["acceleration"].values
    brute = np.fft.rfft(many, norm="forward")[1:501]
    assert np.abs(found.harmonics - brute).max() < 2.0 * np.abs(many).max() / many.size
    assert abs(found.mean) < 1e-7 * np.abs(many).max()


@pytest.mark.parametrize(
    "name",
    [
        "stribeck",
        "damped",
        "peak of static friction",
        "ageing",
        pytest.param("gaussian", marks=pytest.mark.slow),
        pytest.param("rational", marks=pytest.mark.slow),
    ],
)
def test_squares_sum_to_what_scipy_integrates_over_the_slip(name):
    """DOP853 and quad, which know nothing of the kernels; break-away is where the kernels say."""
    law, given = STICKING[name]
    cell = {name: float(values[0]) for name, values in as_cells(given).items()}
    broke = float(results_of(given, Options(law, 1e-10))["mu_breakaway"][0])
    a1, a2, a3, a4, c, belt = (cell[key] for key in ("a1", "a2", "a3", "a4", "damping", "belt_speed"))

    def acceleration(x, v):
        w = belt - v
        return a1 + a2 * w + a3 * SHAPES[law](np.maximum(w, 0.0) / a4, cell["delta"]) - c * v - x

    def speed(_, state):
        return belt - state[1]

    speed.terminal, speed.direction = True, -1
    start = [broke - c * belt + 1e-9 * belt, belt - 1e-12 * belt]
    slip = integrate.solve_ivp(
        lambda _, s: [s[1], acceleration(*s)], (0.0, 50.0), start, "DOP853",
        events=speed, dense_output=True, rtol=1e-11, atol=1e-13,
    )  # fmt: skip
    duration, (began, _), (ended, _) = slip.t_events[0][0], start, slip.y[:, -1]
    square, _ = integrate.quad(lambda t: float(acceleration(*slip.sol(t))) ** 2, 0.0, duration, limit=500)
    found, cycles = series(law, given, 4000, rtol=1e-10)
    jump = abs(acceleration(*slip.sol(duration))) + abs(acceleration(*slip.sol(1e-9)))
    rest = jump**2 / (2.0 * np.pi**2 * 4000)
    mean = square / float(cycles.period[0])
    assert mean - rest - 1e-5 * mean <= found.mean_squares.sum() <= mean + 1e-5 * mean
    assert float(cycles.period[0]) == pytest.approx(duration + (began - ended) / belt, rel=2e-5)


@OTHERS
def test_every_hard_cell_returns_to_where_its_cycle_began(others):
    """All laws, parameters over decades, ageing, hysteresis: a third of the 216 cells with stick-slip."""
    for law, cell, row in list(hard_cells("stick_slip", others))[::3]:
        found, cycles = series(law, cell, 200)
        motion = samples(law, cycles, 64 * 200)
        many = motion["acceleration"].values
        brute = np.fft.rfft(many, norm="forward")[1:201]
        allowed = 3.0 * float(row["acceleration_max"]) / many.size
        assert np.abs(found.harmonics - brute).max() < allowed, (law, cell)
        assert np.var(motion["velocity"].values) > 0.0
        assert abs(found.mean) < 1e-6 * float(row["acceleration_max"])


def test_a_stretch_of_any_motion_is_a_series_with_the_mean_of_its_acceleration():
    """x = t^2 + t^3/6 + cos 3t over 2 s: neither displacement, velocity nor acceleration return."""
    t = np.linspace(0.0, 2.0, 8193)
    x, v = t**2 + t**3 / 6.0 + np.cos(3.0 * t), 2.0 * t + t**2 / 2.0 - 3.0 * np.sin(3.0 * t)
    a = 2.0 + t - 9.0 * np.cos(3.0 * t)
    found = series_of(x, v[[0, -1]], 2.0, 400)
    assert found.mean == pytest.approx((v[-1] - v[0]) / 2.0, rel=1e-12)
    n = np.arange(1, 401)
    exact = [integrate.trapezoid(a * np.exp(-1j * np.pi * k * t), t) / 2.0 for k in n[:20]]
    np.testing.assert_allclose(found.harmonics[:20], exact, atol=2e-6 * np.abs(a).max())
    inside = slice(2000, 6000)
    values = Series(2.0, found.mean, found.harmonics).values(4096.0, 8192)
    np.testing.assert_allclose(values[inside], a[:-1][inside], atol=0.01 * np.abs(a).max())  # it jumps at the ends


@pytest.mark.parametrize("duration", [0.05601726, 0.0313, 1.0 / 441.0])
@pytest.mark.parametrize("rate", [44_100, 48_000, 8_000])
def test_values_are_the_sum_of_the_harmonics_at_any_rate(duration, rate):
    """Periods that are no whole number of samples, and one that is."""
    random = np.random.default_rng(7)
    harmonics = random.normal(size=12) + 1j * random.normal(size=12)
    found = Series(duration, 0.25, harmonics).values(rate, 5000)
    times = np.arange(5000) / rate
    exact = 0.25 + 2.0 * (np.exp(2j * np.pi * np.outer(times, np.arange(1, 13)) / duration) @ harmonics).real
    np.testing.assert_allclose(found, exact, atol=1e-8 * np.abs(exact).max())


def test_the_end_of_a_long_sound_is_as_exact_as_its_first_second():
    found = Series(0.0123456789, 0.0, np.array([0.0, 0.5])).values(44_100, 15 * 44_100)
    times = np.arange(15 * 44_100) / 44_100
    np.testing.assert_allclose(found, np.cos(4.0 * np.pi * times / 0.0123456789), atol=1e-6)
