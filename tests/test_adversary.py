"""Random cells, engine against judge; and that the adversary would notice."""

import os

import numpy as np
import pytest

import stickslip
from adversary import ALL_FAMILIES, challenge
from helpers import adversary_memory
from helpers.adversary_cells import FAMILIES, LAWS, draw
from helpers.adversary_court import NUMBERS, compare, run_engine
from judge import INPUTS, judge
from stickslip.vocabulary.cells import as_cells

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
@pytest.mark.parametrize("family", adversary_memory.FAMILIES)
def test_a_wrong_answer_about_a_contact_with_memory_is_noticed(family):
    """A draw of it: right as it is; a number wrong by a twentieth is noticed, but where it says nothing (the largest
    slip speed of a motion that creeps in is that of the belt), and so is each other regime.
    """
    count = 12 * len(adversary_memory.LAWS[family])
    law, cells = next(iter(adversary_memory.draw(family, count, np.random.default_rng(SEED)).items()))
    verdict = adversary_memory.judged(cells, law)
    ds = stickslip.evaluate(cells, 1e-6, law=law, max_steps=adversary_memory.MOST_STEPS)
    ours = {name: ds[name].values for name in ds.data_vars}
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
@pytest.mark.parametrize("family", ALL_FAMILIES)
def test_the_engine_agrees_with_the_judge_on_random_cells(family):
    disputes, _ = challenge(family, CELLS, SEED, shortest=3)
    assert not disputes, "\n".join(d.line() for d in disputes)
