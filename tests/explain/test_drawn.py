"""`uncertain: {explained: felt.nc}`: quantities drawn from the values of an explanation, row by row."""

import pytest

import stickslip
from helpers.nightly import few
from stickslip.config.reader import make_config, parse_config
from stickslip.errors import ConfigError

CAR = {"mass": 2.0, "stiffness": 2e4, "normal_load": 30.0}
SPEEDS = [0.01, 0.05, 0.2]


@pytest.fixture(scope="module", params=few([["stribeck"], ["stribeck", "gaussian"]], 1), ids=" and ".join)
def explained(request, tmp_path_factory):
    """One law or two, a quantity of the rig and one of the curve, and a coefficient that was known."""
    seen = [
        {"belt_speed": 0.02, "normal_load": 10.0, "regime": "stick_slip", "period": "45 +- 2 ms"},
        {"belt_speed": 0.15, "normal_load": 10.0, "regime": ["damped", "creep"]},
    ]
    prior = {
        "mass": 0.1, "a1": {"uniform": [0.1, 0.4]}, "a2": 0.4, "a4": 0.02, "a3": {"uniform": [0, 0.5]},
        "stiffness": {"lognormal": {"median": 5e3, "factor": 1.5}},
    }  # fmt: skip
    file = tmp_path_factory.mktemp("explained") / "felt.nc"
    return file, stickslip.explain(seen, prior, laws=request.param, particles=60, output=file, progress=False)


def config_of(file, **more):
    uncertain = {"explained": str(file), "draws": 256, "scramblings": 4, "metrics": []}
    return {"system": dict(CAR), "axes": {"belt_speed": SPEEDS}, "uncertain": uncertain} | more


def test_another_system_with_the_curve_explained_squeaks_as_often_as_its_draws_do(explained):
    file, ds = explained
    for number, name in enumerate(ds["law"].values):
        law, more = ("stribeck_delta", {"delta": 2.0}) if name == "gaussian" else ("stribeck", {})
        mapped = stickslip.run(config_of(file, friction={"law": law}), progress=False)
        chosen = ds["posterior_law"].values == number
        curve = {a: ds[f"posterior_{a}"].values[chosen] for a in ("a1", "a3")} | {"a2": 0.4, "a4": 0.02} | more
        for speed in SPEEDS:
            regimes = stickslip.evaluate(CAR | curve | {"belt_speed": speed}, law=law, variables=["regime"])["regime"]
            share = float((regimes == 1).mean())
            probability = float(mapped["probability"].sel(state="stick_slip", belt_speed=speed))
            assert probability == pytest.approx(share, abs=1 / chosen.sum() + 1 / 256)
        assert 0.0 < float(mapped["probability"].sel(state="stick_slip", belt_speed=0.05)) <= 1.0


def test_a_configuration_keeps_the_draws_and_needs_the_file_no_longer(explained):
    config = make_config(config_of(explained[0]))
    assert config.friction.law == "stribeck_delta" or config.friction.law == "stribeck"
    assert {*config.uncertain.names} == {"a1", "a3"}  # the car has a stiffness of its own
    text = config.to_yaml().replace(str(explained[0]), "gone.nc")
    assert parse_config(text).uncertain.quantities == config.uncertain.quantities


def test_what_an_explanation_cannot_give_and_what_is_none_are_refused(explained, tmp_path):
    stickslip.run("configs/quickstart.yaml", tmp_path / "map.nc", progress=False)
    for file, more, expected in (
        (explained[0], {"friction": {"law": "cubic"}}, "the law here is cubic"),
        (explained[0], {"friction": {"law": "stribeck", "a1": 0.2, "a3": 0.1}}, "nothing is left to draw"),
        (tmp_path / "map.nc", {}, "holds no draws"),
    ):
        with pytest.raises(ConfigError, match=expected):
            make_config(config_of(file, **more))
