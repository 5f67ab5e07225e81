"""What is asked of a map, a cell or a study is asked of every contact: of curves, tables, bristles, rate and state."""

from statistics import NormalDist

import numpy as np
import pytest

import stickslip
from helpers.nightly import few
from stickslip.config.reader import parse_config
from stickslip.dataset.display import MapAxis
from stickslip.plots.marks import by_formula
from stickslip.vocabulary.quantities import REGIMES

TABLE = "table: {speed: [0.001, 0.005, 0.02, 0.1, 1.0], mu: [0.30, 0.29, 0.27, 0.25, 0.256]}"
BRISTLES = "contact_stiffness: 20 N/mm, contact_damping: 5 N s/m"
CURVE = "a1: 0.25, a2: 0, a3: 0.05, a4: 20 mm/s"
RATE_STATE = "law: rate_state_ageing, mu_0: 0.6, v_0: 1 um/s, a: 0.010, b: 0.018, D_c: 1 um"
CONTACTS = {  # friction; stiffness (N/mm) and belt speed (mm/s) of a map
    "curve": (CURVE, "[0.5, 20, 200]", "[1, 30, 300]"),
    "table": (TABLE, "[0.5, 20, 200]", "[2, 30, 300]"),
    "bristles": (f"{CURVE}, {BRISTLES}", "[0.5, 20, 200]", "[1, 30, 300]"),
    "table_on_bristles": (f"{TABLE}, {BRISTLES}", "[0.5, 20, 200]", "[2, 30, 300]"),
    "rate_state": (RATE_STATE, "[20, 90, 400]", "[0.001, 0.1, 3]"),
}
COMPUTED = [name for name in CONTACTS if name != "table_on_bristles"]  # which has kernels of its own
MEMORY = ["bristles", "rate_state"]


PAIR = {"mass": 1.0, "normal_load": 10.0, "mu_0": 0.6, "v_0": 1e-6, "a": 0.01, "b": 0.018, "D_c": 1e-6}


def text_of(contact):
    friction, stiffness, speed = CONTACTS[contact]
    units = [f"[{', '.join(f'{one} {unit}' for one in axis.strip('[]').split(','))}]"
             for axis, unit in ((stiffness, "N/mm"), (speed, "mm/s"))]  # fmt: skip
    mass = "1 kg" if contact == "rate_state" else "100 g, damping: 1 N s/m"
    return (
        f"system: {{mass: {mass}, normal_load: 10 N}}\nfriction: {{{friction}}}\n"
        f"axes:\n  stiffness: {units[0]}\n  belt_speed: {units[1]}\n"
    )


@pytest.fixture(scope="module")
def map_of():
    known = {}
    return lambda contact: known.setdefault(contact, stickslip.run(parse_config(text_of(contact))))


@pytest.mark.parametrize("contact", CONTACTS)
def test_what_a_result_says_of_its_configuration_is_read_again(contact):
    config = parse_config(text_of(contact))
    assert parse_config(config.to_yaml()) == config


@pytest.mark.parametrize("contact", few(COMPUTED, ["curve", *MEMORY]))
def test_a_cell_picked_out_of_a_map_is_the_cell_of_that_map(contact, map_of):
    ds = map_of(contact)
    at = {"stiffness": float(ds["stiffness"][0]), "belt_speed": float(ds["belt_speed"][1])}
    again = stickslip.evaluate(ds.stickslip.cell(**at), law=parse_config(ds.attrs["configuration"]).friction.law)
    assert float(again["spring_force_max"][0]) == float(ds["spring_force_max"][0, 1])


@pytest.mark.parametrize("contact", MEMORY)
def test_the_line_of_theory_over_few_cells_is_at_the_critical_stiffness(contact, map_of):
    ds = map_of(contact)
    speeds, stiffness, ratio = by_formula(ds, MapAxis(ds, "belt_speed"), MapAxis(ds, "stiffness"))
    some = slice(None, None, 16)
    cells = ds.stickslip.cell(stiffness=1e4, belt_speed=1.0) | {"belt_speed": speeds[some] * 1e-3}
    law = parse_config(ds.attrs["configuration"]).friction.law
    critical = stickslip.evaluate(cells, law=law, variables=["regime", "critical_stiffness"])["critical_stiffness"]
    known = 0
    for one, column in zip(critical.values * 1e-3, ratio[:, some].T, strict=True):
        if stiffness[0] < one < stiffness[-1]:
            assert np.exp(np.interp(0.0, column, np.log(stiffness))) == pytest.approx(one, rel=0.01)
            known += 1
    assert known > 1


def test_no_line_of_theory_is_made_up_where_cells_alone_know_it(map_of):
    for ds in (map_of("table"), map_of("bristles").drop_vars("a1")):
        assert by_formula(ds, MapAxis(ds, "belt_speed"), MapAxis(ds, "stiffness")) is None


@pytest.mark.slow
def test_rare_stick_slip_of_rate_and_state_friction_is_led_by_theory():
    """Against the border along the one parameter that scatters."""
    text = (
        "system: {mass: 1 kg, normal_load: 10 N, stiffness: 100 N/mm, belt_speed: 1 um/s}\n"
        f"friction: {{{RATE_STATE.replace(', D_c: 1 um', '')}}}\n"
        "uncertain:\n  subset: {samples: 200, repetitions: 4}\n"
        "  quantities: {D_c: {lognormal: {median: 1 um, factor: 1.08}}}\n"
    )
    ds = stickslip.run(parse_config(text))
    cell = PAIR | {"stiffness": 1e5, "belt_speed": 1e-6}
    border = stickslip.border(cell, "D_c", (0.5e-6, 1e-6), law="rate_state_ageing").isel(cell=0).dropna("crossing")
    ends = border["border"].values[border["regime_below"].values == REGIMES.index("stick_slip")]
    wanted = NormalDist().cdf(np.log(ends.max() * 1e6) / np.log(1.08))
    assert 0.4 * wanted < float(ds["probability"].values.ravel()[0]) < 2.5 * wanted
