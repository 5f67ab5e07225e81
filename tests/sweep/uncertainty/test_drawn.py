"""Quantities drawn from values, row by row."""

import numpy as np
import pytest

from stickslip.config.reader import make_config
from stickslip.errors import ConfigError

CAR = {"mass": 2.0, "stiffness": 2e4, "normal_load": 30.0}


def refusal(config):
    with pytest.raises(ConfigError) as error:
        make_config(config)
    return str(error.value)


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
