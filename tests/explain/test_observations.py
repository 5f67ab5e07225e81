"""Files of observations: what they stand for, what is refused and where, and what the command says."""

import json

import numpy as np
import pytest

import stickslip
from helpers.commands import call
from helpers.data import DATA, cases
from stickslip.config.reader import load_config, make_config, parse_config
from stickslip.errors import ConfigError, ContradictionError
from stickslip_explain.section import Observation

TEXT = (DATA / "felt.yaml").read_text(encoding="utf-8")
LAWS = "  mislabelled: 0.02\n"


def with_laws(*laws):
    return TEXT.replace(LAWS, f"{LAWS}  laws: [{', '.join(laws)}]\n")


def test_the_call_and_the_file_give_the_same(tmp_path):
    path = tmp_path / "felt.yaml"
    path.write_text(TEXT)
    of_file = stickslip.explain(path, progress=False)
    observed = [
        {"belt_speed": 0.02, "normal_load": "10 N", "regime": "stick_slip", "spring_force_max": "4.5 +- 0.1 N"},
        {"belt_speed": "150 mm/s", "normal_load": 10.0, "regime": ["damped", "creep"]},
    ]
    prior = {"mass": "100 g", "stiffness": {"lognormal": {"median": "5 N/mm", "factor": 1.5}},
             "a1": {"uniform": [0.05, 0.6]}, "a2": 0.8, "a3": 0.2, "a4": "20 mm/s"}  # fmt: skip
    of_call = stickslip.explain(
        observed, prior, predict={"belt_speed": np.linspace(0.005, 0.2, 5)}, draws=8, particles=60, repetitions=2,
        mislabelled=0.02, progress=False,
    )  # fmt: skip
    for name in of_file.data_vars:
        np.testing.assert_array_equal(of_file[name], of_call[name], err_msg=str(name))


def test_threads_shards_and_files_do_not_change_a_bit(tmp_path):
    config = parse_config(TEXT)
    whole = stickslip.run(config, progress=False)
    alone = stickslip.run(make_config({**config.resolved(), "execution": {"threads": 1}}), progress=False)
    stickslip.run_shard(config, "1/2", tmp_path / "store")
    half = stickslip.collect(tmp_path / "store", tmp_path / "half.nc")
    assert half.sizes["draw"] == 60  # one of two populations; the other is not computed yet
    stickslip.run_shard(config, "2/2", tmp_path / "store")
    collected = stickslip.collect(tmp_path / "store", tmp_path / "felt.nc")
    for name in whole.data_vars:
        np.testing.assert_array_equal(whole[name], alone[name], err_msg=str(name))
        np.testing.assert_array_equal(whole[name], collected[name], err_msg=str(name))


@pytest.mark.slow
def test_that_no_population_is_computed_yet_is_said(tmp_path):
    stickslip.run_shard(parse_config(with_laws("stribeck", "rational")), "1/4", tmp_path / "none")
    stickslip.collect(tmp_path / "none", tmp_path / "none.nc")  # of no repetition all laws
    done = call("inspect", tmp_path / "none.nc")
    assert (done.exit_code, done.output) == (0, "no population is computed yet\n")


@cases("explain.yaml")
def test_bad_input_is_refused_at_its_place(tmp_path, old, new, place, words):
    path = tmp_path / "felt.yaml"
    path.write_text(TEXT.replace(old, new, 1))
    with pytest.raises(ConfigError) as raised:
        load_config(path)
    said = str(raised.value)
    assert place in said and words in said, said


def test_nothing_explains_and_the_observation_that_contradicts_is_named_with_its_line(tmp_path):
    """Faster and slower than where it squeaks it is quiet, and the prior has no spring that does that."""
    text = TEXT[: TEXT.index("axes:")].replace(LAWS, "")
    text = text.replace("  particles", "    - {belt_speed: 22 mm/s, normal_load: 10 N, regime: stuck}\n  particles")
    path = tmp_path / "felt.yaml"
    path.write_text(text)
    done = call("explain", path, "-o", tmp_path / "felt.nc", "--json")
    assert done.exit_code == 1, done.output
    assert f"{path}:6:7: nothing explains this: observation 3 (" in done.stderr
    assert json.loads(done.stdout)["observation"] == 2
    with pytest.raises(ContradictionError, match="nothing explains this: observation 3") as raised:
        stickslip.explain(path, progress=False)
    assert float(raised.value.dataset["contradicted"][2]) == 1.0
    path.write_text(TEXT.replace("4.5 +- 0.1 N", "95 +- 0.1 N"))
    with pytest.raises(ContradictionError, match=r"observation 1 \(.*spring_force_max 95 N\)"):
        stickslip.explain(path, progress=False)


def test_cells_without_a_verdict_widen_the_evidence():
    """Nothing is decided within a step: the evidence lies between what all labels right and all wrong would give."""
    text = TEXT.replace(", spring_force_max: 4.5 +- 0.1 N", "") + "solver: {max_steps: 1}\n"
    found = stickslip.run(parse_config(text), progress=False)
    other = 0.02 / 4
    assert float(found["log_evidence"][0]) == pytest.approx(np.log(0.98 * (0.98 + other)))
    assert found.attrs["explained_undecided"] == 1.0


def test_the_command_tells_what_is_fixed_and_writes_all_it_is_asked_for(tmp_path):
    path, files = tmp_path / "felt.yaml", [tmp_path / name for name in ("felt.nc", "felt.png", "felt.html")]
    path.write_text(TEXT)
    done = call("explain", path, "-o", files[0], "--plot", files[1], "--report", files[2])
    assert done.exit_code == 0, done.output
    assert "direction ratio" in done.output and "stiffness" in done.output
    assert all(file.stat().st_size > 1000 for file in files)
    assert call("explain", "configs/quickstart.yaml").exit_code == 2
    for words in (["validate", str(path)], ["plan", str(path)], ["plot", str(files[0]), "-o", str(tmp_path / "a.png")]):
        done = call(*words)
        assert done.exit_code == 0, (words, done.output)
    assert "variance left" in call("inspect", files[0]).output
    assert stickslip.open(files[0]).stickslip.plot("probability").axes


def test_repeats_a_correlation_and_a_law_by_its_other_name_are_read():
    config = parse_config("""\
explain: {observed: [{belt_speed: 0.1, regime: stick_slip, period: [1.9 s, 2.0 s, 2.2 s]}], laws: [gaussian, stribeck]}
system: {mass: 1, normal_load: 1}
friction: {a2: 0.1, a3: 0.3, a4: 0.1}
uncertain:
  quantities: {stiffness: {normal: {mean: 10, std: 0.1}}, a1: {normal: {mean: 1, std: 0.1}}}
  correlation: {between: [stiffness, a1], matrix: [[1, 0.1], [0.1, 1]]}
""")
    assert config.study.laws == ("gaussian", "stribeck")
    assert config.study.observed[0].metrics["period"].freedom == 2
    np.testing.assert_allclose(config.uncertain.correlation, [[1, 0.1], [0.1, 1]])
    assert parse_config(config.to_yaml()) == config == make_config(config.resolved())


@cases("explain.yaml")
def test_calls_refuse_what_cannot_be_a_prior(uncertain, laws, words):
    prior = {"mass": 1, "normal_load": 1, "stiffness": 1, "a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1} | uncertain
    with pytest.raises(ValueError) as raised:
        stickslip.explain([{"belt_speed": 1, "regime": "damped"}], prior, laws=laws)
    assert words in str(raised.value)


SHORT = (DATA / "felt_in_other_words.yaml").read_text(encoding="utf-8")


def test_observations_and_a_prior_alone_are_a_configuration_in_other_words():
    config = parse_config(SHORT)
    plain = config.resolved()
    assert plain["system"]["mass"] == 0.1 and list(plain["uncertain"]["quantities"]) == ["a1"]
    assert config.friction.law == "stribeck_delta" and config.study.laws == ("gaussian", "stribeck")
    assert plain["explain"]["draws"] == 8 and list(plain["axes"]) == ["belt_speed"]
    assert parse_config(config.to_yaml()) == config == make_config(plain)


@cases("explain.yaml")
def test_errors_in_them_name_places_and_keys_as_they_are_written(right, wrong, line, words):
    with pytest.raises(ConfigError) as raised:
        parse_config(SHORT.replace(right, wrong))
    assert line in str(raised.value) and words in str(raised.value)


@pytest.mark.parametrize("text", [
    "54 +- 2 ms", "54 ms +- 2 ms", "54 ms ± 2 ms", "54 ms +/- 0.002 s", "0.054 +- 0.002", "50 ms +- 4 %",
])  # fmt: skip
def test_scatter_is_read_as_people_write_it(text):
    """Both numbers have a unit, or the first takes that of the second."""
    measured = Observation.model_validate({"period": text}).metrics["period"]
    assert (measured.value, measured.scatter) == pytest.approx((0.05, 0.002) if "%" in text else (0.054, 0.002))
    with pytest.raises(ValueError, match="expected a unit with 2 as well, since others have"):
        Observation.model_validate({"period": "54 ms +- 2"})
