"""Quantities drawn from values, row by row: those of an explanation, or any others."""

import numpy as np
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


def refusal(config):
    with pytest.raises(ConfigError) as error:
        make_config(config)
    return str(error.value)


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


def test_rows_stay_together_and_each_is_as_probable():
    rng = np.random.default_rng(2)
    a1 = rng.uniform(0.1, 0.4, 100)
    values = {"a1": a1.tolist(), "a3": (0.5 - a1).tolist()}
    given = {name: {"drawn": one} for name, one in values.items()} | {"damping": {"uniform": [0, 1]}}
    config = make_config({
        "system": {**CAR, "belt_speed": 0.02}, "friction": {"a2": 0, "a4": 0.02}, "uncertain": {"quantities": given},
    })  # fmt: skip
    normals = rng.standard_normal((20_000, 3))
    drawn = config.uncertain.values(normals)
    np.testing.assert_allclose(drawn["a1"] + drawn["a3"], 0.5, rtol=1e-12)
    shares = np.array([(drawn["a1"] == one).mean() for one in a1])
    assert abs(shares - 0.01).max() < 5 * np.sqrt(0.01 / 20_000)
    assert abs(np.corrcoef(drawn["a1"], drawn["damping"])[0, 1]) < 0.03
    assert not config.uncertain.indices


def test_a_configuration_keeps_the_draws_and_needs_the_file_no_longer(explained):
    config = make_config(config_of(explained[0]))
    assert config.friction.law == "stribeck_delta" or config.friction.law == "stribeck"
    assert {*config.uncertain.names} == {"a1", "a3"}  # the car has a stiffness of its own
    text = config.to_yaml().replace(str(explained[0]), "gone.nc")
    assert parse_config(text).uncertain.quantities == config.uncertain.quantities


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ({"friction": {"law": "cubic"}}, "the law here is cubic"),
        ({"friction": {"law": "stribeck", "a1": 0.2, "a3": 0.1}}, "nothing is left to draw"),
    ],
)
def test_what_an_explanation_cannot_give_is_refused(explained, more, expected):
    assert expected in refusal(config_of(explained[0], **more))


def test_a_result_that_is_no_explanation_is_refused(tmp_path):
    stickslip.run("configs/quickstart.yaml", tmp_path / "map.nc", progress=False)
    assert "holds no draws" in refusal(config_of(tmp_path / "map.nc"))


@pytest.mark.parametrize(
    ("quantities", "more", "expected"),
    [
        ({"a1": [0.1, 0.2], "a3": [0.1, 0.2, 0.3]}, {}, "a3.drawn: got 3 values, expected 2 like a1"),
        ({"a1": [0.1, -0.2], "a3": [0.1, 0.2]}, {}, "a1"),
        ({"a1": [0.1]}, {"friction": {"a2": 0, "a3": 0.1, "a4": 0.1}}, "each of which is as probable"),
        ({"a1": [0.1, 0.2], "a3": [0.1, 0.2]}, {"indices": True}, "Sobol indices"),
        ({"a1": [0.1, 0.2], "a3": [0.1, 0.2]}, {"subset": {}}, "leads nowhere"),
        ({"a1": [0.1, 0.2], "a3": [0.1, 0.2]},
         {"correlation": {"between": ["a1", "a3"], "matrix": [[1, 0.5], [0.5, 1]]}},
         "quantities that have a distribution"),
    ],
)  # fmt: skip
def test_drawn_values_that_are_none_are_refused(quantities, more, expected):
    friction = more.pop("friction", {"a2": 0, "a4": 0.1})
    given = {name: {"drawn": values} for name, values in quantities.items()}
    config = {"system": {**CAR, "belt_speed": 0.1}, "friction": friction, "uncertain": {"quantities": given, **more}}
    assert expected in refusal(config)
