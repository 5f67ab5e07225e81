"""Borders of regimes, against closed forms and root solves by SciPy."""

import re
from functools import partial

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import stickslip
from helpers.commands import call
from helpers.configs import write_config
from helpers.data import cases
from stickslip import theory
from stickslip.config.reader import parse_config
from stickslip.files import writing
from stickslip.studies.search import Looked, Scan, search_lines
from stickslip.vocabulary.quantities import METHODS, REGIMES

PAIR = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
STICK_SLIP, DAMPED, CREEP = (REGIMES.index(name) for name in ("stick_slip", "damped", "creep"))
BELT = (0.01, 5.0)
RANGE = {"belt_speed": BELT, "damping": (0.0, 2.0), "stiffness": (1e-4, 1e5)}
LINES = 10


def only(ds):
    """The borders of lines that have one each."""
    assert ds.sizes["crossing"] == 1 and not ds["border"].isnull().any()
    return ds["border"].values[..., 0]


def least_slip_speed(cell):
    """The minimum of w at the end of the first slip, by DOP853; below 0 where it would stick, mu(0) taken there."""
    m, k, c, load, v = (cell[name] for name in ("mass", "stiffness", "damping", "normal_load", "belt_speed"))
    a1, a2, a3, a4 = (cell[f"a{i}"] for i in range(1, 5))

    def motion(_, state):
        x, w = state
        speed = max(w, 0.0)
        return [v - w, (k * x + c * (v - w) - load * (a1 + a2 * speed + a3 * np.exp(-speed / a4))) / m]

    def turns(t, state):
        return motion(t, state)[1] if t > 0 else 1.0

    turns.terminal, turns.direction = True, 1.0
    turn = np.sqrt(m / k)
    start = [(load * (a1 + a3) - c * v) / k, 0.0]
    tight = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-15, "max_step": 0.05 * turn}
    # the first minimum is the start itself, where w and w' vanish and w'' > 0
    away = solve_ivp(motion, (0.0, 0.1 * turn), start, **tight)
    done = solve_ivp(motion, (0.0, 1000.0 * turn), away.y[:, -1], events=turns, **tight)
    return done.y_events[0][0][1]


@pytest.mark.parametrize(
    "along", [name if name == "stiffness" else pytest.param(name, marks=pytest.mark.slow) for name in RANGE]
)
def test_stick_slip_ends_where_scipy_sees_the_first_slip_graze(along):
    """Ten lines over decades of mass, stiffness and load, each a root by Brent to 1e-12."""
    draw = np.random.default_rng(14)
    cells = PAIR | {
        "mass": 10 ** draw.uniform(-1, 1, LINES),
        "stiffness": 10 ** draw.uniform(-1, 2, LINES),
        "normal_load": 10 ** draw.uniform(-1, 1, LINES),
    }
    cells |= {"damping": draw.uniform(0, 0.3, LINES) * cells["normal_load"]}
    cells |= {"belt_speed": draw.uniform(0.25, 0.6, LINES)}
    if along == "stiffness":  # hard springs keep up stick-slip at slightly higher speeds than soft ones
        cells |= {"damping": 0.0, "belt_speed": draw.uniform(0.75, 0.802, LINES)}
    ds = stickslip.border(cells, along, RANGE[along])
    sides = ds["regime_below"], ds["regime_above"]  # others: damped and creep, stick-slip and slip in both directions
    ends = np.logical_or(*(sides[n].isin(STICK_SLIP) & sides[1 - n].isin(DAMPED) for n in (0, 1)))
    assert ends.any("crossing").all()
    by_margin = ds["method"].values[ends.values] == METHODS.index("restick_margin")
    assert by_margin.mean() > 0.6  # on steep curves, seen from 1e-9 off, the margin jumps
    for i, crossing in np.argwhere(ends.values):
        ours = ds["border"].values[i, crossing]
        one = {name: float(values if np.ndim(values) == 0 else values[i]) for name, values in cells.items()}
        grazing = partial(lambda one, x: least_slip_speed({**one, along: x}), one)
        root = brentq(grazing, 0.99 * ours, 1.01 * ours, xtol=1e-13 * ours, rtol=1e-12)
        assert ours == pytest.approx(root, rel=1e-8)


@pytest.mark.parametrize(
    "hysteretic", [pytest.param(False, id="plain"), pytest.param(True, id="hysteretic", marks=pytest.mark.slow)]
)
def test_right_beside_a_border_no_cell_has_a_regime_that_is_on_neither_side(hysteretic):
    """Motions hover there on the unstable cycle for long; 60 lines over decades, half of them damped."""
    draw, n = np.random.default_rng(5), 30
    drop, width = 10 ** draw.uniform(-1.5, 0.3, n), 10 ** draw.uniform(-2, 0.3, n)
    cells = PAIR | {"stiffness": 10 ** draw.uniform(-1, 1, n), "a2": draw.choice([0.0, 0.1, 0.3], n)}
    cells |= {"a3": drop, "a4": width, "damping": draw.choice([0, 0.01, 0.1, 0.3], n)}
    if hysteretic:
        cells["mu_stop"] = 1 + drop * draw.uniform(-0.3, 1, n)
    ds = stickslip.border(cells, "belt_speed", (0.01, 20.0))
    line, crossing = np.nonzero(ds["border"].notnull().values)
    border, below, above, bracket = (
        ds[name].values[line, crossing, np.newaxis]
        for name in ("border", "regime_below", "regime_above", "border_width")
    )
    assert line.size > 20 and (below == STICK_SLIP).sum() > 15
    off = np.array([side * size for size in (1e-10, 1e-9, 1e-8, 1e-7, 1e-6) for side in (-1, 1)])
    places = border * (1 + off)
    at = {name: np.repeat(np.broadcast_to(v, n)[line], off.size) for name, v in cells.items()}
    regime = stickslip.evaluate(at | {"belt_speed": places.ravel()}, rtol=1e-11)["regime"].values.reshape(places.shape)
    open_ = regime == REGIMES.index("unresolved")
    assert (open_ | (regime == below) | (regime == above)).all()
    outside = np.abs(places - border) > bracket / 2
    assert (outside & ~open_).mean() > 0.7
    right = np.where(off < 0, below, above)
    assert (open_ | (regime == right) | ~outside).all()


def test_a_slip_that_comes_back_sticks_however_briefly():
    """Where passing on from slip the other way turns into stick-slip is known to the tolerance, not to its root."""
    cells = PAIR | {"stiffness": 8.6, "a2": 0.0, "a3": 0.98, "a4": 0.027, "mu_stop": 1.75}
    rough, fine = (only(stickslip.border(cells, "belt_speed", (5.0, 20.0), rtol=r)).item() for r in (1e-8, 1e-12))
    assert rough == pytest.approx(fine, rel=1e-6)


def test_coulomb_friction_with_a_damper_stops_stick_slip_at_the_critical_speed():
    draw = np.random.default_rng(3)
    m, k, load = 10 ** draw.uniform(-1, 1, LINES), 10 ** draw.uniform(-1, 3, LINES), 10 ** draw.uniform(-1, 2, LINES)
    c = draw.uniform(0.01, 0.5, LINES) * 2 * np.sqrt(k * m)
    cells = {"mass": m, "stiffness": k, "damping": c, "normal_load": load, "a1": 0.3, "a2": 0.0, "a3": 0.0, "a4": 1.0}
    ds = stickslip.border(cells | {"mu_static": 0.45}, "belt_speed", (1e-6, 1e4))
    exact = theory.critical_speed(m, k, c, load, 0.45, 0.3)
    np.testing.assert_allclose(only(ds), exact, rtol=1e-9)


def test_damped_turns_into_creep_where_the_second_excursion_sinks_into_the_settling_band():
    """Straight curve, from rest: e^(-2 pi z/sqrt(1 - z^2)) = 1e-4, z the damping ratio (c + N a2)/(2 sqrt(k m))."""
    m, k, load, slope, v = np.array([0.3, 1.0, 5.0]), np.array([10.0, 1.0, 300.0]), 3.0, 0.02, 0.5
    cells = {"mass": m, "stiffness": k, "normal_load": load, "a1": 0.3, "a2": slope, "a3": 0.0, "a4": 1.0}
    rest = load * (0.3 + slope * v) / k
    start = {"belt_speed": v, "displacement": 1.01 * rest, "velocity": 0.0}
    ds = stickslip.border(cells | start, "damping", (0.0, 100.0))
    q = np.log(1e4) / (2 * np.pi)
    np.testing.assert_allclose(only(ds), 2 * np.sqrt(k * m) * q / np.hypot(1, q) - load * slope, rtol=1e-8)
    assert (ds["regime_below"] == DAMPED).all() and (ds["regime_above"] == CREEP).all()


@pytest.mark.parametrize("damping", [0.0, 0.02])
def test_steady_sliding_loses_its_stability_within_the_stretch_that_cannot_be_decided(damping):
    """There growth and decay are too slow to tell; the bracket is left as wide as that and not guessed."""
    exact = float(theory.loss_of_stability(a2=0.1, a3=0.3, a4=0.1, damping=damping, normal_load=1))
    sliding = 1 + 0.1 * exact + 0.3 * np.exp(-exact / 0.1)
    near = PAIR | {"damping": damping, "displacement": sliding, "velocity": 1e-5}
    ds = stickslip.border(near, "belt_speed", (0.2, 0.39), scan=8, max_steps=20_000)
    width = ds["border_width"].item()
    assert abs(float(only(ds)[0]) - exact) <= width / 2
    assert 1e-9 * exact < width < 5e-3 * exact
    assert (ds["regime_below"].item(), ds["regime_above"].item()) == (STICK_SLIP, DAMPED)


# --- what is found, and what is said ----------------------------------------------------------------------------------


def test_both_ends_of_stick_slip_on_a_line_are_found():
    """The belt may run back: the same to the other side."""
    ds = stickslip.border(PAIR, "belt_speed", (-2.0, 2.0))
    assert ds.sizes["crossing"] >= 2
    borders = ds["border"].values[0]
    assert (np.diff(borders) > 0).all()
    np.testing.assert_allclose(borders[[0, -1]], [-0.79817535635, 0.79817535635], rtol=1e-9)
    assert ds["regime_below"].values[0, 0] == ds["regime_above"].values[0, -1] == DAMPED
    np.testing.assert_array_equal(ds["regime_above"][0, :-1], ds["regime_below"][0, 1:])


def test_no_border_is_no_error_and_is_said(tmp_path):
    ds = stickslip.border(PAIR, "belt_speed", (0.1, 0.2))
    assert ds.sizes == {"cell": 1, "crossing": 0}
    xr.testing.assert_equal(stickslip.open(writing.write(ds, tmp_path / "none.nc")).load(), ds)


def test_a_dataset_of_borders_says_what_it_is():
    ds = stickslip.border(PAIR | {"belt_speed": 0.1}, "stiffness", (0.1, 10.0), tolerance=1e-6, scan=5)
    assert ds["border"].attrs["units"] == ds["border_width"].attrs["units"] == "N m-1"
    assert ds["regime_below"].dtype == np.int8
    assert ds["regime_below"].attrs["flag_meanings"] == " ".join(REGIMES)
    assert ds["method"].dtype == np.int8 and ds["method"].attrs["flag_meanings"] == " ".join(METHODS)
    assert [ds.attrs[f"border_{name}"] for name in ("tolerance", "rtol", "scan")] == [1e-6, 1e-8, 5]
    assert {"source", "history", "configuration"} <= set(ds.attrs)


# --- the search alone, on labels we choose ----------------------------------------------------------------------------


def searched(label, low=0.0, high=1.0, points=5, tolerance=1e-9, guide=None, rounds=None):
    """Brackets of one line whose labels are a function of the place; -1 is undecided.

    guide : of the place as well. rounds : a list to which the places of each round are added.
    """

    def labels_at(_, place):
        labels = np.array([label(x) for x in place], np.int8)
        if rounds is not None:
            rounds.append(place)
        return Looked(labels, labels >= 0, None if guide is None else np.array([guide(x) for x in place]))

    return search_lines(1, Scan.over(low, high, points), tolerance, labels_at)


ROOT = np.sqrt(0.5)


@pytest.mark.parametrize(
    ("guide", "most"),
    [
        (lambda x: x - ROOT, 8),
        (lambda x: np.tanh(20 * (x - ROOT)), 10),
        (lambda x: x - ROOT if x > ROOT else x - ROOT - (ROOT - x) ** 1.5, 9),
        (lambda x: ROOT - x, 8),  # falls
        (lambda x: max(x - ROOT, 0.0), 30),  # zero beyond: no worse than halving
        (lambda x: np.copysign(abs(x - ROOT) ** 0.1, x - ROOT), 30),
    ],
)
def test_a_guide_leads_to_the_border_in_a_few_rounds(guide, most):
    rounds = []
    found, _ = searched(lambda x: int(x > ROOT), guide=guide, rounds=rounds)
    assert found["low"] <= ROOT <= found["high"] and found["high"] - found["low"] <= 1e-9
    assert len(rounds) - 1 <= most


@pytest.mark.parametrize(
    "guide",
    [
        lambda x: x - 0.6,  # says another place
        lambda x: -1.0 if x < ROOT else 1.0,  # jumps
        lambda x: x - ROOT if x < 0.6 else np.nan,
        lambda x: 1.0,
    ],
)
def test_a_guide_that_has_no_zero_where_labels_change_gives_no_border(guide):
    found, _ = searched(lambda x: int(x > ROOT), guide=guide)
    assert found["low"] <= ROOT <= found["high"] and found["high"] - found["low"] <= 1e-9
    assert not found["guided"].any()


def test_a_guide_passes_undecided_places_next_to_the_border_on_both_sides():
    rounds = []
    found, _ = searched(
        lambda x: -1 if abs(x - ROOT) < 3e-11 else int(x > ROOT), guide=lambda x: x - ROOT, rounds=rounds
    )
    assert found["guided"].all() and found["high"] - found["low"] <= 1e-9 and len(rounds) < 12


def test_a_third_label_inside_a_bracket_splits_it():
    found, undecided = searched(lambda x: 0 if x < 0.61 else 1 if x < 0.64 else 2)
    np.testing.assert_allclose(found["low"], [0.61, 0.64], atol=1e-9)
    assert found["below"].tolist() == [0, 1] and found["above"].tolist() == [1, 2] and undecided == [0]


def test_a_bracket_closes_in_on_undecided_places_from_both_sides():
    found, undecided = searched(lambda x: 0 if x < 0.3 else -1 if x < 0.7 else 1)
    assert (found["low"][0], found["high"][0]) == pytest.approx((0.3, 0.7), abs=2e-9)
    assert undecided == [1]


@pytest.mark.parametrize("after", [0, 2])
def test_undecided_places_between_equal_labels_or_at_the_end_are_no_border(after):
    found, undecided = searched(lambda x: 0 if x < 0.3 else -1 if x < 0.7 or after == 2 else 0)
    assert found.size == 0 and undecided == [1 if after == 0 else 3]


def test_a_label_on_less_than_the_tolerance_is_passed_over():
    found, _ = searched(lambda x: 0 if x < 0.5 - 1e-11 else 1 if x <= 0.5 else 2)
    assert found["below"].tolist() == [0] and found["above"].tolist() == [2]
    assert found["high"] - found["low"] < 3e-9


def test_a_border_at_zero_is_found_to_a_share_of_the_range():
    found, _ = searched(lambda x: int(x > 0), low=-1.0, high=3.0)
    assert abs(found["high"] - found["low"]) < 3e-12 and found["low"] <= 0 <= found["high"]


# --- bad input --------------------------------------------------------------------------------------------------------


@cases("sweep.yaml")
def test_what_a_configuration_cannot_give_is_said(text, how, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        stickslip.border(parse_config(text, "<test>"), **how)


# --- the command ------------------------------------------------------------------------------------------------------


def command(*arguments):
    return call("border", *arguments)


def test_the_command_prints_borders_and_writes_them(tmp_path):
    path, output = write_config(tmp_path, num=3), tmp_path / "borders.nc"
    done = command(path, "--along", "belt_speed", "--between", "50 mm/s", "1 m/s", "-o", output)
    assert done.exit_code == 0, done.output
    ds = stickslip.open(output)
    row = re.search(r"^10 N/m +(\S+) m/s +stick_slip +damped +restick_margin +\S+ m/s$", done.output, re.MULTILINE)
    assert float(row[1]) == pytest.approx(float(ds["border"][-1, 0]), rel=1e-11)
    assert re.search(r"^borders  \d on 3 of 3 lines$", done.output, re.MULTILINE)


def test_a_line_without_border_says_its_regime_throughout(tmp_path):
    """Of three drops the last is none: there sliding is steady at any speed."""
    (tmp_path / "b.yaml").write_text(
        "system: {mass: 0.1, stiffness: 5000, normal_load: 10, damping: 1, belt_speed: 1}\n"
        "friction: {a1: 0.1, a2: 0.3, a4: 0.02}\naxes: {a3: [0.1, 0.02, 0.0]}\n"
        "border: {along: belt_speed, between: [1 mm/s, 500 mm/s], scan: 16}\n"
    )
    done = call("run", tmp_path / "b.yaml", "-o", tmp_path / "b.csv")
    assert done.exit_code == 0, done.output
    assert re.search(r"^0 +none: damped throughout$", done.stdout, re.M) and "2 on 2 of 3 lines" in done.stdout
    table = pd.read_csv(tmp_path / "b.csv")
    assert list(table["regime_throughout"].fillna("")) == ["", "", "damped"]
    assert list(table["regime_below"].fillna("")) == ["stick_slip", "stick_slip", ""]
    ds = stickslip.open(tmp_path / "b.nc")
    assert (ds["regime_throughout"] != 0).values.tolist() == [False, False, True]


def test_borders_do_not_depend_on_where_the_scan_looked():
    cells = PAIR | {"stiffness": np.geomspace(0.1, 10, 5)}
    one, other = (stickslip.border(cells, "belt_speed", *how) for how in ((BELT,), ((0.0123, 7.0),)))
    coarse = stickslip.border(cells, "belt_speed", BELT, scan=2)
    for ds in (other, coarse):
        np.testing.assert_allclose(only(ds), only(one), rtol=1e-9)
