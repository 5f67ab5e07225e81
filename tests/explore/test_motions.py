"""What a click computes: motions that obey the equation of motion, the unstable cycle, and what is said of them."""

import shlex

import numpy as np
import pytest

import stickslip
from helpers.commands import call
from helpers.data import rows
from helpers.nightly import few
from helpers.unstable_cycle import Cycle
from stickslip.engine import Options, stop_flag
from stickslip.vocabulary.models import CURVE_LAWS
from stickslip.vocabulary.quantities import MODES
from stickslip_explore import maps
from stickslip_explore.html import cell_html, numbers_html, place_words, simulate_command
from stickslip_explore.motions import motions_of
from stickslip_explore.static import essential
from stickslip_explore.view import View, cell_of_view, config_of, open_source

PLAIN = {"mass": 1.0, "normal_load": 1.0, "stiffness": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
STICK_SLIP, DAMPED, BISTABLE = (PLAIN | {"belt_speed": speed} for speed in (0.1, 1.1, 0.45))
# Cells that are easily drawn wrong.
ILL = {name: PLAIN | more for name, more in rows("explore.yaml")["test_motions"]["ILL"].items()}


def of(cell, law="stribeck"):
    return motions_of(cell, Options(law))


def obeys(motion, cell, curve, tolerance=1e-6):
    """Newton's law in every sample that slips, the belt's speed in every one that sticks."""
    one, found = {"damping": 0.0} | cell, motion.samples
    sticks = found["mode"] == MODES.index("stick")
    assert np.allclose(found["velocity"][sticks], one["belt_speed"], rtol=1e-9, atol=1e-12)
    friction = one["normal_load"] * found["friction_coefficient"]
    force = friction - one["damping"] * found["velocity"] - one["stiffness"] * found["displacement"]
    held = sticks | (found["mode"] == MODES.index("hold"))
    scale = one["normal_load"]
    assert np.allclose(one["mass"] * found["acceleration"][~held], force[~held], rtol=0, atol=tolerance * scale)
    rises = (found["mode"] == MODES.index("rise")) | (found["mode"] == MODES.index("fast"))
    w = np.abs(found["relative_speed"][rises])
    assert np.allclose(np.abs(found["friction_coefficient"][rises]), np.interp(w, *curve), atol=2e-3)


@pytest.mark.parametrize("law", few(CURVE_LAWS, 1))
def test_motions_slip_on_the_curve_that_is_drawn_behind_them_under_every_law(law):
    cell = STICK_SLIP | ({"delta": 2.0} if law == "stribeck_delta" else {})
    found = of(cell, law)
    for motion in found.motions.values():
        assert not motion.why and motion.time.size > 100
        obeys(motion, found.cell, found.curve)
    known = stickslip.evaluate(cell, law=law)
    assert found.stick.results["regime"] == int(known["regime"][0])
    w, mu = found.curve
    assert w[0] == 0.0 and (np.diff(w) > 0).all() and w[-1] >= np.abs(found.stick.samples["relative_speed"]).max()


@pytest.mark.parametrize("name", ILL)
def test_cells_that_are_easily_drawn_wrong(name):
    cell = ILL[name]
    found = of(cell)
    assert (found.sliding is None) == (cell["belt_speed"] == 0)
    for motion in found.motions.values():
        assert not motion.why, motion.why
        assert 2 <= motion.time.size <= 12_000 and (np.diff(motion.time) > 0).all()
        assert all(np.isfinite(values).all() for values in motion.samples.values())
        if name != "hysteretic":
            obeys(motion, found.cell, found.curve, 1e-5)
    known = stickslip.evaluate(cell)
    assert found.stick.results["regime"] == int(known["regime"][0])
    if name == "nearly all stick":  # a slip is fine even here
        assert found.stick.results["stick_fraction"] > 0.99
        assert (found.stick.samples["mode"] != MODES.index("stick")).sum() > 50
        slowest = 1e-4 - found.stick.results["slip_speed_max"]
        assert found.stick.samples["velocity"].min() == pytest.approx(slowest, rel=0.02)


def test_stick_slip_is_shown_from_its_break_away_over_whole_cycles():
    found = of(STICK_SLIP).stick
    assert found.regime == "stick_slip" and found.time[0] < 0.0
    period = found.results["period"]
    assert 3.0 < found.time[-1] / period < 4.0
    x = np.interp([0.0, period, 2 * period], found.time, found.samples["displacement"])
    assert np.allclose(x, 1.3, atol=1e-3)  # breaks away at mu_start N/k
    assert np.allclose(found.samples["spring_force"].max(), found.results["cycle_force_max"], rtol=1e-4)


def test_the_long_first_stick_phase_is_left_out_and_changes_nothing():
    cell = PLAIN | {"belt_speed": 1e-3, "ageing_rate": 0.05, "contact_time": 3.0}
    found = of(cell).stick
    away = found.results["breakaway_time"]
    assert away > 1000.0 and found.time[0] > -0.2 * np.ptp(found.time)
    whole = stickslip.simulate(duration=away + 2.0, samples=40_001, **cell)
    t = np.linspace(0.1, 1.9, 50)
    ours = np.interp(t, found.time, found.samples["displacement"])
    theirs = np.interp(t, whole["time"].values - away, whole["displacement"].values)
    assert np.allclose(ours, theirs, atol=2e-3)


def test_slow_growth_from_near_sliding_ends_in_the_same_cycle():
    found = of(ILL["slow growth"])
    assert found.sliding.regime == "stick_slip" and found.sliding.late
    assert found.sliding.results["period"] == pytest.approx(found.stick.results["period"], rel=1e-6)
    last = found.sliding.samples["displacement"][found.sliding.time > 0.0]
    assert last.max() == pytest.approx(found.stick.samples["displacement"].max(), rel=1e-3)


def test_both_motions_of_a_bistable_cell_differ_and_the_unstable_cycle_lies_between():
    found = of(BISTABLE)
    assert (found.stick.regime, found.sliding.regime) == ("stick_slip", "damped")
    loop = found.cycle
    assert loop is not None and loop.displacement[0] == pytest.approx(loop.displacement[-1], abs=1e-8)
    known = Cycle(0.45, (1.0, 0.1, 0.3, 0.1), 0.0, loop.displacement.max() - found.steady)
    (x, v), steady = known.states(40_000), found.steady
    angle, radius = np.arctan2(v, x - steady), np.hypot(x - steady, v)
    order = np.argsort(angle)
    ours = np.arctan2(loop.velocity, loop.displacement - steady)
    there = np.interp(ours, angle[order], radius[order], period=2 * np.pi)
    assert np.allclose(np.hypot(loop.displacement - steady, loop.velocity), there, rtol=1e-7)
    mirrored = of(BISTABLE | {"belt_speed": -0.45}).cycle
    assert np.allclose(loop.displacement, -mirrored.displacement, atol=1e-9)
    assert np.allclose(loop.velocity, -mirrored.velocity, atol=1e-9)
    for share, regime in ((0.99, 2), (1.01, 1)):  # started just inside it settles, just outside it sticks and slips
        k = len(loop.displacement) // 3
        x0 = found.steady + share * (loop.displacement[k] - found.steady)
        ended = stickslip.evaluate(BISTABLE | {"displacement": x0, "velocity": share * loop.velocity[k]})
        assert int(ended["regime"][0]) == regime


@pytest.mark.parametrize("cell", [STICK_SLIP, DAMPED, ILL["hysteretic"], ILL["ageing"]])
def test_no_unstable_cycle_is_drawn_where_none_is_known(cell):
    assert of(cell).cycle is None


# --- words --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def quickstart():
    source = open_source("configs/quickstart.yaml")
    view = View("stiffness", "belt_speed", {"mass": 0.2}, {})
    shown = maps.picture(maps.computed(config_of(source, view, (7, 9)), stop_flag()), view)
    at = {"stiffness": shown.y.at(4), "belt_speed": shown.x.at(2)}
    motions = motions_of(cell_of_view(source, view, at), source.options)
    return source, view, shown, at, motions


def test_the_command_simulates_the_cell_that_is_seen(quickstart, tmp_path, monkeypatch):
    source, view, _, at, motions = quickstart
    words = shlex.split(simulate_command(source, view, at, motions))
    assert words[:3] == ["stickslip", "simulate", "configs/quickstart.yaml"] and "mass=0.2 kg" in words
    words[words.index("cell.png")] = str(tmp_path / "cell.png")
    trace = tmp_path / "trace.nc"
    done = call(*words[1:], "-o", trace)
    assert done.exit_code == 0, done.output
    ds = stickslip.open(trace)
    assert float(ds["mass"]) == 0.2 and float(ds["stiffness"]) == pytest.approx(at["stiffness"], rel=1e-5)
    shown = ds["time"].values - motions.stick.results["breakaway_time"]
    assert shown[-1] == pytest.approx(motions.stick.time[-1], rel=1e-2)
    assert np.allclose(
        np.interp(motions.stick.time[1:-1], shown, ds["displacement"].values),
        motions.stick.samples["displacement"][1:-1], atol=0.02 * np.ptp(ds["displacement"].values),
    )  # fmt: skip


def test_the_numbers_are_those_of_evaluate(quickstart):
    _, _, shown, at, motions = quickstart
    html = numbers_html({"stick": motions.stick, "sliding": motions.sliding})
    known = stickslip.evaluate({name: value for name, value in motions.cell.items()})
    assert "stick-slip" in html and f"{float(known['frequency'][0]):.4g} Hz" in html
    assert f"{float(known['stick_fraction'][0]):.4g}" in html
    assert place_words(shown, at) == f"stiffness {at['stiffness']:.4g} N/m, belt speed {at['belt_speed']:.4g} m/s"
    assert "mass 200 g" in cell_html(motions, "here")
    assert "<script" not in cell_html(motions, "<script>alert(1)</script>")


def test_thinned_lines_look_the_same():
    t = np.sort(np.random.default_rng(1).uniform(0.0, 10.0, 5000))
    lines = np.stack([t, np.sin(7 * t), np.exp(-t) * np.cos(40 * t), np.sign(np.sin(t))])
    kept = essential(lines, 1e-2, 5000)
    assert kept[0] == 0 and kept[-1] == 4999 and kept.size < 2500
    for row in lines[1:]:
        assert np.abs(np.interp(t, t[kept], row[kept]) - row).max() <= 1e-2 * np.ptp(row) * (1 + 1e-9)
    assert essential(lines, 1e-2, 60).size <= 61


def test_a_motion_that_ends_early_is_drawn_as_far_as_it_is_known_and_says_why():
    found = of(PLAIN | {"belt_speed": 5.0, "a2": -0.3})  # friction would be negative at 4.4 m/s
    assert (found.stick.regime, found.stick.status) == ("failed", "negative_friction")
    html = numbers_html({"stick": found.stick})
    assert "negative friction" in html and "known to" in html and "failed" in html
    few = motions_of(STICK_SLIP, Options(max_steps=5))
    assert few.stick.regime == "unresolved" and "max_steps" in few.stick.why
    assert few.stick.time.size > 10 and np.isfinite(few.stick.samples["displacement"]).all()
    assert few.stick.time[-1] < 20.0


@pytest.mark.slow
def test_stick_slip_that_never_repeats_is_drawn():
    """Soft bristles without damping of their own ring from one slip to the next."""
    cell = {"mass": 0.1, "stiffness": 500.0, "damping": 1.0, "normal_load": 10.0, "belt_speed": 0.043, "a1": 0.25,
            "a2": 0.0, "a3": 0.05, "a4": 0.02, "contact_stiffness": 2e4, "contact_damping": 0.0}  # fmt: skip
    assert motions_of(cell, Options(law="lugre_stribeck")).stick.time.size > 100
