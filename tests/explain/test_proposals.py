"""What to measure next: information in closed form, and against measuring anywhere."""

import numpy as np
import pytest

import stickslip
from helpers.commands import call
from stickslip.vocabulary.flags import DECIDED, REGIMES
from stickslip_explain.proposals import _Outcomes

STICK_SLIP, DAMPED = DECIDED.index("stick_slip"), DECIDED.index("damped")
CELL = {"mass": 0.1, "a1": 0.2, "a2": 0.3, "a3": 0.2, "a4": 0.02, "normal_load": 10.0}
PRIOR = CELL | {"stiffness": {"lognormal": {"median": 5e3, "factor": 1.5}}, "a3": {"uniform": [0.05, 0.3]},
                "a4": {"lognormal": {"median": 0.02, "factor": 2}}}  # fmt: skip
SCATTER = {"period": 0.03}


def information(regimes, logs=None, scatter=(), mislabelled=0.01):
    logs = np.empty((1, len(regimes), 0)) if logs is None else np.asarray(logs)[None, :, None]
    rng = np.random.default_rng(5)
    return _Outcomes(np.asarray(regimes)[None], logs, np.asarray(scatter, float), mislabelled, rng).information(0)


def test_a_regime_that_half_of_the_draws_have_tells_a_bit_but_for_wrong_labels():
    """Mutual information of a label with four wrong ones, each of probability e/4, and of which half a draw is in."""
    e, regimes = 0.1, np.repeat([STICK_SLIP, DAMPED], 2000)
    either, other = (1 - e + e / 4) / 2, e / 4
    entropy = -2 * either * np.log2(either) - 3 * other * np.log2(other)
    given = -(1 - e) * np.log2(1 - e) - e * np.log2(e / 4)
    assert information(regimes, mislabelled=e) == pytest.approx(entropy - given, abs=0.05)
    assert information(np.full(100, DAMPED)) == 0.0
    assert information(np.full(100, -1)) == pytest.approx(0.0, abs=1e-12)  # no verdict says nothing


@pytest.mark.parametrize("ratio", [0.5, 3.0])
def test_a_result_tells_half_the_logarithm_of_its_signal_and_noise(ratio):
    """Shannon's formula for a normal quantity in normal noise."""
    spread = 0.1
    logs = spread * np.random.default_rng(2).standard_normal(3000)
    found = information(np.full(3000, STICK_SLIP), logs, [spread / ratio])
    assert found == pytest.approx(0.5 * np.log2(1 + ratio**2), abs=0.05)


def seen_at(truth, speed, rng):
    """What a rig with this truth shows at a belt speed."""
    cell = stickslip.evaluate(truth | {"belt_speed": speed})
    seen = {"belt_speed": float(speed), "regime": REGIMES[int(cell["regime"][0])]}
    if np.isfinite(period := float(cell["period"][0])):
        seen["period"] = {"value": period * np.exp(0.03 * rng.standard_normal()), "scatter": 0.03 * period}
    return seen


def spreads(observed, particles):
    found = stickslip.explain(observed, PRIOR, particles=particles, repetitions=2, progress=False)
    deviates = np.array([np.log(found[f"posterior_{name}"].values) for name in ("stiffness", "a3", "a4")])
    return found, 0.5 * np.linalg.slogdet(np.cov(deviates))[1]


def after(truth, steps, propose, particles, seed):
    """Entropy, but for a constant, of what is not known after some measurements."""
    rng = np.random.default_rng(seed)
    observed = [seen_at(truth, 0.02, rng)]
    for _ in range(steps):
        found, _ = spreads(observed, particles)
        if propose:
            best = stickslip.next_measurement(
                found, {"belt_speed": (0.002, 0.2)}, scatter=SCATTER, draws=100, points=12
            )
            speed = float(best["proposed_belt_speed"][0])
        else:
            speed = np.exp(rng.uniform(np.log(0.002), np.log(0.2)))
        observed.append(seen_at(truth, speed, rng))
    return spreads(observed, particles)[1]


@pytest.mark.slow
def test_proposed_measurements_leave_less_unknown_than_random_ones():
    """Two more measurements for each of twelve true rigs, five times at random."""
    rng, gains = np.random.default_rng(8), []
    for number in range(12):
        truth = CELL | {"stiffness": 5e3 * 1.5 ** rng.standard_normal(), "a3": rng.uniform(0.1, 0.3),
                        "a4": 0.02 * 2 ** rng.standard_normal()}  # fmt: skip
        proposed = after(truth, 2, True, 150, [number, 0])
        anywhere = [after(truth, 2, False, 150, [number, i]) for i in range(1, 6)]
        gains.append(np.mean(anywhere) - proposed)
    assert np.mean(gains) > 2 * np.std(gains, ddof=1) / np.sqrt(len(gains))


def test_the_command_proposes_places_and_says_what_they_narrow(tmp_path):
    observed = [{"belt_speed": "20 mm/s", "regime": "stick_slip", "period": {"value": 0.03, "scatter": 0.01}}]
    stickslip.explain(observed, PRIOR, particles=60, repetitions=2, progress=False, output=tmp_path / "felt.nc")
    run = ["next", str(tmp_path / "felt.nc"), "--over", "belt_speed=0.002..0.2", "normal_load=5..20N", "--points", "6",
           "--draws", "40", "-o", str(tmp_path / "next.nc"), "--plot", str(tmp_path / "next.png")]  # fmt: skip
    done = call(*run)
    assert done.exit_code == 0, done.output
    assert done.output.count(" mm/s") == 3 and "period=0.33" in done.output
    found = stickslip.open(tmp_path / "next.nc")
    assert found["information"].dims == ("belt_speed", "normal_load")
    assert float(found["proposed_information"][0]) == float(found["information"].max())
    assert (found["spread_left"] < 1.05).all() and (found["wrong_after"] <= found["wrong_before"]).all()
    assert (tmp_path / "next.png").stat().st_size > 1000


@pytest.mark.parametrize(
    ("over", "words"),
    [("stiffness", "a parameter that an observation may differ in"), ("belt_sped", "did you mean belt_speed?"),
     ("damping", "without a range"), ("belt_speed=5..1 mm/s", "the lower end first"),
     ("belt_speed=5..60 N", "expected")],
)  # fmt: skip
def test_axes_that_nobody_can_choose_are_refused(tmp_path, over, words):
    observed = [{"belt_speed": 0.02, "regime": "stick_slip"}]
    path = tmp_path / "felt.nc"
    stickslip.explain(observed, PRIOR, particles=20, repetitions=2, progress=False, output=path)
    done = call("next", path, "--over", over)
    assert done.exit_code == 2 and words in done.output, done.output
    assert call("next", path, "--over", "belt_speed", "--scatter", "perid=3").exit_code == 2


def test_what_differs_between_observations_is_an_axis_or_has_a_value(kernels):
    observed = [{"belt_speed": 0.01, "normal_load": load, "regime": "stick_slip"} for load in (10.0, 5.0)]
    prior = CELL | {"stiffness": 5e3, "damping": 2.0, "a3": {"uniform": [0.0, 0.6]}}
    prior.pop("normal_load")
    found = stickslip.explain(observed, prior, particles=20, repetitions=2, progress=False)
    how = {"draws": 10, "points": 3, "progress": False}
    speeds = {"belt_speed": (0.005, 0.3)}
    with pytest.raises(ValueError, match="normal_load: add it here, or give --at normal_load=VALUE"):
        stickslip.next_measurement(found, speeds, **how)
    with pytest.raises(ValueError, match="at: got mass, expected what observations name: normal_load"):
        stickslip.next_measurement(found, speeds, at={"mass": 1.0}, **how)
    plane = stickslip.next_measurement(found, speeds | {"normal_load": (5.0, 10.0)}, **how)
    line = stickslip.next_measurement(found, speeds, at={"normal_load": "5 N"}, **how)
    np.testing.assert_array_equal(line["chance"], plane["chance"].sel(normal_load=5.0))
