"""Random cells, engine against judge; and that the adversary would notice."""

import os

import numpy as np
import pytest

from adversary import challenge
from adversary_cells import FAMILIES, LAWS, REFUSED, draw
from adversary_court import NUMBERS, compare, run_engine
from judge import INPUTS, judge
from stickslip.cells import as_cells

SEED = int(os.environ.get("STICKSLIP_SEED", "7"))
CELLS = 40
CELL = dict.fromkeys(INPUTS, 0.0) | {
    "mass": 2.0, "stiffness": 50.0, "normal_load": 3.0, "belt_speed": 0.05, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1,
    "delta": 1.0, "ageing_time": 1.0, "mu_stop": np.nan, "mu_static": np.nan, "velocity": np.nan,
}  # fmt: skip


@pytest.mark.parametrize("family", [f for f in FAMILIES if f not in REFUSED])
def test_every_family_draws_cells_the_engine_accepts(family):
    laws, cells = draw(family, 200, np.random.default_rng(SEED))
    as_cells(cells)
    assert set(laws) <= set(LAWS)


def test_a_right_answer_passes_and_a_wrong_one_does_not():
    verdict, ours = judge({n: [v] for n, v in CELL.items()}), run_engine([CELL], "stribeck", 1e-6)
    assert compare([CELL], "stribeck", 1e-6, ours, verdict) == [[]]
    for name in NUMBERS:
        wrong = ours | {name: ours[name] * (1 + 1e-3)}
        (found,) = compare([CELL], "stribeck", 1e-6, wrong, verdict)
        assert [what for what, *_ in found] == [name]
    (found,) = compare([CELL], "stribeck", 1e-6, ours | {"regime": np.array(["settles"])}, verdict)
    assert found[0][:3] == ("regime", "settles", "stick_slip")


@pytest.mark.slow
@pytest.mark.parametrize("family", [f for f in FAMILIES if f not in REFUSED])
def test_the_engine_agrees_with_the_judge_on_random_cells(family):
    disputes, _ = challenge(family, CELLS, SEED, shortest=3)
    assert not disputes, "\n".join(d.line() for d in disputes)
