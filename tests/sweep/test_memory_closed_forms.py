"""Contacts with memory against closed forms and symmetries: what must come out whatever integrates it."""

import numpy as np
import pytest

import stickslip

LOAD, MU_0, V_0, A, B, DISTANCE = 10.0, 0.6, 1e-6, 0.01, 0.018, 1e-6
CONTACT = {"normal_load": LOAD, "mu_0": MU_0, "v_0": V_0, "a": A, "b": B, "D_c": DISTANCE}
LAWS = ("rate_state_ageing", "rate_state_slip")
BRISTLES = {
    "mass": 0.1, "stiffness": 5000.0, "damping": 2.0, "normal_load": 10.0, "belt_speed": 0.02, "a1": 0.25, "a2": 0.5,
    "a3": 0.2, "a4": 0.02, "contact_stiffness": 1e6, "contact_damping": 100.0,
}  # fmt: skip


def friction(speed, state):
    return MU_0 + A * np.log(speed / V_0) + B * np.log(V_0 * state / DISTANCE)


@pytest.mark.slow
@pytest.mark.parametrize("inertia", [1e-5, 1e-7])
def test_at_the_critical_stiffness_the_ageing_law_without_mass_conserves_its_energy(inertia):
    """((b - a)/a) (X - ln X) + z - ln z, with X = theta v/D_c and z = w theta/D_c; mass changes it in proportion."""
    belt, share = 1e-5, 1.5
    state = share * DISTANCE / belt
    slip = DISTANCE / state  # z = 1
    stiffness, mass = (B - A) * LOAD / DISTANCE * (1.0 + inertia), inertia * A * LOAD * DISTANCE / belt**2
    trace = stickslip.simulate(
        duration=60.0 * DISTANCE / belt, samples=2001, law=LAWS[0], rtol=1e-9, mass=mass, stiffness=stiffness,
        belt_speed=belt, displacement=friction(slip, state) * LOAD / stiffness, velocity=belt - slip,
        contact_time=state, **CONTACT,
    )  # fmt: skip
    speed, mu = trace["relative_speed"].values, trace["friction_coefficient"].values
    theta = DISTANCE / V_0 * np.exp((mu - MU_0 - A * np.log(speed / V_0)) / B)
    x, z = theta * belt / DISTANCE, speed * theta / DISTANCE
    energy = (B - A) / A * (x - np.log(x)) + z - np.log(z)
    assert np.ptp(x) > 0.8  # a large motion
    np.testing.assert_allclose(energy, (B - A) / A * (share - np.log(share)) + 1.0, rtol=inertia)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_a_step_of_the_speed_has_its_direct_effect_at_once_and_its_evolution_over_the_slip_distance(law):
    """Up and down by a decade; on a spring so stiff that slip follows the drive, but for one over its stiffness."""
    stiffness = 300.0 * LOAD / DISTANCE
    for before, after in ((1e-5, 1e-4), (1e-4, 1e-5)):
        start = friction(before, DISTANCE / before)
        trace = stickslip.simulate(
            duration=8.0 * DISTANCE / after, samples=8001, law=law, rtol=1e-9, mass=1e-6, stiffness=stiffness,
            belt_speed=after, displacement=start * LOAD / stiffness, velocity=after - before,
            contact_time=DISTANCE / before, **CONTACT,
        )  # fmt: skip
        mu, slip = trace["friction_coefficient"].values, after * trace["time"].values / DISTANCE
        evolved = np.exp(-slip)
        if law == LAWS[1]:
            state = np.log(after / before) * evolved
        else:
            state = np.log1p((after / before - 1.0) * evolved)
        exact = friction(after, DISTANCE / after) + B * state
        np.testing.assert_allclose(mu[200:], exact[200:], atol=2e-2 * A / 3.0)
        extreme = mu.max() if after > before else mu.min()
        assert extreme - start == pytest.approx(A * np.log(after / before), rel=0.03)


SLIDING = CONTACT | {"mass": 1.0, "stiffness": 2e4, "damping": 2.0, "belt_speed": 1e-2}


@pytest.mark.slow
@pytest.mark.parametrize(("cell", "law"), [(BRISTLES, "stribeck"), (SLIDING, LAWS[0]), (SLIDING, LAWS[1])])
def test_the_work_of_the_belt_is_the_heat_of_friction_and_damper(cell, law):
    found = stickslip.evaluate(cell, law=law, rtol=1e-8)
    period, heat = float(found["period"][0]), float(found["energy_per_cycle"][0])
    trace = stickslip.simulate(duration=12 * period, samples=24_001, law=law, rtol=1e-8, **cell)
    last = slice(-2001, None)  # the last period
    time, force, velocity = (trace[name].values[last] for name in ("time", "spring_force", "velocity"))
    work = np.trapezoid(force, time) * cell["belt_speed"]
    # on the belt's side: spring and damper pull at the mass, friction at the belt
    work += cell["damping"] * cell["belt_speed"] * np.trapezoid(velocity, time)
    lost = cell["damping"] * np.trapezoid(velocity**2, time)
    rubbed = (
        np.trapezoid(trace["friction_coefficient"].values[last] * trace["relative_speed"].values[last], time) * 10.0
    )
    assert heat == pytest.approx(rubbed, rel=1e-4)
    assert heat == pytest.approx(work - lost, rel=1e-4)
    assert lost > 1e-3 * work


def test_units_do_not_matter():
    """Of mass, length and time, all by powers of four."""
    mass, length, time = 4.0**3, 4.0**-5, 4.0**2
    force, speed = mass * length / time**2, length / time
    by = {
        "mass": mass, "stiffness": force / length, "damping": force / speed, "normal_load": force, "belt_speed": speed,
        "a2": 1.0 / speed, "a4": speed, "contact_stiffness": force / length, "contact_damping": force / speed,
        "v_0": speed, "D_c": length,
    }  # fmt: skip
    slider = CONTACT | {"mass": 1.0, "stiffness": [2e4, 2e5], "damping": 5.0, "belt_speed": 1e-3}
    for cell, law in ((BRISTLES, "stribeck"), (slider, LAWS[0])):
        other = {name: np.multiply(value, by.get(name, 1.0)) for name, value in cell.items()}
        one, two = (stickslip.evaluate(cells, law=law) for cells in (cell, other))
        for name, unit in {
            "regime": 1.0, "steps": 1.0, "period": time, "slip_speed_min": speed, "spring_force_max": force,
            "acceleration_max": speed / time, "energy_per_cycle": force * length, "settling_time": time,
            "critical_stiffness": force / length, "growth_rate": 1.0 / time, "stress_drop": 1.0,
            "slip_per_cycle": length,
        }.items():  # fmt: skip
            np.testing.assert_allclose(two[name], one[name] * unit, rtol=1e-12, err_msg=name)


@pytest.mark.slow
def test_slip_runs_away_in_the_time_of_dieterich(beyond=1e4):
    """Nucleation (Dieterich 1992, eq. 14): friction without healing, on a soft spring without mass.

    With H = b/D_c - k/N the time until a speed w is -(a N/(k v)) ln((1/w + H N/(k v))/(1/w_0 + H N/(k v))); healing
    and mass change it by shares of D_c/(w theta), and of m w/(a N).
    """
    belt, slip, stiffness = 1e-9, 1e-9, 0.2 * (B - A) * LOAD / DISTANCE
    state = beyond * DISTANCE / slip
    start = friction(slip, state)
    loading, growth = stiffness * belt / LOAD, B / DISTANCE - stiffness / LOAD
    last = A / loading * np.log1p(loading / (growth * slip))  # until the speed is beyond all bounds
    trace = stickslip.simulate(
        duration=0.999 * last, samples=2001, law=LAWS[0], rtol=1e-9, mass=1e-9, stiffness=stiffness, belt_speed=belt,
        displacement=start * LOAD / stiffness, velocity=belt - slip, contact_time=state, **CONTACT,
    )  # fmt: skip
    speed = trace["relative_speed"].values
    assert speed[-1] > 500.0 * slip
    time = -A / loading * np.log((1.0 / speed + growth / loading) / (1.0 / slip + growth / loading))
    np.testing.assert_allclose(time, trace["time"].values, atol=2.0 * last / beyond)
