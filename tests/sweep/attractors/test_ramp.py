"""Slow ramps against borders and closed forms; what they know of the branches, and what is drawn of it."""

import numpy as np
import pytest
from matplotlib.patches import Rectangle

import stickslip
from helpers.nightly import few
from stickslip import plots, theory
from stickslip.errors import PlotError
from stickslip.vocabulary.quantities import REGIMES

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


# --- bifurcation diagrams ---------------------------------------------------------------------------------------------


BOX = {"displacement": (0.0, 2.0), "velocity": (-1.0, 1.0)}


@pytest.fixture(scope="module")
def ramp():
    return stickslip.ramp(ARTICLE, "belt_speed", (0.02, 1.1), points=37)


def test_the_unstable_cycle_of_a_ramp_is_that_of_attractors(ramp):
    known = stickslip.attractors(ARTICLE | {"belt_speed": ramp["belt_speed"].values}, BOX, samples=64)
    for name in ("unstable_amplitude", "unstable_velocity_amplitude", "unstable_period", "damping_ratio"):
        assert ramp[name].dims == ("cell", "belt_speed")
        np.testing.assert_allclose(ramp[name][0], known[name], rtol=1e-9, err_msg=name)
    assert ramp["unstable_amplitude"].notnull().any()


def test_between_the_branches_there_is_a_cycle_and_only_there(ramp):
    """Where both ways differ there is an unstable cycle, smaller than the stable one and larger than sliding's 0."""
    up, down = (ramp.sel(direction=name).isel(cell=0) for name in ("up", "down"))
    bistable = up["regime"].values != down["regime"].values
    unstable = ramp["unstable_velocity_amplitude"].values[0]
    np.testing.assert_array_equal(np.isfinite(unstable), bistable)
    stable = up["velocity_amplitude"].values[bistable]
    assert ((0 < unstable[bistable]) & (unstable[bistable] < stable)).all()


def test_amplitudes_are_those_of_the_attractor_and_not_of_the_transient(ramp):
    cells = stickslip.evaluate(ARTICLE | {"belt_speed": [0.1, 0.9, 2.0], "damping": [0.0, 0.0, 10.0]})
    settles = np.isin(cells["regime"], [REGIMES.index("damped"), REGIMES.index("creep")])
    np.testing.assert_array_equal(settles, [False, True, True])
    assert cells["spring_force_max"][1] > 1.2 * cells["cycle_force_max"][1], "the transient overshoots"
    for name in ("displacement_amplitude", "velocity_amplitude"):
        np.testing.assert_array_equal(cells[name][1:], 0.0)
        assert cells[name][0] > 0 and "attractor" in cells[name].attrs["long_name"]
    rest = cells["settled_displacement"][1:] * ARTICLE["stiffness"]
    for name in ("cycle_force_max", "cycle_force_min"):
        np.testing.assert_allclose(cells[name][1:], rest, rtol=1e-12)
    for direction in ("up", "down"):
        one = ramp.sel(direction=direction)
        np.testing.assert_array_equal(one["velocity_amplitude"] == 0, one["regime"] != REGIMES.index("stick_slip"))


def test_a_diagram_marks_where_theory_has_the_hopf_bifurcation_and_where_vibration_ends(ramp):
    figure = plots.plot_branches(ramp)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"stick-slip", "steady sliding", "steady sliding, unstable", "unstable cycle", "bistable"} <= set(labels)
    marks = {line.get_markerfacecolor(): line for line in figure.axes[0].lines if line.get_marker() == "o"}
    hopf = ARTICLE["a4"] * np.log(ARTICLE["a3"] / (ARTICLE["a4"] * ARTICLE["a2"]))  # where the damping ratio is zero
    assert marks["white"].get_xdata()[0] == pytest.approx(hopf, abs=2e-3)
    ends = stickslip.border(ARTICLE, "belt_speed", (0.02, 1.1))["border"].values[0]
    (fold,) = marks["#000000"].get_xdata()
    assert fold == pytest.approx(ends[-1], rel=1e-6), "and no point of the ramp"
    (band,) = (patch for patch in figure.axes[0].patches if isinstance(patch, Rectangle))
    assert band.get_x() == pytest.approx(hopf, abs=2e-3) and band.get_x() + band.get_width() == fold
    dashed = [line for line in figure.axes[0].lines if line.get_linestyle() == "--"]
    (unstable,) = (line for line in dashed if line.get_color() == "#d55e00")
    assert unstable.get_xdata()[0] == pytest.approx(hopf, abs=2e-3) and unstable.get_ydata()[0] == 0.0
    assert (np.diff(unstable.get_ydata()) > 0).all()


def test_lines_are_selected_and_what_is_no_ramp_is_refused(ramp):
    two = stickslip.ramp(ARTICLE | {"stiffness": [1.0, 10.0]}, "belt_speed", (0.1, 1.1), points=5)
    assert plots.plot_branches(two, select={"cell": 1}).axes
    with pytest.raises(PlotError, match="more than one dimension: cell, belt_speed"):
        plots.plot_branches(two)
    with pytest.raises(PlotError, match="no branches of period; there are those of velocity_amplitude and"):
        plots.plot_branches(ramp, "period")
    with pytest.raises(PlotError, match=r"not a ramp(.|\n)*stickslip\.ramp"):
        plots.plot_branches(stickslip.evaluate(ARTICLE | {"belt_speed": 0.1}))
