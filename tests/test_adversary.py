"""Random cells, engine against judge; and that the adversary would notice."""

import os

import numpy as np
import pytest

from adversary import challenge
from helpers.adversary_cells import FAMILIES, LAWS, draw
from helpers.adversary_court import NUMBERS, compare, run_engine
from judge import INPUTS, judge
from stickslip.vocabulary.cell_values import as_cells

SEED = int(os.environ.get("STICKSLIP_SEED", "7"))
CELLS = 40
CELL = dict.fromkeys(INPUTS, 0.0) | {
    "mass": 2.0, "stiffness": 50.0, "normal_load": 3.0, "belt_speed": 0.05, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1,
    "delta": 1.0, "ageing_time": 1.0, "mu_stop": np.nan, "mu_static": np.nan, "velocity": np.nan,
}  # fmt: skip


@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_draws_cells_the_engine_accepts(family):
    laws, cells = draw(family, 200, np.random.default_rng(SEED))
    as_cells(cells)
    assert set(laws) <= set(LAWS)


HYSTERETIC = CELL | {"mu_stop": 1.2}
SETTLING = CELL | {"damping": 20.0, "belt_speed": 0.3}


@pytest.mark.parametrize("cell", [CELL, HYSTERETIC, SETTLING], ids=["plain", "hysteretic", "settling"])
def test_a_right_answer_passes_and_a_wrong_one_does_not(cell):
    verdict, ours = judge({n: [v] for n, v in cell.items()}), run_engine([cell], "stribeck", 1e-6)
    assert compare([cell], "stribeck", 1e-6, ours, verdict) == [[]]
    for name in (*NUMBERS, "settling_time"):
        wrong = ours | {name: ours[name] * (1 + 1e-2)}
        (found,) = compare([cell], "stribeck", 1e-6, wrong, verdict)
        assert [what for what, *_ in found] == [name] * np.count_nonzero(np.nan_to_num(ours[name]))
    (found,) = compare([cell], "stribeck", 1e-6, ours | {"regime": np.array(["stuck"])}, verdict)
    assert found[0][:3] == ("regime", "stuck", verdict["regime"][0])


def test_damped_and_creep_are_told_apart():
    verdict, ours = judge({n: [v] for n, v in SETTLING.items()}), run_engine([SETTLING], "stribeck", 1e-6)
    (found,) = compare([SETTLING], "stribeck", 1e-6, ours | {"kind": np.array(["other"])}, verdict)
    assert [what for what, *_ in found] == ["damped/creep"] and ours["kind"][0] in ("damped", "creep")


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_the_engine_agrees_with_the_judge_on_random_cells(family):
    disputes, _ = challenge(family, CELLS, SEED, shortest=3)
    assert not disputes, "\n".join(d.line() for d in disputes)
