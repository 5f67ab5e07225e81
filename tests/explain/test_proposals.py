"""What to measure next: information in closed form, and against measuring anywhere."""

import numpy as np
import pytest

import stickslip
from helpers.commands import call
from stickslip.vocabulary.quantities import DECIDED
from stickslip_explain.proposals import _Outcomes

STICK_SLIP, DAMPED = DECIDED.index("stick_slip"), DECIDED.index("damped")
CELL = {"mass": 0.1, "a1": 0.2, "a2": 0.3, "a3": 0.2, "a4": 0.02, "normal_load": 10.0}
PRIOR = CELL | {"stiffness": {"lognormal": {"median": 5e3, "factor": 1.5}}, "a3": {"uniform": [0.05, 0.3]},
                "a4": {"lognormal": {"median": 0.02, "factor": 2}}}  # fmt: skip


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


def test_the_command_proposes_places_and_says_what_they_narrow(tmp_path):
    observed = [{"belt_speed": "20 mm/s", "regime": "stick_slip", "period": {"value": 0.03, "scatter": 0.01}}]
    stickslip.explain(observed, PRIOR, particles=60, repetitions=2, progress=False, output=tmp_path / "felt.nc")
    run = ["next", str(tmp_path / "felt.nc"), "--over", "belt_speed=0.002..0.2", "normal_load=5..20N", "--points", "6",
           "-o", str(tmp_path / "next.nc"), "--plot", str(tmp_path / "next.png")]  # fmt: skip
    done = call(*run)
    assert done.exit_code == 0, done.output
    assert done.output.count(" mm/s") == 3 and "period=0.33" in done.output
    found = stickslip.open(tmp_path / "next.nc")
    assert found["information"].dims == ("belt_speed", "normal_load")
    assert float(found["proposed_information"][0]) == float(found["information"].max())
    assert (found["spread_left"] < 1.05).all()
    assert (tmp_path / "next.png").stat().st_size > 1000


def test_axes_that_nobody_can_choose_are_refused(tmp_path):
    path = tmp_path / "felt.nc"
    seen = [{"belt_speed": 0.02, "regime": "stick_slip"}]
    stickslip.explain(seen, PRIOR, particles=20, repetitions=2, progress=False, output=path)
    for words, expected in (
        (["stiffness"], "a parameter that an observation may differ in"), (["belt_sped"], "did you mean belt_speed?"),
        (["damping"], "without a range"), (["belt_speed=5..1 mm/s"], "the lower end first"),
        (["belt_speed=5..60 N"], "expected"), (["belt_speed", "--scatter", "perid=3"], "perid"),
    ):  # fmt: skip
        done = call("next", path, "--over", *words)
        assert done.exit_code == 2 and expected in done.output, done.output


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
