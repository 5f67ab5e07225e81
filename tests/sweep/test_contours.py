"""Contours of regimes, against closed forms, borders along single lines and SciPy."""

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import stickslip
from helpers.configs import write_config
from stickslip import theory
from stickslip.config.reader import parse_config
from stickslip.dataset.display import polylines
from stickslip.engine import stop_flag
from stickslip.files import writing
from stickslip.studies import plane as plane_search
from stickslip.studies.contours import Contours, ContourStudy
from stickslip.studies.lines import fine_enough, opened
from stickslip.studies.plane import Crossing, PlaneSearch, Segment, chained, joined, meeting_points
from stickslip.vocabulary.quantities import REGIMES

PAIR = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
COULOMB = {"mass": 2.0, "stiffness": 50.0, "normal_load": 3.0, "a1": 0.3, "a2": 0.0, "a3": 0.0, "a4": 1.0,
           "mu_static": 0.45}  # fmt: skip
STICK_SLIP, DAMPED, UNRESOLVED = (REGIMES.index(name) for name in ("stick_slip", "damped", "unresolved"))


def between(ds, left, right):
    """Lines with these regimes to the left and right."""
    return [one for one in polylines(ds) if (one.left, one.right) == (left, right)]


def test_coulomb_friction_with_a_damper_stops_stick_slip_along_the_critical_speed():
    ds = stickslip.contours(
        COULOMB, ("damping", "belt_speed"), {"damping": (0.5, 15.0), "belt_speed": (1e-3, 10.0)}, points=128
    )
    (line,) = between(ds, STICK_SLIP, DAMPED)
    exact = theory.critical_speed(2.0, 50.0, line.y, 3.0, 0.45, 0.3)
    np.testing.assert_allclose(line.x, exact, rtol=1e-8)
    assert not line.closed and line.y[-1] == 0.5 or line.y[0] == 0.5
    assert line.x.min() == 1e-3  # it ends where the plane does


def test_nodes_are_those_of_border_along_either_parameter():
    ranges = {"stiffness": (0.1, 1000.0), "belt_speed": (0.3, 1.0)}
    ds = stickslip.contours(PAIR, ("stiffness", "belt_speed"), ranges, points=50, scan=16)
    (line,) = between(ds, STICK_SLIP, DAMPED)
    searched = ds["node_along"].values
    names = ds["node_along"].attrs["flag_meanings"].split()
    assert names == ["belt_speed", "stiffness", "junction"] and set(searched) == {0, 1}
    for code, along, other, nodes in ((0, "belt_speed", "stiffness", line.x), (1, "stiffness", "belt_speed", line.y)):
        there = searched == code
        held = ds[other].values[there]
        lines = stickslip.border(PAIR | {other: held}, along, ranges[along])
        nearest = np.nanmin(np.abs(lines["border"].values / nodes[there][:, np.newaxis] - 1), axis=1)
        assert nearest.max() < 1e-8


@pytest.mark.slow
def test_the_basin_of_steady_sliding_ends_at_the_unstable_cycle_that_scipy_reaches_backwards_in_time():
    """The border between starting states is a loop; in reversed time the unstable cycle attracts."""
    speed = 0.5
    ds = stickslip.contours(
        PAIR | {"belt_speed": speed}, ("displacement", "velocity"),
        {"displacement": (0.4, 1.8), "velocity": (-0.6, 0.45)}, points=64, scan=16,
    )  # fmt: skip
    (loop,) = polylines(ds)
    assert loop.closed and (loop.x[0], loop.y[0]) == (loop.x[-1], loop.y[-1])

    def backwards(_, state):
        x, v = state
        return [-v, x - 1.0 - 0.1 * (speed - v) - 0.3 * np.exp(-(speed - v) / 0.1)]

    tight = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    there = solve_ivp(backwards, (0.0, 1500.0), [1.488, 0.0], **tight).y[:, -1]
    cycle = solve_ivp(backwards, (0.0, 7.0), there, dense_output=True, **tight)
    x, v = cycle.sol(np.linspace(0.0, 7.0, 20001))
    nearest = np.argmin((loop.y[:, np.newaxis] - x) ** 2 + (loop.x[:, np.newaxis] - v) ** 2, axis=1)
    course = np.stack(backwards(0.0, [x[nearest], v[nearest]]))
    away = (loop.y - x[nearest]) * course[1] - (loop.x - v[nearest]) * course[0]
    np.testing.assert_allclose(away / np.hypot(*course), 0.0, atol=1e-8)
    assert (loop.left, loop.right) == (STICK_SLIP, DAMPED)  # stick-slip is on the left, so this loop runs clockwise
    assert np.sum(np.diff(loop.x) * (loop.y[1:] + loop.y[:-1])) > 0


@pytest.mark.slow
def test_the_upper_edge_of_stick_slip_follows_the_near_harmonic_form_where_friction_is_weak():
    """kappa = 0.03: the closed form is exact to 0.33 % kappa^2 there."""
    stiff = PAIR | {"stiffness": 1e4}
    ds = stickslip.contours(
        stiff, ("damping", "belt_speed"), {"damping": (0.0, 0.4), "belt_speed": (0.3, 1.0)}, points=16, scan=8
    )
    (line,) = between(ds, STICK_SLIP, DAMPED)
    np.testing.assert_allclose(line.x, theory.stick_slip_limit(0.1, 0.3, 0.1, line.y, 1.0), rtol=1e-5)


@pytest.mark.parametrize("points", [8, pytest.param(100, marks=pytest.mark.slow)])
def test_the_loss_of_stability_lies_within_the_stretch_that_cannot_be_decided(points):
    """From close to steady sliding. Narrower than a side of the grid, the stretch is the width of nodes between two
    regimes; wider, it is a region with a border on either side."""
    speed = 0.3
    exact = 3.0 * np.exp(-speed / 0.1) - 0.1  # the damping at which c + N mu'(v) = 0
    near = PAIR | {"belt_speed": speed, "displacement": 1 + 0.1 * speed + 0.3 * np.exp(-3.0), "velocity": 1e-5}
    ds = stickslip.contours(
        near, ("mass", "damping"), {"mass": (0.5, 2.0), "damping": (0.04, 0.06)}, points, scan=points,
        tolerance=1e-6, max_steps=20_000,
    )  # fmt: skip
    assert ds.sizes["line"] > 0
    side = 0.02 / (points - 1)
    width = np.where(ds["node_along"].values == 2, 2, ds["node_width"].values) * side  # where the region ends
    for line, stop in zip(polylines(ds), np.cumsum(ds["node_count"].values), strict=True):
        wide = width[stop - len(line.x) : stop]
        if (line.left, line.right) == (STICK_SLIP, DAMPED):
            assert (np.abs(line.x - exact) <= wide / 2).all() and (wide > 1e-5 * exact).all()
        else:
            assert line.right == UNRESOLVED
            beyond = (line.x - exact) * (1 if line.left == STICK_SLIP else -1)
            assert (beyond <= np.where(wide > side, side, 1e-9 * exact)).all()


# --- datasets ---------------------------------------------------------------------------------------------------------


def test_the_other_axes_of_a_configuration_are_panels(tmp_path):
    path = write_config(tmp_path, num=5)
    loaded = stickslip.load_config(path)
    ds = stickslip.contours(loaded, ("damping", "belt_speed"), {"damping": (0.0, 1.0)}, points=12, tolerance=1e-4)
    assert ds["stiffness"].dims == ("line",) and set(ds["stiffness"].values) <= set(
        loaded.axes[0].points() if loaded.axes[0].name == "stiffness" else loaded.axes[1].points()
    )
    assert (np.diff(ds["stiffness"].values) >= 0).all()
    alone = stickslip.contours(loaded, points=12, tolerance=1e-4)
    assert alone["geometry"].attrs["node_coordinates"] == f"{loaded.axes[-1].name} {loaded.axes[-2].name}"
    asked = parse_config(alone.attrs["configuration"])
    xr.testing.assert_equal(stickslip.run(asked), alone)  # a section asks for the same
    assert asked.study.points == 12


def test_a_plane_without_borders_has_no_lines_and_says_so(tmp_path):
    ds = stickslip.contours(PAIR, ("stiffness", "belt_speed"), {"stiffness": (1, 2), "belt_speed": (0.1, 0.2)}, 8)
    assert ds.sizes["line"] == ds.sizes["node"] == 0
    xr.testing.assert_equal(stickslip.open(writing.write(ds, tmp_path / "none.nc")).load(), ds)


# --- the search and the lines, on labels we choose --------------------------------------------------------------------


def test_the_labels_of_a_circle_and_an_island_are_inferred_from_points_beside_their_borders(monkeypatch):
    """An island a little wider than a step of the scan is met by it; the surroundings alone are looked at."""
    options, size = stickslip.Options(), 300
    cells, (y, x) = opened(PAIR, {"stiffness": (1.0, 2.0), "belt_speed": (1.0, 2.0)}, size, options)
    search = PlaneSearch(cells, y, x, 0, 11, 1e-9, options, stop_flag())

    def regimes(r, c):
        circle, island = ((c / size - 0.5) ** 2 + (r / size - 0.5) ** 2 < 0.09, np.hypot(c - 38, r - 37) < 23)
        return np.where(circle | island, 1, 2).astype(np.int8)

    monkeypatch.setattr(search, "labels_of_points", regimes)
    np.testing.assert_array_equal(search.labels_on_grid(), regimes(*np.indices((size, size))))
    assert search.boxes.known.sum() < 0.1 * size**2


@pytest.mark.parametrize(
    ("around", "centre", "expected"),
    [
        ("AB", None, ["0-1"]), ("ABAB", "A", ["0-1", "2-3"]), ("ABAB", "B", ["1-2", "3-0"]), ("ABC", None, ["J"] * 3),
        ("ABAC", "A", ["0-1", "2-3"]), ("ABCB", "B", ["1-2", "3-0"]), ("ABCD", "A", ["J"] * 4),
    ],
)  # fmt: skip
def test_labels_around_a_cell_say_which_crossings_are_joined(around, centre, expected):
    """Crossing i lies between the labels i and i + 1."""
    labels = [ord(one) for one in around]
    ring = [Crossing(i, labels[i], labels[(i + 1) % len(labels)]) for i in range(len(labels))]
    found = joined(ring, None if centre is None else ord(centre), junction=-1)
    pairs = {frozenset((one.start, one.end)) for one in found}
    wanted = {frozenset(map(int, text.split("-"))) for text in expected if text != "J"}
    if "J" in expected:
        wanted = {frozenset((i, -1)) for i in range(len(labels))}
    assert pairs == wanted
    for one in found:  # from where the crossing is met counter-clockwise, its label before lies to the left
        assert one.left == ring[one.start].before and one.right == ring[one.start].after


def test_lines_run_from_end_to_end_with_the_smaller_label_on_the_left():
    open_line = [Segment(1, 0, 2, 1), Segment(1, 2, 1, 2), Segment(3, 2, 2, 1)]
    loop = [Segment(10, 11, 1, 3), Segment(11, 12, 1, 3), Segment(10, 12, 3, 1)]
    line, ring = chained(open_line + loop)
    assert line.nodes == (0, 1, 2, 3) and (line.left, line.right) == (1, 2)
    assert ring.nodes[0] == ring.nodes[-1] and set(ring.nodes) == {10, 11, 12}


def test_the_point_where_three_labels_meet_is_closed_in_upon():
    triple = np.array([0.371, 0.618])

    def labels(_, x, y):
        angle = np.arctan2(y - triple[1], x - triple[0])
        return np.select([angle < -1.0, angle < 0.7], [1, 2], 3).astype(np.int8)

    place, width = meeting_points(1, labels, 20)
    assert width[0] == 2.0**-20
    np.testing.assert_allclose(place[0], triple, atol=2.0**-19)


def test_three_regimes_meet_in_a_junction(monkeypatch):
    """A plane whose regimes we choose: sectors around a point."""
    ranges, options = {"stiffness": (1.0, 2.0), "belt_speed": (0.1, 1.1)}, stickslip.Options()
    cells, (y, x) = opened(PAIR, ranges, 21, options)

    def sectors(one, *_):
        angle = np.arctan2(one["stiffness"] - 1.53, one["belt_speed"] - 0.62)
        found = np.select([angle < -1.0, angle < 0.7], [1, 2], 3).astype(np.int8)
        return {"regime": found, "restick_margin": np.full(found.size, np.nan)}

    monkeypatch.setattr(plane_search, "solve", sectors)
    study = ContourStudy(cells, y, x, *fine_enough(Contours(scan=8), options))
    ds = study.dataset([study.compute(range(1), stop_flag())], {})
    assert sorted((one.left, one.right) for one in polylines(ds)) == [(1, 2), (1, 3), (2, 3)]
    junction = ds["node_along"].values == 2
    assert junction.sum() == 3  # the same node, once per line
    np.testing.assert_allclose(ds["belt_speed"].values[junction], 0.62, atol=2e-5)
    np.testing.assert_allclose(ds["stiffness"].values[junction], 1.53, atol=2e-5)
