"""The judge of contacts with memory against reference cycles that neither it nor the kernels have solved."""

import csv
from pathlib import Path

import numpy as np
import pytest

from helpers.adversary_memory import judged
from judge import memory, radau
from judge.memory_motion import rates

pytestmark = pytest.mark.slow  # by day what the judge said stands in data/judge.json
DATA = Path(__file__).parent / "data"
WITHIN = 3e-8  # as the judge computes by default; what it is used for is 100 tolerances of 1e-8
COMMON = {"mass": "m", "stiffness": "k", "damping": "c", "belt_speed": "v_b"}
RATE_STATE = COMMON | {"normal_load": "N", "mu_0": "mu0", "v_0": "v0", "a": "a", "b": "b", "D_c": "Dc"}
BRISTLES = COMMON | {
    "normal_load": "Fc", "a4": "vs", "delta": "delta", "contact_stiffness": "s0", "contact_damping": "s1",
}  # fmt: skip
START = {"displacement": 0.0, "velocity": np.nan, "contact_time": 0.0}


def test_the_coefficients_are_those_of_radau():
    """Nodes of order 9: all moments up to the eighth; two of the nodes as Hairer and Wanner list them (IV.5)."""
    weights = radau.MATRIX[-1]
    for power in range(9):
        assert weights @ radau.NODES**power == pytest.approx(1.0 / (power + 1), rel=1e-13)
    np.testing.assert_allclose(radau.NODES[[0, -1]], [0.05710419611451768, 1.0], rtol=1e-14)


def rows_of(file):
    listed = csv.DictReader((DATA / file).read_text().splitlines())
    return [row for row in listed if float(row["m"]) > 0.0]


@pytest.mark.parametrize("row", rows_of("rate_and_state.csv"), ids=lambda row: row["id"])
def test_reference_cycles_of_rate_and_state(row):
    cell = {name: np.array([float(row[column])]) for name, column in RATE_STATE.items()}
    rows = memory.kernel_rows({**cell, **{n: np.array([v]) for n, v in START.items()}}, f"rate_state_{row['law']}")
    check(cell, memory.judge_memory(rows)[0], row, "F_max", "F_min")


@pytest.mark.parametrize("row", rows_of("rate_and_state.csv")[:4], ids=lambda row: row["id"])
def test_the_regularised_form_has_these_cycles_as_well(row):
    """Friction stays far above a in them; from rest on the belt."""
    cell = {name: np.array([float(row[column])]) for name, column in RATE_STATE.items()}
    start = {**START, "velocity": float(row["v_b"])}
    law = f"rate_state_{row['law']}"
    rows = memory.kernel_rows({**cell, **{n: np.array([v]) for n, v in start.items()}}, law, regularised=True)
    check(cell, memory.judge_memory(rows)[0], row, "F_max", "F_min")


@pytest.mark.parametrize("law", ["rate_state_ageing", "rate_state_slip"])
def test_the_jacobian_of_slip_both_ways_is_that_of_differences(law):
    cell = {"mass": 1.0, "stiffness": 2e4, "damping": 3.0, "belt_speed": 0.1, "normal_load": 10.0, "mu_0": 0.3,
            "v_0": 1e-2, "a": 0.1, "b": 0.15, "D_c": 1e-3, **START}  # fmt: skip
    (p,) = memory.kernel_rows({name: np.array([value]) for name, value in cell.items()}, law, regularised=True)
    found, up, down = np.empty((3, 3)), np.empty(3), np.empty(3)
    for y in ([0.1, 0.3, 0.2], [-3.0, -5.0, 0.4], [-1.0, -12.0, -0.5]):
        y = np.array(y)
        memory.jacobian(p, y, found)
        for n in range(3):
            off = 1e-5 * np.eye(3)[n]
            rates(p, y + off, up)
            rates(p, y - off, down)
            np.testing.assert_allclose(found[:, n], (up - down) / 2e-5, rtol=1e-6, atol=1e-7 * np.abs(found).max())


@pytest.mark.parametrize("row", rows_of("lugre.csv"), ids=lambda row: row["id"])
def test_reference_cycles_of_bristles(row):
    cell = {name: np.array([float(row[column])]) for name, column in BRISTLES.items()}
    fc, fs, s_2 = (float(row[name]) for name in ("Fc", "Fs", "s2"))
    cell |= {"a1": np.ones(1), "a2": np.array([s_2 / fc]), "a3": np.array([fs / fc - 1.0])}
    cell |= {"contact_damping_speed": np.array([np.nan]), "elastic_part": np.zeros(1)}
    rows = memory.kernel_rows({**cell, **{n: np.array([v]) for n, v in START.items()}}, "stribeck_delta")
    check(cell, memory.judge_memory(rows)[0], row, "kx_max", "kx_min")


def check(cell, answer, row, highest, lowest):
    if not row["period"]:
        assert answer[memory.REGIME] == memory.SETTLES
        return
    assert answer[memory.REGIME] == memory.CYCLE and answer[memory.LOOPS] == 1.0
    mass, stiffness, load = (cell[name][0] for name in ("mass", "stiffness", "normal_load"))
    speed = load / np.sqrt(mass * stiffness)
    assert answer[memory.PERIOD] * np.sqrt(mass / stiffness) == pytest.approx(float(row["period"]), rel=WITHIN)
    assert answer[memory.F_MAX] * load == pytest.approx(float(row[highest]), rel=WITHIN)
    assert answer[memory.F_MIN] * load == pytest.approx(float(row[lowest]), rel=WITHIN)
    assert answer[memory.FASTEST] * speed == pytest.approx(float(row["w_max"]), rel=WITHIN)
    assert answer[memory.SLOWEST] * speed == pytest.approx(float(row["w_min"]), rel=WITHIN)


def test_the_largest_acceleration_between_samples_is_found():
    """A peak just after the start: DOP853 at 1e-12 has 0.9164991587574 m/s2."""
    cell = {
        "mass": 10.297950532599097, "stiffness": 302.0667341376537, "normal_load": 211.0604033352879,
        "belt_speed": -0.26407360793465956, "damping": 35.720093056264886, "a1": 0.1760085137839149,
        "a2": 0.007916049974693978, "a3": 0.48752974785126824, "a4": 4.230984755325421, "delta": 2.1397764769079712,
        "contact_stiffness": 211749.10525533473, "contact_damping_speed": 27.022804335570477,
    }  # fmt: skip
    verdict = judged({name: np.array([value]) for name, value in cell.items()}, "stribeck_delta")
    assert verdict["acceleration_max"][0] == pytest.approx(0.9164991587574, rel=1e-11)
