"""Files of observations: what they stand for, what is refused and where, and what the command says."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import stickslip
from stickslip.cli import main
from stickslip.config.reader import load_config, make_config, parse_config
from stickslip.errors import ConfigError, ContradictionError

TEXT = """\
title: Felt on steel
observed:
  - {belt_speed: 20 mm/s, normal_load: 10 N, regime: stick_slip, spring_force_max: 4.5 +- 0.1 N}
  - {belt_speed: 150 mm/s, normal_load: 10 N, regime: [damped, creep]}
prior:
  mass: 100 g
  stiffness: {lognormal: {median: 5 N/mm, factor: 1.5}}
  a1: {uniform: [0.05, 0.6]}
  a2: 0.8 s/m
  a3: 0.2
  a4: 20 mm/s
predict:
  axes: {belt_speed: {start: 5 mm/s, stop: 200 mm/s, num: 5}}
  draws: 8
particles: 60
repetitions: 2
mislabelled: 0.02
"""


def test_a_file_of_observations_is_a_configuration_in_other_words():
    config = parse_config(TEXT)
    plain = config.resolved()
    assert config.written_in["normal_load"] == "N" and config.written_in["belt_speed"] == "mm/s"
    assert plain["system"]["mass"] == 0.1 and plain["friction"]["a3"] == 0.2
    assert list(plain["uncertain"]["quantities"]) == ["stiffness", "a1"]
    assert plain["explain"]["observed"][0] == {
        "belt_speed": 0.02, "normal_load": 10.0, "regime": ["stick_slip"],
        "spring_force_max": {"value": 4.5, "scatter": pytest.approx(0.1)},
    }  # fmt: skip
    assert plain["explain"]["draws"] == 8 and list(plain["axes"]) == ["belt_speed"]
    assert parse_config(config.to_yaml()) == config == make_config(plain)


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
    for shard in ("1/2", "2/2"):
        stickslip.run_shard(config, shard, tmp_path / "store")
    collected = stickslip.collect(tmp_path / "store", tmp_path / "felt.nc")
    for name in whole.data_vars:
        np.testing.assert_array_equal(whole[name], alone[name], err_msg=str(name))
        np.testing.assert_array_equal(whole[name], collected[name], err_msg=str(name))


def test_a_population_that_is_not_computed_yet_is_left_out(tmp_path):
    stickslip.run_shard(parse_config(TEXT), "1/2", tmp_path / "one")
    assert stickslip.collect(tmp_path / "one", tmp_path / "one.nc").sizes["draw"] == 60  # one of two populations


@pytest.mark.slow
def test_that_no_population_is_computed_yet_is_said(tmp_path):
    two_laws = parse_config(TEXT.replace("  a4: 20 mm/s\n", "  a4: 20 mm/s\n  laws: [stribeck, rational]\n"))
    stickslip.run_shard(two_laws, "1/4", tmp_path / "none")
    stickslip.collect(tmp_path / "none", tmp_path / "none.nc")  # of no repetition all laws
    done = CliRunner().invoke(main, ["inspect", str(tmp_path / "none.nc")])
    assert (done.exit_code, done.output) == (0, "no population is computed yet\n")


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("regime: stick_slip", "regime: squeak", ":3:", " observed[0].regime: got"),
        ("regime: stick_slip", "regim: stick_slip", ":3:", "did you mean regime?"),
        ("spring_force_max: 4.5 +- 0.1 N", "spring_force_max: 4.5 N", ":3:", "a value above 0 with its standard"),
        ("spring_force_max: 4.5 +- 0.1 N", "spring_force_max: 4.5 +- 0.1 ms", ":3:", "N"),
        ("spring_force_max: 4.5 +- 0.1 N", "spring_force_max: [4.5 N, 4.5 N]", ":3:", "two at least, which differ"),
        ("spring_force_max: 4.5 +- 0.1 N", "squeal: 4.5 +- 0.1 N", ":3:", "unknown key"),
        (", regime: [damped, creep]", "", ":4:", "nothing was observed"),
        ("belt_speed: 150 mm/s, ", "", ":4:", "belt_speed: missing"),
        ("  a4: 20 mm/s\n", "", "friction.a4", "missing"),
        ("  a4: 20 mm/s\n", "  a4: 20 N\n", ":11:", "force"),
        ("  a4: 20 mm/s\n", "  a4: 20 mm/s\n  laws: [stribek]\n", ":12:", "stribeck"),
        ("  a4: 20 mm/s\n", "  a4: 20 mm/s\n  laws: [stribeck, rate_state_slip]\n", ":12:", "laws of one model"),
        ("  a4: 20 mm/s\n", "  a4: 20 mm/s\n  delta: {uniform: [1, 2]}\n  laws: [stribeck_delta, stribeck]\n", ":13:",
         "got stribeck, which has no delta"),
        ("  a4: 20 mm/s\n", "  a4: 20 mm/s\n  delta: {uniform: [1, 2]}\n  laws: [gaussian]\n", ":13:", "delta is"),
        ("  mass: 100 g\n", "  mass: 100 g\n  weight: 2\n", ":7:", "did you mean mass?"),
        ("  a1: {uniform: [0.05, 0.6]}", "  a1: {uniform: [0.6, 0.05]}", ":8:",
         " prior.a1.uniform: got uniform, low 0.6"),
        ("mislabelled: 0.02", "mislabelled: 2", ":17:", "at most 0.5"),
        ("150 mm/s, normal_load: 10 N", "150 mm/s, normal_load: 20 N", ":13:", "differs between"),
        ("num: 5}", "num: 0}", ":13:", " predict.axes.belt_speed.num: "),
    ],
)  # fmt: skip
def test_bad_input_is_refused_at_its_place(tmp_path, old, new, place, words):
    path = tmp_path / "felt.yaml"
    path.write_text(TEXT.replace(old, new, 1))
    with pytest.raises(ConfigError) as raised:
        load_config(path)
    said = str(raised.value)
    assert place in said and words in said, said


@pytest.mark.parametrize("cut", ["observed", "prior"])
def test_observations_need_a_prior_and_a_prior_observations(cut):
    data = {"observed": [{"belt_speed": 1, "regime": "damped"}], "prior": {"mass": 1}}
    del data[cut]
    with pytest.raises(ConfigError, match=f"{cut}: "):
        make_config(data)


def test_nothing_explains_and_the_observation_that_contradicts_is_named_with_its_line(tmp_path):
    """Faster and slower than where it squeaks it is quiet, and the prior has no spring that does that."""
    text = TEXT[: TEXT.index("predict:")] + "particles: 60\nrepetitions: 2\n"
    text = text.replace("prior:", "  - {belt_speed: 22 mm/s, normal_load: 10 N, regime: stuck}\nprior:")
    path = tmp_path / "felt.yaml"
    path.write_text(text)
    done = CliRunner().invoke(main, ["explain", str(path), "-o", str(tmp_path / "felt.nc"), "--json"])
    assert done.exit_code == 1, done.output
    assert f"{path}:5:5: nothing explains this: observation 3 (" in done.stderr
    assert json.loads(done.stdout)["observation"] == 2
    with pytest.raises(ContradictionError, match="nothing explains this: observation 3") as raised:
        stickslip.explain(path, progress=False)
    assert float(raised.value.dataset["contradicted"][2]) == 1.0


def test_a_result_beyond_the_prior_is_named(tmp_path):
    path = tmp_path / "felt.yaml"
    path.write_text(TEXT.replace("4.5 +- 0.1 N", "95 +- 0.1 N"))
    with pytest.raises(ContradictionError, match=r"observation 1 \(.*spring_force_max 95 N\)"):
        stickslip.explain(path, progress=False)


def test_cells_without_a_verdict_widen_the_evidence():
    """Nothing is decided within a step: the evidence lies between what all labels right and all wrong would give."""
    text = TEXT.replace(", spring_force_max: 4.5 +- 0.1 N", "") + "solver: {max_steps: 1}\n"
    found = stickslip.run(parse_config(text), progress=False)
    other = 0.02 / 4
    assert float(found["log_evidence"][0]) == pytest.approx(np.log(0.98 * (0.98 + other)))
    assert float(found["log_evidence_low"][0]) == pytest.approx(np.log(other * 2 * other))
    assert found.attrs["explained_undecided"].startswith("100 %")


def test_the_command_tells_what_is_fixed_and_writes_all_it_is_asked_for(tmp_path):
    path, files = tmp_path / "felt.yaml", [tmp_path / name for name in ("felt.nc", "felt.png", "felt.html")]
    path.write_text(TEXT)
    done = CliRunner().invoke(
        main, ["explain", str(path), "-o", str(files[0]), "--plot", str(files[1]), "--report", str(files[2])]
    )
    assert done.exit_code == 0, done.output
    assert "the observations fix a1" in done.output and "stiffness" in done.output
    assert all(file.stat().st_size > 1000 for file in files)
    assert CliRunner().invoke(main, ["explain", "configs/quickstart.yaml"]).exit_code == 2
    for words in (["validate", str(path)], ["plan", str(path)], ["plot", str(files[0]), "-o", str(tmp_path / "a.png")]):
        done = CliRunner().invoke(main, words)
        assert done.exit_code == 0, (words, done.output)
    assert "fixed" in CliRunner().invoke(main, ["inspect", str(files[0])]).output
    assert stickslip.open(files[0]).stickslip.plot("probability").axes


def test_repeats_a_correlation_and_a_law_by_its_other_name_are_read():
    config = parse_config("""\
observed:
  - {belt_speed: 0.1, regime: stick_slip, period: [1.9 s, 2.0 s, 2.2 s]}
prior: {mass: 1, normal_load: 1, a2: 0.1, a4: 0.1, laws: [gaussian, stribeck], a3: 0.3,
        stiffness: {normal: {mean: 10, std: 0.1}}, a1: {normal: {mean: 1, std: 0.1}},
        correlation: {between: [stiffness, a1], matrix: [[1, 0.1], [0.1, 1]]}}
""")
    assert config.friction.law == "stribeck_delta" and config.study.laws == ("gaussian", "stribeck")
    assert config.study.observed[0].metrics["period"].freedom == 2
    np.testing.assert_allclose(config.uncertain.correlation, [[1, 0.1], [0.1, 1]])
