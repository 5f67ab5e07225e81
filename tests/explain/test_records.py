"""Records of a rig as observations: what they say of simulated rigs whose truth is known, with hum and noise."""

from functools import cache

import numpy as np
import pytest
import yaml
from scipy import stats

import stickslip
from stickslip import rig
from stickslip.config.grid import options_of
from stickslip.config.reader import load_config, make_config
from stickslip.engine import stop_flag
from stickslip.errors import ConfigError, ContradictionError
from stickslip_explain.study import ExplainStudy, tempered
from stickslip_rig.observation import SimulatedRecords, observed
from stickslip_rig.records import write_record
from stickslip_rig.simulation import RigTests

RIG = {
    "system": {"mass": 0.1, "stiffness": 5e3, "normal_load": 10.0, "belt_speed": 0.01, "damping": 2.0},
    "friction": {"a1": 0.25, "a2": 0.4, "a3": 0.15, "a4": 0.02},
    "drive": {"strokes": 6, "stroke": 0.01},
    "sensor": {"rate": 2000.0, "force_noise": 0.02, "acceleration_noise": 0.1},
}
CURVE = {"a1": 0.25, "a2": 0.4, "a4": 0.02}
DRAWN = {"stiffness": {"lognormal": {"median": 5e3, "factor": 1.3}}, "a3": {"uniform": [0.05, 0.3]}}
PRIOR = CURVE | DRAWN


def explaining(*seen):
    """The configuration that explains observations."""
    return {"explain": {"observed": list(seen)}, "friction": CURVE, "uncertain": {"quantities": DRAWN}}


def recorded(number, law="stribeck", **truth):
    """A record of the rig with hum at 50 and 150 Hz, and noise of its own, without what only a simulation knows."""
    rng = np.random.default_rng([11, number])
    own = {"sensor": RIG["sensor"] | {"seed": 100 + number}, "friction": RIG["friction"] | {"law": law}}
    (test,) = RigTests(rig.make_rig(RIG | own).at(**truth)).tests([0])
    record, phases = test.record.drop_vars(["stick", "friction_force", "stiffness"]), rng.uniform(0, 2 * np.pi, 3)
    time = record["time"].values
    lines = zip((0.05, 0.03, 0.3), (50, 150, 50), phases, strict=True)
    hum = [size * np.sin(2 * np.pi * frequency * time + phase) for size, frequency, phase in lines]
    return record.assign(spring_force=record["spring_force"] + hum[0] + hum[1],
                         acceleration=record["acceleration"] + hum[2])  # fmt: skip


def truths(count):
    """Quantities drawn from the prior."""
    rng = np.random.default_rng(3)
    return [{"stiffness": 5e3 * 1.3 ** rng.standard_normal(), "a3": rng.uniform(0.05, 0.3)} for _ in range(count)]


def observation(record, unknown=("stiffness", "a3"), **at):
    """What a configuration that is resolved says of a record."""
    said = observed(record, rig.make_rig(RIG).at(**at), unknown, scatter=False)
    at = {name: value for name, value in (RIG["system"] | at).items() if name not in unknown}
    return at | {"record": "felt.csv", "drive": rig.make_rig(RIG).at(**at).resolved()} | said


@cache
def felt():
    return recorded(1)


def errors_at(said, truth):
    """By feature, how far the simulated rig is off what a record says, in units of Student's t."""
    config = make_config(explaining(said))
    (seen,) = config.study.observed
    friction = config.friction.model_copy(update={"a3": truth["a3"]})
    simulate = SimulatedRecords(seen.drive, seen.known, friction)
    results, _ = simulate({name: np.array([value]) for name, value in truth.items()}, stop_flag(), None)
    return {name: (np.log(results[name][0]) - one.log_mean) / one.log_std for name, one in seen.of_record.items()}


def test_a_record_is_explained_by_the_rig_it_was_made_on_and_not_by_another():
    said, truth = observation(felt()), {"stiffness": 5e3, "a3": 0.15}
    assert said["regime"] == ["stick_slip"]
    at_truth = errors_at(said, truth)
    assert len(at_truth) == 6 and max(map(abs, at_truth.values())) < 5
    assert abs(errors_at(said, truth | {"stiffness": 5.5e3})["stick_slip_period"]) > 20
    assert abs(errors_at(said, truth | {"a3": 0.165})["drop_mean"]) > 10


def test_a_record_in_a_configuration_is_what_it_says_once_it_is_resolved(tmp_path):
    write_record(felt(), tmp_path / "felt.csv")
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(RIG))
    path = tmp_path / "explain.yaml"
    path.write_text(yaml.safe_dump(explaining({"record": "felt.csv", "drive": "rig.yaml"})))
    config = load_config(path)
    (seen,) = config.study.observed
    assert seen.words == "record felt.csv: stick-slip, 6 features" and seen.conditions["belt_speed"] == 0.01
    assert "stiffness" not in seen.conditions
    assert make_config(config.resolved()) == config
    study = ExplainStudy.of(config, config.study, options_of(config))
    points = study.prior.values(np.random.default_rng(1).standard_normal((3, 2)))
    terms = study._law("stribeck").terms(points, stop_flag())
    assert terms.log_likelihood.shape == (3, 1) and np.isfinite(terms.log_likelihood).all()


VARIED = RIG | {"axes": {"mu_static": [0.4, 0.5]}}


@pytest.mark.parametrize(("seen", "words"), [
    ({"record": "felt.csv"}, "observed[0]: missing, expected the configuration of the rig: drive: rig.yaml"),
    ({"drive": RIG}, "observed[0]: missing, expected the name of a CSV file"),
    ({"record": 1, "drive": RIG}, "observed[0].record: got 1, expected the name of a CSV file"),
    ({"record": "felt.csv", "drive": RIG, "belt_speed": "1 N"}, "observed[0].belt_speed: got '1 N', expected a speed"),
    ({"record": "felt.csv", "drive": VARIED}, "drive: varies mu_static, expected one test"),
    ({"record": "nowhere.csv", "drive": RIG}, "nowhere.csv: no such file"),
])  # fmt: skip
def test_records_that_cannot_be_are_refused_at_their_place(seen, words):
    with pytest.raises(ConfigError) as raised:
        make_config(explaining(seen))
    assert words in str(raised.value)


@pytest.mark.parametrize(("drive", "load", "words"), [
    ({"strokes": 5, "stroke": 0.01}, 10.0, "lasts 6.119 s, and 5 strokes of drive 5.1 s"),
    ({"strokes": 3, "stroke": 0.02}, 10.0, "has 3 strokes, expected 4 at least"),
    (RIG["drive"], 20.0, "normal_load is 10 N, and 20 N in drive"),
])  # fmt: skip
def test_a_record_of_another_test_is_refused(drive, load, words):
    with pytest.raises(ValueError, match=words):
        observed(felt(), rig.make_rig(RIG | {"drive": drive}).at(normal_load=load), (), scatter=False)


def usable(count):
    """Records of quantities from the prior, with these and a number, but for those that are refused."""
    for number, truth in enumerate(truths(count)):
        try:
            yield number, truth, observation(recorded(number, **truth))
        except ValueError as refused:
            assert "does not show stick phases well enough" in str(refused)


# --- many records -----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_features_scatter_about_those_of_the_truth_as_the_likelihood_says():
    """Forty records with hum: of each feature 50 and 90 % lie where Student's t of four strokes has them."""
    found = {}
    for _, truth, seen in usable(40):
        for name, error in errors_at(seen, truth).items():
            found.setdefault(name, []).append(2 * abs(stats.t(3).cdf(error) - 0.5))
    for name, inside in found.items():
        for share in (0.5, 0.9):
            off = 3.5 * np.sqrt(share * (1 - share) / len(inside))
            assert np.mean(np.array(inside) <= share) == pytest.approx(share, abs=off), name


@pytest.mark.slow
def test_ranks_of_the_truth_among_draws_of_records_are_uniform():
    """A dozen records with hum, whose spring and drop of friction are drawn from the prior."""
    places = []
    for number, truth, seen in usable(16):
        config = make_config(explaining(seen))
        study = ExplainStudy.of(config, config.study, options_of(config))
        experiment, prior = study._law("stribeck"), study.prior
        draws = prior.values(tempered(
            lambda points, e=experiment, p=prior: e.terms(p.values(points), stop_flag()).log_likelihood[:, 0],
            2, 24, np.random.default_rng([5, number]),
        ).points)  # fmt: skip
        places.append([(np.count_nonzero(draws[name] < value) + 0.5) / 25 for name, value in truth.items()])
    assert len(places) >= 8
    for column in np.array(places).T:
        assert stats.kstest(column, "uniform").pvalue > 0.01


@pytest.mark.slow
def test_a_record_that_the_law_cannot_show_is_explained_by_nothing():
    """The truth is exponential in the speed, the law rational, and all but a3 is known of the curve."""
    with pytest.raises(ContradictionError, match=r"nothing explains this: observation 1 \(record felt.csv"):
        stickslip.explain([observation(felt())], PRIOR, laws="rational", particles=20, repetitions=2, progress=False)
