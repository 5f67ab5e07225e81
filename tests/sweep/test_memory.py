"""Contacts with memory, through the front door: calls, configurations, trajectories."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stickslip
from helpers.adversary_memory import PLAIN, judged
from helpers.nightly import few
from judge import memory
from stickslip.api.cells import time_span
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError

PAIR = {
    "mass": 1.0,
    "stiffness": 2e4,
    "normal_load": 10.0,
    "mu_0": 0.6,
    "v_0": 1e-6,
    "a": 0.01,
    "b": 0.018,
    "D_c": 1e-6,
}
LAWS = ("rate_state_ageing", "rate_state_slip")
CONFIG = """
system: {mass: 1 kg, normal_load: 10 N}
friction: {law: rate_state_ageing, mu_0: 0.6, v_0: 1 um/s, a: 0.010, b: 0.018, D_c: 1 um}
axes:
  stiffness: [20 N/mm, 100 N/mm]
  belt_speed: [1 um/s, 10 mm/s]
"""
BRISTLES = {
    "mass": 0.1,
    "stiffness": 5000.0,
    "damping": 1.0,
    "normal_load": 10.0,
    "a1": 0.25,
    "a2": 0.0,
    "a3": 0.2,
    "a4": 0.02,
    "contact_stiffness": 1e6,
    "contact_damping": 100.0,
}


@pytest.mark.slow
def test_what_comes_before_the_limit_of_loops_that_shrink_counts():
    """The fastest slip on the way to a slip cycle; crossings on the way to a slow approach, two of them shallow."""
    common = {"mu_0": 0.6, "v_0": 1e-6}
    growing = common | {
        "mass": 445.76008899533224, "stiffness": 1385.6784656552115, "normal_load": 0.4568321150582744,
        "belt_speed": 8.168355442069221e-05, "damping": 0.021605029923511113, "a": 0.02096677077355937,
        "b": 0.033042074252559096, "D_c": 8.263101799303501e-06,
    }  # fmt: skip
    settling = common | {
        "mass": 14.824961156373558, "stiffness": 1519114.5679029587, "normal_load": 0.2756862442111749,
        "belt_speed": 1.9317823290168653e-06, "damping": 2.940349515830149, "a": 0.007957161403075341,
        "b": 0.023085696033609902, "D_c": 5.773719447697682e-07, "displacement": 1.0707919103358539e-07,
        "velocity": 1.9317262974608686e-06, "contact_time": 3.6799085656301704e-05,
    }  # fmt: skip
    for cell, names in ((growing, ["slip_speed_max"]), (settling, ["settling_time", "equilibrium_crossings"])):
        ruled = judged({name: np.array([value]) for name, value in (PLAIN | cell).items()}, LAWS[1])
        ours = stickslip.evaluate(cell, law=LAWS[1], variables=names)
        for name in names:
            assert ours[name].item() == pytest.approx(ruled[name][0], rel=1e-6)


def test_speeds_that_pass_that_of_the_belt_within_a_step_and_come_back_are_crossings():
    """Of bristles that ring on the way to steady sliding: ten of 190."""
    cell = {
        "mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "damping": 0.00356485, "belt_speed": 0.000769944,
        "a1": 0.556814, "a2": 0.0, "a3": 0.0314705, "a4": 0.00250666, "contact_stiffness": 2.22665,
        "contact_damping_speed": 0.124001, "elastic_part": 0.0478896,
    }  # fmt: skip
    ruled = judged({name: np.array([value]) for name, value in (PLAIN | cell).items()}, "stribeck")
    ours = stickslip.evaluate(cell, variables=["equilibrium_crossings"])
    assert ours["equilibrium_crossings"].item() == ruled["equilibrium_crossings"][0] > 180.0


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_a_trajectory_is_that_of_scipy(law):
    belt = 1e-2
    x = (0.6 - 0.008 * np.log(1e4)) * 10 / 2e4 * 1.02

    def motion(_, state):
        x, phi, psi = state  # ln(w/v_0), ln(v_0 theta/D_c)
        w, mu = 1e-6 * np.exp(phi), 0.6 + 0.01 * phi + 0.018 * psi
        change = np.exp(-psi) - np.exp(phi) if law == LAWS[0] else -np.exp(phi) * (phi + psi)
        return belt - w, (2e4 * x - 10 * mu) / w, change

    times = np.linspace(0.0, 0.2, 201)
    start = x, np.log(5e-3 / 1e-6), np.log(1e-6 / belt)
    exact = solve_ivp(motion, (0.0, 0.2), start, "Radau", times, rtol=1e-10, atol=1e-12).y
    trace = stickslip.simulate(
        duration=0.2, samples=201, law=law, rtol=1e-8, belt_speed=belt, displacement=x, velocity=5e-3, **PAIR
    )
    for name, values in {
        "displacement": exact[0], "relative_speed": 1e-6 * np.exp(exact[1]),
        "friction_coefficient": 0.6 + 0.01 * exact[1] + 0.018 * exact[2],
    }.items():  # fmt: skip
        np.testing.assert_allclose(trace[name], values, atol=3e-8 * np.abs(values).max(), err_msg=name)


@pytest.mark.slow
def test_between_its_steps_a_trajectory_goes_no_further_than_in_them(law=LAWS[0]):
    """While slip is held back for seconds, a sample may lie anywhere in a long step."""
    random = np.random.default_rng(9)
    for _ in range(30):
        cell = PAIR | {"belt_speed": 10 ** random.uniform(-6, -1), "stiffness": 10 ** random.uniform(3, 5)}
        time = 3.0 * 12.0 / (cell["belt_speed"] * cell["stiffness"])
        trace = stickslip.simulate(duration=time, samples=2001, law=law, **cell)
        fastest = cycle_and_start(cell, law)
        assert float(trace["relative_speed"].max()) <= fastest * (1.0 + 1e-4)
        assert float(trace["relative_speed"].min()) >= 0.0
        thrown = cell["belt_speed"] * (cell["stiffness"] * cell["mass"]) ** 0.5
        assert float(trace["spring_force"].max()) <= 13.5 + thrown
        step = np.diff(trace["displacement"].values) / np.diff(trace["time"].values)
        assert np.abs(step).max() <= fastest + cell["belt_speed"]


def cycle_and_start(cell, law):
    """The largest slip speed of the whole motion: that of a cell which nothing but a horizon ends."""
    known = stickslip.evaluate(cell, law=law)
    first = memory.kernel_rows(
        {name: np.array([value]) for name, value in cell.items()}
        | {
            "damping": np.zeros(1),
            "displacement": np.zeros(1),
            "velocity": np.array([np.nan]),
            "contact_time": np.zeros(1),
        },
        law,
    )
    answer = memory.judge_memory(first)[0]
    speed = 10.0 / (cell["stiffness"] * cell["mass"]) ** 0.5
    return max(float(known["slip_speed_max"][0]), answer[memory.WHOLE_FASTEST] * speed)


def test_a_configuration_is_a_map_with_linear_theory_beside_it():
    ds = stickslip.run(parse_config(CONFIG))
    assert ds["regime"].values.tolist() == [[1, 1], [2, 1]]
    np.testing.assert_allclose(ds["critical_stiffness"].sel(belt_speed=1e-6), 80000.8)
    np.testing.assert_allclose(ds["critical_stiffness"].sel(belt_speed=1e-2), 80079999.99999999)
    cycle = ds.isel(stiffness=0, belt_speed=1)
    np.testing.assert_allclose(cycle["slip_per_cycle"], cycle["period"] * 1e-2)
    np.testing.assert_allclose(cycle["stress_drop"], (cycle["cycle_force_max"] - cycle["cycle_force_min"]) / 10.0)
    assert (np.sign(ds["growth_rate"]).values == [[1, 1], [-1, 1]]).all()
    again = stickslip.evaluate(PAIR | {"belt_speed": 1e-2}, law=LAWS[0])
    for name in ("period", "slip_speed_min", "growth_rate", "growth_frequency", "energy_per_cycle"):
        np.testing.assert_array_equal(again[name][0], cycle[name])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"belt_speed: [1 um/s, 10 mm/s]": "belt_speed: [0, 10 mm/s]"}, "other than 0 m/s"),
        ({"a: 0.010": "a: 0"}, "friction.a: got 0, expected a number above 0"),
        ({"D_c: 1 um": "D_c: 1 um, mu_stop: 0.3"}, "got mu_stop with the law rate_state_ageing, expected none"),
        ({"D_c: 1 um": "a4: 1 mm/s"}, "friction.D_c: missing"),
    ],
)
def test_what_such_a_contact_cannot_do_is_said(changes, message):
    text = CONFIG
    for old, new in changes.items():
        text = text.replace(old, new)
    with pytest.raises(ConfigError) as error:
        parse_config(text)
    assert message in str(error.value)


STEPPED = {
    "mass": 1e-6, "stiffness": 1e8, "normal_load": 10.0, "mu_0": 0.6, "v_0": 1e-6, "a": 0.010, "b": 0.015, "D_c": 2e-6,
}  # fmt: skip


@pytest.mark.parametrize("law", few(LAWS, 1))
def test_after_a_hold_the_peak_of_friction_has_grown_with_its_logarithm(law):
    """By b per e-fold; between the limits of a stiff spring and of one that gives way it is less by a constant."""
    held = np.geomspace(1e3, 1e9, 7)
    cells = STEPPED | {"belt_speed": 1e-5, "displacement": 5e-8, "contact_time": held}
    peaks = stickslip.evaluate(cells, law=law, rtol=1e-8)["spring_force_max"].values / STEPPED["normal_load"]
    slope = np.diff(peaks) / np.diff(np.log(held))
    np.testing.assert_allclose(slope, STEPPED["b"], rtol=1e-2 if law == LAWS[1] else 1e-4)


def test_a_border_along_stiffness_ends_where_small_motions_decay():
    cell = {name: value for name, value in PAIR.items() if name != "stiffness"}
    found = stickslip.border(cell | {"belt_speed": 1e-5}, "stiffness", (2e4, 2e5), 1e-3, law=LAWS[0], scan=8)
    assert int(found["regime_above"].values.ravel()[-1]) in (2, 3)
    assert float(found["border"].values.ravel()[-1]) == pytest.approx(8e4, rel=0.1)


def test_attractors_of_it_are_sampled():
    cells = PAIR | {"belt_speed": 1e-4, "stiffness": [2e4, 1e5]}
    steady = (0.6 - 0.008 * np.log(100.0)) * 10.0 / 1e5
    found = stickslip.attractors(
        cells, {"displacement": (0.5 * steady, 1.5 * steady), "velocity": (-1e-4, 9e-5)}, law=LAWS[0], samples=64
    )
    np.testing.assert_array_equal(found["settling_share"], [0.0, 1.0])
    assert found["regime_from_stick"].values.tolist() == [1, 2]
    assert found["regime_from_sliding"].values.tolist() == [1, 2]


@pytest.mark.parametrize("cell", [PAIR | {"belt_speed": 1e-4}, BRISTLES | {"belt_speed": 0.02, "a3": 0.05}])
def test_a_ramp_goes_from_cycle_to_cycle(cell):
    """It never rests on the belt: the next value starts where the spring pulls least."""
    law = LAWS[0] if "mu_0" in cell else "stribeck"
    softest = 2e4 if "mu_0" in cell else 3e3
    found = stickslip.ramp(cell, "stiffness", (softest, 1.2 * softest), points=2, law=law)
    np.testing.assert_array_equal(found["regime"].values, 1)
    at_once = stickslip.evaluate(cell | {"stiffness": [softest, 1.2 * softest]}, law=law)
    np.testing.assert_allclose(found["period"].values.ravel()[:2], at_once["period"], rtol=1e-4)


@pytest.mark.parametrize(
    ("changes", "law", "message"),
    [
        ({"mu_stop": 0.3}, LAWS[0], "of stribeck, stribeck_delta"),
        ({"contact_stiffness": 1e6}, LAWS[1], "lugre_stribeck"),
    ],
)
def test_a_parameter_of_another_law_names_that_law(changes, law, message):
    with pytest.raises(TypeError, match=message):
        stickslip.evaluate(PAIR | {"belt_speed": 1e-2} | changes, law=law)


# --- bristles ---------------------------------------------------------------------------------------------------------


def bristle_config(friction="", axes="contact_stiffness: [10 N/mm, 1 N/um]"):
    return f"""
system: {{mass: 100 g, damping: 1 N s/m, normal_load: 10 N, stiffness: 5 N/mm}}
friction: {{a1: 0.25, a2: 0, a3: 0.2, a4: 20 mm/s, contact_damping: 100 N s/m{friction}}}
axes:
  belt_speed: [20 mm/s, 1 m/s]
  {axes}
"""


def test_the_stiffness_of_the_contact_chooses_its_model():
    """The second belt is quiet; the first is the reference cell L9."""
    ds = stickslip.run(parse_config(bristle_config()))
    assert ds["regime"].sel(contact_stiffness=1e6).values.tolist() == [1, 2]
    cycle = ds.sel(contact_stiffness=1e6, belt_speed=0.02)
    assert float(cycle["period"]) == pytest.approx(0.054840572932607135, rel=1e-6)
    assert float(cycle["presliding_displacement"]) == pytest.approx(4.5e-6)
    assert float(cycle["growth_rate"]) == pytest.approx(175.09265744758096) and np.isinf(cycle["critical_stiffness"])
    assert (np.sign(ds["damping_ratio"]) == -np.sign(ds["growth_rate"])).all()
    again = stickslip.evaluate(BRISTLES | {"belt_speed": 0.02})
    for name in ("period", "slip_speed_min", "growth_frequency", "energy_per_cycle", "steps"):
        np.testing.assert_array_equal(again[name][0], cycle[name])


def test_a_contact_that_is_not_given_or_none_is_rigid():
    given = bristle_config().replace(", contact_damping: 100 N s/m", ", contact_stiffness: none")
    rigid = parse_config(
        given.replace("contact_stiffness: [10 N/mm, 1 N/um]", "a3: [0.1, 0.2]").replace("a3: 0.2, ", "")
    )
    assert rigid.friction.law == "stribeck"
    assert "presliding_displacement" not in stickslip.run(rigid)


def test_a_curve_as_it_is_measured_may_have_bristles():
    measured = bristle_config().replace(
        "a1: 0.25, a2: 0, a3: 0.2", "mu_start: 0.45, mu_reversal: 0.3, v_reversal: 80 mm/s"
    )
    config = parse_config(measured)
    assert config.friction.law == "lugre_stribeck"
    assert (stickslip.run(config)["presliding_displacement"].sel(contact_stiffness=1e6) == 4.5e-6).all()


def test_borders_margins_and_attractors_serve_bristles():
    cell = {name: value for name, value in BRISTLES.items() if name != "stiffness"}
    soft = cell | {"contact_stiffness": 2e4, "contact_damping": 0.0, "a3": 0.05, "belt_speed": 0.02}  # L11
    found = stickslip.border(soft, "stiffness", (5e3, 4e4), 1e-3, scan=8)
    assert found["regime_above"].values.ravel()[-1] == 2
    assert float(found["border"].values.ravel()[-1]) == pytest.approx(19428.22698550356, rel=0.05)
    both = stickslip.attractors(
        BRISTLES | {"belt_speed": [0.02, 1.0]}, {"displacement": (0.0, 1e-3), "velocity": (-0.1, 0.015)}, samples=64
    )
    np.testing.assert_array_equal(both["settling_share"], [0.0, 1.0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (bristle_config(", mu_stop: 0.3"), "got mu_stop with the law lugre_stribeck, expected none"),
        (bristle_config(", ageing_rate: 0.1"), "got ageing_rate with the law lugre_stribeck, expected none"),
        (bristle_config(axes="elastic_part: [0, 1]"), "elastic_part"),
        (bristle_config().replace("a1: 0.25", "a1: 0"), "above 0"),
        (bristle_config() + "start: {contact_time: 10 s}\n", "start.contact_time: got '10 s', expected 0 s"),
        (bristle_config(", contact_stiffness: 1 N/um", "contact_time: [0, 10]"), "got 10, expected 0 s"),
        (bristle_config(axes="contact_stiffness: [none, 1 N/um]"), "leave contact_stiffness out for a rigid contact"),
        (
            bristle_config().replace("friction: {", "friction: {law: LuGre, "),
            "contact_stiffness of the contact beside its law",
        ),
    ],
)
def test_what_bristles_cannot_be_is_said(text, message):
    with pytest.raises(ConfigError) as error:
        parse_config(text)
    assert message in str(error.value)


NEVER_REPEATS = BRISTLES | {  # soft bristles without damping of their own ring from one slip to the next
    "a3": 0.05, "stiffness": 500.0, "contact_stiffness": 2e4, "contact_damping": 0.0, "belt_speed": 0.043,
}  # fmt: skip


def test_stick_slip_that_never_repeats_is_told():
    found = stickslip.evaluate(NEVER_REPEATS)
    assert (found["regime"].values[0], found["status"].values[0]) == (1, 17) and np.isnan(found["period"].values[0])
    assert 0.0 < float(found["displacement_amplitude"][0]) < 10.0 / 500.0
    assert 0.0 < time_span(found).duration < 10.0
