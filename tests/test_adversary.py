"""Random cells, engine against judge; and that the adversary would notice."""

import os

import numpy as np
import pytest

from adversary import COURTS, challenge
from helpers import adversary_memory
from helpers.adversary_cells import FAMILIES, LAWS, draw
from helpers.adversary_court import NUMBERS, compare, judged, run_engine
from judge import INPUTS
from stickslip.vocabulary.cells import as_cells

SEED = int(os.environ.get("STICKSLIP_SEED", "7"))
CELLS = 40
CELL = {name: np.array([0.0]) for name in INPUTS} | {name: np.array([value]) for name, value in {
    "mass": 2.0, "stiffness": 50.0, "normal_load": 3.0, "belt_speed": 0.05, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1,
    "delta": 1.0, "ageing_time": 1.0, "mu_stop": np.nan, "mu_static": np.nan, "velocity": np.nan,
}.items()}  # fmt: skip
HYSTERETIC = CELL | {"mu_stop": np.array([1.2])}
SETTLING = CELL | {"damping": np.array([20.0]), "belt_speed": np.array([0.3])}
EACH = pytest.mark.parametrize("cell", [CELL, HYSTERETIC, SETTLING], ids=["plain", "hysteretic", "settling"])


@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_draws_cells_the_engine_accepts(family):
    laws, cells = draw(family, 200, np.random.default_rng(SEED))
    as_cells(cells)
    assert set(laws) <= set(LAWS)


@EACH
def test_a_right_answer_passes_and_a_wrong_one_does_not(cell):
    verdict, ours = judged(cell, "stribeck", 3e5), run_engine(cell, "stribeck", 1e-6)

    def named(**wrong):
        (outcome,) = compare(cell, "stribeck", 1e-6, ours | wrong, verdict)
        return [what for what, *_ in outcome]

    assert named() == []
    for name in (*NUMBERS, "settling_time"):
        assert named(**{name: ours[name] * (1 + 1e-2)}) == [name] * np.count_nonzero(np.nan_to_num(ours[name]))
    assert named(regime=np.array(["stuck"])) == ["regime"]
    if verdict["regime"][0] == "settles":
        assert named(kind=np.array(["other"])) == ["damped/creep"] and ours["kind"][0] in ("damped", "creep")


@pytest.mark.slow
@pytest.mark.parametrize("family", adversary_memory.FAMILIES)
def test_a_wrong_answer_about_a_contact_with_memory_is_noticed(family):
    """A draw of it: right as it is; a number wrong by a twentieth is noticed, but where it says nothing (the largest
    slip speed of a motion that creeps in is that of the belt), and so is each other regime.
    """
    count = 12 * len(adversary_memory.LAWS[family])
    law, cells = next(iter(adversary_memory.draw(family, count, np.random.default_rng(SEED)).items()))
    verdict = adversary_memory.judged(cells, law)
    ours = adversary_memory.run_engine(cells, law, 1e-6)
    right = [not outcome for outcome in adversary_memory.compare(cells, law, 1e-6, ours, verdict)]
    assert sum(right) >= 6
    force = np.abs(verdict["spring_force_max"]) + np.abs(verdict["spring_force_min"])
    for name in adversary_memory.NUMBERS:
        wrong = ours | {name: ours[name] + 0.05 * (force if "force" in name else ours[name])}
        outcomes = adversary_memory.compare(cells, law, 1e-6, wrong, verdict)
        defined = np.isfinite(verdict[name])
        if name in ("period", "slip_speed_min", "cycle_force_max", "cycle_force_min", "energy_per_cycle"):
            defined &= verdict["cycle"]
        noticed = [outcome for outcome, was, is_one in zip(outcomes, right, defined, strict=True) if was and is_one]
        named = [[what for what, *_ in found] for found in noticed if found]
        assert len(named) > 0.3 * len(noticed) and all(names == [name] for names in named), name
    outcomes = adversary_memory.compare(cells, law, 1e-6, ours | {"regime": np.full(len(right), 5)}, verdict)
    assert all(outcome[0][0] == "regime" for outcome, was in zip(outcomes, right, strict=True) if was)


@pytest.mark.slow
@pytest.mark.parametrize("family", COURTS)
def test_the_engine_agrees_with_the_judge_on_random_cells(family):
    disputes, _ = challenge(family, CELLS, SEED)
    assert not disputes, "\n".join(disputes)
