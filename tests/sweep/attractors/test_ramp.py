"""Slow ramps: where vibration stops on the way up, and starts on the way down, against borders and closed forms."""

import numpy as np
import pytest

import stickslip
from helpers.nightly import few
from stickslip import theory
from stickslip.errors import ArgumentError
from stickslip.vocabulary.flags import REGIMES

ARTICLE = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
BSTAB = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "damping": 0.1, "a1": 0.5, "a2": 0.0, "a3": 0.5, "a4": 0.5}
STICK_SLIP = REGIMES.index("stick_slip")


def edge(ds, direction):
    """The values between which stick-slip ends or begins, by line; there is one such place on every line."""
    sticks = ds["regime"].sel(direction=direction).values == STICK_SLIP
    changes = np.diff(sticks.astype(int), axis=-1) != 0
    assert (changes.sum(axis=-1) == 1).all()
    i, values = np.argmax(changes, axis=-1), ds[ds["regime"].dims[-1]].values
    return values[i], values[i + 1]


@pytest.mark.parametrize("cell", few([ARTICLE, BSTAB, ARTICLE | {"stiffness": 0.2}, ARTICLE | {"damping": 0.03}], 2))
def test_vibration_stops_at_the_fold_and_starts_where_sliding_loses_stability(cell):
    """Within a step of the ramp; the fold is the border that starts from sticking have."""
    ds = stickslip.ramp(cell, "belt_speed", (0.1, 2.2), 300)
    up, down = edge(ds, "up"), edge(ds, "down")
    border = stickslip.border(cell, "belt_speed", (0.1, 2.2))
    fold = border["border"].values[0][border["regime_below"].values[0] == STICK_SLIP][0]
    start = theory.loss_of_stability(cell["a2"], cell["a3"], cell["a4"], cell.get("damping", 0.0), 1.0)
    assert up[0] < fold <= up[1] and down[0] <= start < down[1]
    ends = ds["vibration_end"].values
    assert ends[np.isfinite(ends)] == pytest.approx([fold], rel=1e-6) and ds["vibration_end"].attrs["units"] == "m s-1"


def test_lines_are_ramps_of_their_own():
    cells = ARTICLE | {"stiffness": [0.2, 1.0, 5.0]}
    together = stickslip.ramp(cells, "belt_speed", (0.2, 1.0), 41)
    for i, stiffness in enumerate(cells["stiffness"]):
        alone = stickslip.ramp(ARTICLE | {"stiffness": stiffness}, "belt_speed", (0.2, 1.0), 41)
        for name in together.data_vars:
            np.testing.assert_array_equal(together[name].isel(cell=i), alone[name].isel(cell=0))


@pytest.mark.parametrize("more", [{"mu_stop": 1.1}, {"ageing_rate": 0.05}, {"mu_static": 1.4}])
def test_contacts_with_memory_go_through_a_loop_as_well(more):
    ds = stickslip.ramp(ARTICLE | more, "belt_speed", (0.1, 1.5), 141)
    assert edge(ds, "up")[0] > edge(ds, "down")[1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"along": "velocity", "between": (0, 1)}, "along: velocity is a starting state"),
        ({"along": "belt_sped", "between": (0, 1)}, "did you mean belt_speed"),
        ({"along": "belt_speed", "between": (1, 0)}, "swap the ends"),
        ({"along": "belt_speed"}, "between: missing"),
        ({"along": "belt_speed", "between": (0, 1), "points": 1}, "points: got 1, expected a whole number from 2"),
        ({"along": "mu_stop", "between": (0.5, 2.0)}, "mu_start"),
    ],
)
def test_bad_input_is_refused(arguments, message):
    with pytest.raises((TypeError, ValueError, ArgumentError), match=message):
        stickslip.ramp(ARTICLE | {"belt_speed": 0.5}, **arguments)
