"""Simulated rigs against the independent ones of tests/helpers/scipy_rig.py, and whole matrices of them."""

import functools

import numpy as np
import pytest

import stickslip
from helpers.rig_cases import data, exact, random_data, reference, rig
from stickslip.vocabulary.models import CURVE_LAWS
from stickslip.vocabulary.quantities import STATUSES
from stickslip_rig import simulation as apparatus
from stickslip_rig.api import RigTests, features, make_rig, run_matrix
from stickslip_rig.quantities import EXACT, FEATURES
from stickslip_rig.sections import Sensor, sections_of

TIGHT = {"rtol": 1e-9}
SEEDS = range(20)


@functools.cache
def solved(seed):
    return reference(random_data(seed))


@functools.cache
def felt():
    return reference(data())


def one(made):
    """The only test of a rig."""
    (test,) = RigTests(made).tests([0])
    return test


def seen_by(sensor, found, wait):
    """The record of a reference: the same sensor looks at the motion that SciPy computed."""
    fine = sensor.rate * sensor.oversampling
    _, signals = found.sample(fine)
    first = round(wait * fine)
    x, v, stick = (signals[name][first:] for name in ("displacement", "velocity", "stick"))
    acceleration, spring = apparatus.accelerations(v, sensor), found.stiffness * apparatus.midway(x)
    friction = found.mass * acceleration + found.damping * apparatus.midway(v) + spring
    time = apparatus.times(v.size, sensor)
    shown = {"spring_force": spring, "friction_force": friction, "acceleration": acceleration}
    record = {name: apparatus.sensed(values, sensor)[: time.size] for name, values in shown.items()}
    record["stick"] = apparatus.sensed(stick[1:].astype(float), sensor) > 0.5
    return time, record


# --- against SciPy ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_event_exact_numbers_are_those_of_scipy(seed):
    """20 random rigs: with ageing, with dwells, with static friction above the curve, and some that hardly slip."""
    expected = exact(solved(seed))
    found = one(make_rig(random_data(seed, solver=TIGHT))).exact
    assert STATUSES[int(found["status"])] == "horizon_reached"
    for name, value in expected.items():
        tolerance = 0 if name in ("sticks_exact", "slips_exact") else 1e-5 if name == "acceleration_max_exact" else 1e-7
        assert found[name] == pytest.approx(value, rel=tolerance, abs=1e-12), name
    if "breakaway_time" not in expected:
        assert np.isnan(found["breakaway_time"]) and np.isnan(found["breakaway_force"])


def test_energy_is_balanced_at_the_default_tolerance():
    errors = [one(make_rig(random_data(seed))).exact["energy_error"] for seed in SEEDS]
    assert np.abs(errors).max() < 1e-6


@pytest.mark.parametrize("bandwidth", [None, 500.0])
def test_signals_are_those_of_scipy_behind_the_same_sensor(bandwidth):
    sensor = {"rate": 2000.0} | ({} if bandwidth is None else {"bandwidth": bandwidth})
    made = one(make_rig(data(sensor=sensor, solver=TIGHT))).record
    time, expected = seen_by(Sensor(**sensor), felt(), 0.5)
    n = time.size - 40  # the reference has no sample at the very end, which the low-pass would look at
    assert made["time"].values[:n] == pytest.approx(time[:n], rel=1e-12)
    for name in ("spring_force", "friction_force", "acceleration"):
        scale = np.abs(expected[name]).max()
        assert made[name].values[:n] == pytest.approx(expected[name][:n], abs=1e-6 * scale), name
    assert np.array_equal(made["stick"].values[:n], expected["stick"][:n])


def test_a_fast_record_shows_the_motion_itself_at_its_times():
    """200 samples a period and no noise: force and drive at the times of the record, not half a sample away."""
    record = one(make_rig(data(sensor={"rate": 7000.0}, solver=TIGHT))).record
    time, signals = felt().sample(56_000)
    at = record["time"].values[:-40] + 0.5
    scale = {"spring_force": 4.0, "drive_velocity": 0.01, "drive_displacement": 0.004}
    for name, largest in scale.items():
        expected = np.interp(at, time, signals[name])
        assert record[name].values[:-40] == pytest.approx(expected, abs=2e-5 * largest), name
    inside = record["stick"].values[:-40] == np.interp(at, time, signals["stick"])
    assert inside.mean() > 0.99


def test_a_band_limited_acceleration_stays_below_the_event_exact_one_and_comes_close():
    """Up to the overshoot of the filter, which a jump of the acceleration makes."""
    found = run_matrix(rig(sensor={"rate": 20_000.0}, features={"bandwidth": 50.0}))
    for bandwidth, least in ((20.0, 0.1), (100.0, 0.5), (2000.0, 0.9)):
        found = run_matrix(rig(sensor={"rate": 20_000.0}, features={"bandwidth": bandwidth}))
        share = float(found["acceleration_max_limited"]) / float(found["acceleration_max_exact"])
        assert least < share < (1.0 if bandwidth < 1000 else 1.12), bandwidth


def test_the_drive_does_work_and_all_of_it_is_found_again():
    """The features of a record give the same work as the integration."""
    test = one(rig(sensor={"rate": 20_000.0}))
    found = features(test.record)
    work = float(found["energy_per_stroke"]) * float(found["strokes"])
    assert work == pytest.approx(test.exact["drive_work"], rel=1e-3)
    heat = test.exact["friction_heat"] + test.exact["damper_heat"]
    assert 0.5 < heat / test.exact["drive_work"] <= 1.0


def test_impulses_come_at_the_rate_of_the_stick_slip_cycle_of_a_belt():
    plain = data(friction={"ageing_rate": None}, drive={"stroke": 0.02, "strokes": 1, "waiting_time": 0.0})
    cell = plain["system"] | {name: plain["friction"][name] for name in ("a1", "a2", "a3", "a4")}
    belt = stickslip.evaluate(cell)
    period, speed = float(belt["period"][0]), cell["belt_speed"]
    record = one(make_rig(plain | {"solver": TIGHT})).record.sel(time=slice(0.5, 1.9))
    breaks = np.flatnonzero(np.diff(record["stick"].values) == -1)
    steady = record["time"].values[breaks]
    assert steady.size > 20
    cycle = (steady[-1] - steady[0]) / (steady.size - 1)
    assert cycle == pytest.approx(period, abs=1.0 / 2000 / (steady.size - 1))
    assert float(features(record)["impulse_rate"]) == pytest.approx(1 / (speed * period), rel=1.5 / steady.size)
    assert float(features(record)["stick_fraction"]) == pytest.approx(float(belt["stick_fraction"][0]), abs=0.03)


# --- records ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(16))
def test_records_reach_to_the_end_of_the_drive_whatever_the_rate(seed):
    random = np.random.default_rng([3, seed])
    wait = float(random.choice([0.0, random.uniform(0, 700), 1e4, 1e7]))
    rate = float(random.choice([2000.0, random.uniform(100, 900)]))
    over = int(random.choice([1, 3, 8]))
    drive = {"dwell": 0.0, "waiting_time": wait, "profile": str(random.choice(["sine", "trapezoid"]))}
    drive |= {"ramp": None} if drive["profile"] == "sine" else {}
    tests = RigTests(rig(drive=drive, sensor={"rate": rate, "oversampling": over}))
    (test,) = tests.tests([0])
    whole = tests.duration(0)
    time = test.record["time"].values
    assert np.isfinite(test.record["acceleration"]).all()
    assert whole - 2.0 / rate < time[-1] <= whole


def test_the_fewest_samples_a_configuration_allows_are_enough():
    """A stroke of 0.45 s at 36 Hz is 16.2 steps: 17 samples at the ends of steps, 16 between them."""
    for over, rate in ((1, 37.5), (1, 36.0), (8, 35.5)):
        sensor = {"rate": rate, "oversampling": over}
        assert one(rig(sensor=sensor, drive={"strokes": 1, "dwell": 0.0})).record.sizes["time"] == 16


def test_a_contact_without_friction_has_no_work_to_compare_with():
    test = one(rig(friction={"a1": 0.0, "a3": 0.0, "ageing_rate": 0.0}))
    assert test.exact["drive_work"] == 0.0 and np.isnan(test.exact["energy_error"])
    assert np.abs(test.record["acceleration"]).max() < 1e-12


def noisy_matrix(**more):
    sensor = {"rate": 1000.0, "force_noise": 0.02, "acceleration_noise": 0.5}
    axes = {"normal_load": [5.0, 10.0, 20.0], "a1": [0.1, 0.2, 0.3]}
    return rig(system={"normal_load": None}, friction={"a1": None}, axes=axes, sensor=sensor | more.pop("sensor", {}),
               **more)  # fmt: skip


def test_noise_is_that_of_the_sensor_of_the_seed_and_of_the_test():
    quiet = [t.record for t in RigTests(noisy_matrix(sensor={"force_noise": 0, "acceleration_noise": 0})).tests([0, 4])]
    loud = [t.record for t in RigTests(noisy_matrix()).tests([0, 4])]
    again = [t.record for t in RigTests(noisy_matrix()).tests([0, 4])]
    other = [t.record for t in RigTests(noisy_matrix(sensor={"seed": 2})).tests([0, 4])]
    for name, deviation in (("spring_force", 0.02), ("acceleration", 0.5)):
        noise = [(a[name] - b[name]).values for a, b in zip(loud + other, quiet + quiet, strict=True)]
        for values in noise:
            assert values.std() == pytest.approx(deviation, rel=0.1)
            assert abs(np.mean(values[1:] * values[:-1])) < 0.15 * deviation**2  # white
        shared = np.corrcoef([values[:900] for values in noise]) - np.eye(4)
        assert np.abs(shared).max() < 0.15
    for a, b in zip(loud, again, strict=True):
        assert a.identical(b)


def test_a_record_is_the_same_alone_and_within_the_matrix():
    tests = RigTests(noisy_matrix())
    together = list(tests.tests(range(9)))
    assert [test.number for test in together] == list(range(9))
    for number in (0, 5, 8):
        (alone,) = tests.tests([number])
        assert alone.record.identical(together[number].record) and alone.exact == together[number].exact
    backwards = list(tests.tests([8, 5]))
    assert backwards[1].record.identical(together[5].record)


def test_a_record_knows_the_conditions_of_its_test():
    tests = RigTests(rig(axes={"material": {"labels": ["dry", "felt"], "zip": {"a1": [0.4, 0.2]}}},
                         friction={"a1": None}))  # fmt: skip
    records = [test.record for test in tests.tests([0, 1])]
    assert [str(record["material"].item()) for record in records] == ["dry", "felt"]
    assert [record.attrs["title"] for record in records] == ["dry", "felt"]
    found = {name: float(records[0][name]) for name in ("drive_speed", "normal_load", "waiting_time", "stiffness")}
    assert found == {"drive_speed": 0.01, "normal_load": 10.0, "waiting_time": 0.5, "stiffness": 5000.0}


# --- matrices ---------------------------------------------------------------------------------------------------------


def test_the_numbers_of_a_matrix_do_not_depend_on_the_threads():
    found = [run_matrix(noisy_matrix(execution={"threads": threads})).drop_attrs(deep=False) for threads in (1, 2, 5)]
    assert found[0].sizes["normal_load"] == 3 and found[0]["model_rpn"].dims == ("normal_load", "a1")
    assert found[0].identical(found[1]) and found[0].identical(found[2])


def test_a_matrix_holds_what_its_records_say():
    made = noisy_matrix(features={"bandwidth": 200.0})
    found = run_matrix(made)
    for test in RigTests(made).tests([2, 7]):
        at = dict(zip(("normal_load", "a1"), np.unravel_index(test.number, (3, 3)), strict=True))
        own = features(test.record, sections_of(made).features)
        for name in FEATURES:
            assert np.array_equal(found[name].isel(at).values, own[name].values, equal_nan=True), name
        for name in EXACT:
            assert np.array_equal(float(found[name].isel(at)), test.exact[name], equal_nan=True), name


def test_a_test_that_runs_out_of_steps_is_missing_and_says_why():
    """The heavy specimen only sticks, which takes a step a segment; the light one slips."""
    seen = []
    made = rig(system={"normal_load": None}, axes={"normal_load": [10.0, 1000.0]}, solver={"max_steps": 40})
    found = run_matrix(made, progress=lambda done, size: seen.append((done, size)))
    assert [STATUSES[code] for code in found["status"].values] == ["step_limit", "horizon_reached"]
    assert found["status"].dtype == np.int8 and seen[-1] == (2, 2)
    for name in FEATURES:
        assert np.isnan(found[name].values[0]).all(), name
    assert np.isnan(found["model_rpn"].values[0]) and found["model_rpn"].values[1] == 1
    assert np.isnan(found["drive_work"].values[0]) and found["drive_work"].values[1] > 0
    light, heavy = RigTests(made).tests([0, 1])
    assert light.record is None and heavy.record is not None


@pytest.mark.slow  # each of them is compiled
@pytest.mark.parametrize("law", CURVE_LAWS[1:])
def test_other_laws_have_rigs_too(law):
    friction = {"law": law} | ({"delta": 1.5} if law == "stribeck_delta" else {})
    test = one(rig(friction=friction))
    assert STATUSES[int(test.exact["status"])] == "horizon_reached"
    assert abs(test.exact["energy_error"]) < 1e-6


# --- contacts with memory ---------------------------------------------------------------------------------------------


BRISTLES = {
    "system": {"mass": 0.1, "stiffness": 5e3, "damping": 1.0, "normal_load": 10.0, "belt_speed": 0.02},
    "friction": {"a1": 0.25, "a2": 0.0, "a3": 0.2, "a4": 0.02, "contact_stiffness": 1e6, "contact_damping": 100.0},
    "drive": {"stroke": 5e-3},
}
RATE_STATE = {
    "system": {"mass": 1.0, "stiffness": 2e4, "normal_load": 10.0, "belt_speed": 1e-3},
    "friction": {"law": "rate_state_ageing", "mu_0": 0.6, "v_0": 1e-6, "a": 0.010, "b": 0.018, "D_c": 1e-6},
    "drive": {"stroke": 2e-3, "dwell": 1.0},
}


@pytest.mark.slow
@pytest.mark.parametrize(("data", "signal", "level", "within"), [
    (BRISTLES, "spring_force", 4.5, 0.3), (RATE_STATE, "friction_force", 6.2, 0.5),
])  # fmt: skip
def test_a_rig_of_a_contact_with_memory_turns_round(data, signal, level, within):
    (test,) = RigTests(make_rig(data)).tests([0])
    force = test.record[signal].values
    assert force.max() == pytest.approx(level, abs=within) and force.min() == pytest.approx(-level, abs=within)
