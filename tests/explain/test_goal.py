"""Goals: the region that is quiet over whole ranges, against closed forms, quadrature and brute force."""

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import brentq, minimize_scalar

import stickslip
from helpers.commands import call
from helpers.configs import MEASURED_FORM
from helpers.data import cases
from stickslip import theory
from stickslip.config.reader import parse_config
from stickslip.dataset.display import polylines
from stickslip.errors import ConfigError
from stickslip.plots import kind_of
from stickslip.vocabulary.quantities import REGIMES, VERDICTS, VIBRATING
from stickslip_explain.goal_study import GoalStudy

COULOMB = {"mass": 2.0, "stiffness": 50.0, "normal_load": 3.0, "a1": 0.3, "a2": 0.0, "a3": 0.0, "a4": 1.0}
SLOWEST, FASTEST = 0.02, 0.2
OVER = {"belt_speed": (SLOWEST, FASTEST)}
QUICK = {"points": 17, "scan": 9, "progress": False}
PLANE = ("damping", "mu_static"), {"damping": (0.5, 10.0), "mu_static": (0.305, 0.6)}
VIBRATES, QUIET, UNDECIDED, IMPOSSIBLE = (VERDICTS.index(n) for n in ("vibrates", "quiet", "undecided", "impossible"))


def critical(damping, mu_static, load=3.0, stiffness=50.0):
    """The belt speed above which the Coulomb cell is quiet, in closed form."""
    return theory.critical_speed(2.0, stiffness, damping, load, mu_static, 0.3)


def coulomb(over=OVER, damping=1.0, mu_static=0.45, **more):
    return stickslip.goal(COULOMB | {"damping": damping, "mu_static": mu_static}, over, *PLANE, **QUICK | more)


def scattered(quantities, draws=32, **section):
    """A configuration of the Coulomb cell, of which some quantities scatter."""
    cell = COULOMB | {"damping": 1.0, "mu_static": 0.45, "belt_speed": 0.05}
    system, friction = {}, {}
    for name in (name for name in cell if name not in quantities):
        (friction if name in ("a1", "a2", "a3", "a4", "mu_static") else system)[name] = cell[name]
    return {"system": system, "friction": friction, "uncertain": {"draws": draws, "quantities": quantities}, **section}


def test_coulomb_friction_is_quiet_over_a_range_where_its_slowest_speed_is_critical():
    ds = coulomb(points=65)
    (line,) = polylines(ds)
    assert (line.left, line.right) == (VIBRATES, QUIET)
    np.testing.assert_allclose(critical(line.y, line.x), SLOWEST, rtol=1e-4)  # the tolerance is 1e-5 of a parameter
    at = np.meshgrid(ds["damping"], ds["mu_static"], indexing="ij")
    np.testing.assert_array_equal(ds["quiet_probability"][0], critical(*at) < SLOWEST)


@pytest.mark.slow
def test_of_several_ranges_the_worst_combination_counts():
    """The largest load; of the stiffness one inside the range, depending on the damper."""
    cell = COULOMB | {"damping": 1.0, "mu_static": 0.45, "belt_speed": SLOWEST}
    over = {"normal_load": (1.0, 6.0), "stiffness": (0.5, 80.0)}
    (line,) = polylines(stickslip.goal(cell, over, *PLANE, **QUICK))
    stiffness = np.geomspace(0.5, 80.0, 2000)
    speeds = critical(line.y, line.x, 6.0, stiffness[:, np.newaxis])
    worst = stiffness[np.argmax(speeds, axis=0)]
    assert ((worst > 0.6) & (worst < 70.0)).any()
    # By ratios the range is looked at in eight parts, and then to an eighth of them.
    np.testing.assert_allclose(speeds.max(axis=0), SLOWEST, rtol=(np.log(160.0) / 8 / 8) ** 2 / 2)


def test_the_nearest_changes_are_those_of_the_closed_form():
    ds = coulomb()

    def border(damping):
        return brentq(lambda mu: critical(damping, mu) - SLOWEST, 0.3001, 0.6)

    assert float(ds["alone_mu_static"][0]) == pytest.approx(border(1.0), rel=2e-5)
    assert critical(float(ds["alone_damping"][0]), 0.45) == pytest.approx(SLOWEST, rel=1e-4)

    def cost(change):
        return change**2 + np.log(border(np.exp(change)) / 0.45) ** 2

    least = minimize_scalar(cost, bounds=(-0.5, 1.5), method="bounded", options={"xatol": 1e-9}).fun
    together = [float(ds[f"together_{name}"][0]) for name in ("damping", "mu_static")]
    assert critical(*together) <= SLOWEST
    assert np.log(together[0]) ** 2 + np.log(together[1] / 0.45) ** 2 == pytest.approx(least, rel=1e-4)


def test_what_is_quiet_has_a_reserve_that_is_quiet_still():
    ds = coulomb(damping=3.0, mu_static=0.345)
    assert int(ds["verdict"][0]) == QUIET and float(ds["quiet_share"][0]) == 1.0
    damping, static = (float(ds[f"alone_{name}"][0]) for name in ("damping", "mu_static"))
    assert damping < 3.0 and static > 0.345
    for at in ((damping, 0.345), (3.0, static), (float(ds["together_damping"][0]), float(ds["together_mu_static"][0]))):
        assert SLOWEST * (1 - 1e-4) < critical(*at) <= SLOWEST


def test_an_undamped_coulomb_cell_is_quiet_nowhere():
    """Without damper there is stick-slip at every speed (`theory/contacts.py`)."""
    ranges = {"stiffness": (1.0, 1e4), "normal_load": (0.1, 100.0)}
    ds = stickslip.goal(COULOMB | {"mu_static": 0.31}, OVER, ("stiffness", "normal_load"), ranges, **QUICK)
    assert not ds["quiet_probability"].any() and ds.sizes["line"] == 0
    assert np.isnan([float(ds[f"{what}_stiffness"][0]) for what in ("alone", "together")]).all()
    assert GoalStudy.table(ds).rows == [["0", "vibrates", "0", "-", "-", "-", "-"]]


@pytest.mark.slow
@pytest.mark.parametrize("slowest", [0.004, 0.003])
def test_a_vibration_between_quiet_ends_of_the_range_is_found(slowest):
    """A Gaussian curve falls most steeply at a4/sqrt(2), so that a damper that is a little too weak lets vibrate there
    alone: the border is that of linear theory, c = N a3/a4 sqrt(2/e). Of the values looked at first none need be there.
    """
    pair = {"mass": 1.0, "stiffness": 1.0, "a1": 1.0, "a2": 0.0, "a3": 0.3, "a4": 0.1, "delta": 2.0}
    cell = pair | {"normal_load": 1.0, "damping": 1.0}
    ds = stickslip.goal(cell, {"belt_speed": (slowest, 0.4)}, ("normal_load", "damping"),
                        {"normal_load": (0.5, 2.0), "damping": (0.5, 4.0)}, law="stribeck_delta", **QUICK)  # fmt: skip
    (line,) = polylines(ds)
    steepest = 3.0 * np.sqrt(2.0 / np.e)
    # The range is looked at in eight parts, and then to an eighth of these; in ln v the slope has the curvature -4.
    close = 2.0 * (np.log(0.4 / slowest) / 8 / 8 / 2) ** 2
    np.testing.assert_allclose(line.x / line.y, steepest, rtol=close)
    assert float(ds["alone_damping"][0]) == pytest.approx(steepest, rel=close)
    damped = pair | {"normal_load": 1.0, "damping": 0.97 * steepest, "belt_speed": [slowest, 0.4]}
    ends = stickslip.evaluate(damped, law="stribeck_delta")
    assert not ends["regime"].isin([REGIMES.index(name) for name in VIBRATING]).any()


def vibrates(curve, load, speeds, **system):
    """By brute force, whether any of many speeds vibrates."""
    a1, a2, a3 = stickslip.vocabulary.models.stribeck.coefficients(*curve)
    cells = {"mass": 0.1, "stiffness": 5e4, "damping": 10.0, "normal_load": load, "belt_speed": speeds} | system
    found = stickslip.evaluate(cells | {"a1": float(a1), "a2": float(a2), "a3": float(a3), "a4": curve[-1]}, rtol=1e-9)
    return bool(found["regime"].isin([REGIMES.index(name) for name in VIBRATING]).any())


def measured(**more):
    """Two materials by what is measured of their curves."""
    columns = {"mu_start": [0.35, 0.2], "mu_reversal": [0.28, 0.195], "v_reversal": [0.1, 0.05], "a4": [0.02, 0.01]}
    return {
        "system": {"mass": 0.1, "stiffness": "50 N/mm", "damping": 10.0, "normal_load": 10.0, "belt_speed": "10 mm/s"},
        "axes": {"material": {"zip": columns, "labels": ["felt", "grease"]}}, **more,
    }  # fmt: skip


def test_materials_are_panels_with_what_each_needs_as_brute_force_says():
    ds = stickslip.goal(measured(), {"belt_speed": "10..60 mm/s"}, ("mu_reversal", "mu_start"), **QUICK)
    assert ds["quiet_probability"].dims == ("material", "mu_reversal", "mu_start")
    assert ds["material"].values.tolist() == ["felt", "grease"]
    speeds = np.geomspace(0.01, 0.06, 200)
    for number, (start, minimum, speed, a4) in enumerate([(0.35, 0.28, 0.1, 0.02), (0.2, 0.195, 0.05, 0.01)]):
        one = ds.isel(material=number)
        assert [float(one[f"here_{name}"]) for name in ("mu_start", "mu_reversal")] == pytest.approx([start, minimum])
        is_quiet = int(one["verdict"]) == QUIET
        assert is_quiet != vibrates((start, minimum, speed, a4), 10.0, speeds)
        both = ["mu_start", "mu_reversal"]
        for what, changed in (("alone", both[:1]), ("alone", both[1:]), ("together", both)):
            here = {"mu_start": start, "mu_reversal": minimum}
            there = here | {name: float(one[f"{what}_{name}"]) for name in changed}
            sign = 1 if is_quiet else -1
            beyond = {name: value + sign * 1e-3 * (value - here[name]) for name, value in there.items()}
            assert not vibrates((*there.values(), speed, a4), 10.0, speeds)
            assert vibrates((*beyond.values(), speed, a4), 10.0, speeds)
    at = np.meshgrid(ds["mu_reversal"], ds["mu_start"], indexing="ij")
    assert ds["quiet_probability"].isnull().values[:, at[0] > at[1]].all()  # no curve has a minimum above its start
    assert set(ds["panel"].values) == {0, 1}


def test_a_decay_speed_changes_with_what_is_measured_held():
    """The border in the plane of a4 and mu_start, for a curve that is given by its coefficients."""
    a1, a2, a3 = map(float, stickslip.vocabulary.models.stribeck.coefficients(0.35, 0.28, 0.1, 0.02))
    system = {"mass": 0.1, "stiffness": 5e4, "damping": 10.0, "normal_load": 10.0}
    cell = system | {"a1": a1, "a2": a2, "a3": a3, "a4": 0.02}
    ds = stickslip.goal(cell, {"belt_speed": (0.01, 0.06)}, ("a4", "mu_start"), {"a4": (0.01, 0.04)}, **QUICK)
    speeds = np.geomspace(0.01, 0.06, 100)
    (line,) = [one for one in polylines(ds) if {one.left, one.right} == {VIBRATES, QUIET}]
    for mu, a4 in list(zip(line.x, line.y, strict=True))[:: len(line.x) // 4]:
        assert not vibrates((mu - 1e-4, 0.28, 0.1, a4), 10.0, speeds) and vibrates(
            (mu + 1e-4, 0.28, 0.1, a4), 10.0, speeds
        )


@pytest.mark.slow
def test_the_probability_is_that_of_quadrature():
    """Load scatters: the critical speed grows in proportion to it, so that P(quiet) is a normal probability."""
    load = {"normal_load": {"lognormal": {"median": 3.0, "factor": 1.2}}}
    ds = stickslip.goal(scattered(load), OVER, *PLANE, **QUICK)

    def chance(damping, mu_static):
        with np.errstate(divide="ignore"):
            return stats.norm.cdf(np.log(SLOWEST / critical(damping, mu_static)) / np.log(1.2))

    exact = chance(*np.meshgrid(ds["damping"], ds["mu_static"], indexing="ij"))
    off = np.abs(ds["quiet_probability"].values - exact)
    assert 0.2 < exact.mean() < 0.8 and ((exact > 0.02) & (exact < 0.98)).sum() > 5
    assert (off <= 5 * ds["quiet_probability_error"].values + 1 / 256).all()
    (line,) = polylines(ds)
    assert ds.attrs["goal_probability"] == 0.95  # unless another one is given
    np.testing.assert_allclose(chance(line.y, line.x), 0.95, atol=2 / 256)
    assert np.ptp(chance(line.y, line.x)) < 1e-4  # the same draws everywhere: the border is as smooth as the exact one
    assert float(ds["quiet_share"]) == pytest.approx(chance(1.0, 0.45), abs=2 / 256)
    few = coulomb().attrs
    assert few["goal_probability"] == 1.0


def test_what_is_not_decided_is_not_quiet():
    ds = coulomb(max_steps=1)
    assert not ds["quiet_probability"].any() and (ds["undecided_probability"] == 1.0).all()
    assert int(ds["verdict"][0]) == UNDECIDED and ds.sizes["line"] == 0
    load = {"normal_load": {"uniform": [1.0, 5.0]}}
    few, enough = (stickslip.goal(scattered(load, draws=4), OVER, *PLANE, **QUICK, max_steps=n) for n in (8, 100))
    assert 0.1 < float(few["undecided_probability"].mean()) < 0.9 and not enough["undecided_probability"].any()
    sum_of_both = few["quiet_probability"] + few["undecided_probability"]
    assert (few["quiet_probability"] <= enough["quiet_probability"]).all()
    assert (enough["quiet_probability"] <= sum_of_both).all()
    assert {(one.left, one.right) for one in polylines(few)} == {(VIBRATES, UNDECIDED), (QUIET, UNDECIDED)}


def test_the_command_computes_tells_and_draws_a_goal(tmp_path):
    (tmp_path / "pair.yaml").write_text(
        "system: {mass: 2, stiffness: 50, belt_speed: 50 mm/s, damping: 1}\n"
        "friction: {a1: 0.3, a2: 0, a3: 0, a4: 1, mu_static: 0.45}\n"
        "uncertain: {draws: 4, quantities: {normal_load: {normal: {mean: 3, std: 0.3}}}}\n"
    )
    words = ("goal", tmp_path / "pair.yaml", "--over", "damping", "mu_static", "--between", "damping", "0.5", "9 N s/m",
             "--quiet-over", "belt_speed=20..200mm/s", "--with", "90%",
             "--set", "goal.points=17", "--set", "goal.scan=5")  # fmt: skip
    files = ("-o", tmp_path / "goal.csv", "--plot", tmp_path / "goal.png")
    done = call(*(words + files))
    assert done.exit_code == 0, done.output
    assert "quiet over belt speed 20 to 200 mm/s with a probability of 90 %" in done.output
    assert "alone mu static" in done.output and "together damping" in done.output
    assert (tmp_path / "goal.png").stat().st_size > 10_000
    assert (tmp_path / "goal.csv").read_text(encoding="utf-8-sig").startswith("border_mu_static")
    with stickslip.open(tmp_path / "goal.nc") as ds:
        assert kind_of(ds) == "goal" and ds.attrs["goal_probability"] == 0.9
        assert parse_config(ds.attrs["configuration"]).study.quiet_over == {"belt_speed": (0.02, 0.2)}
        figure = ds.stickslip.plot()
        labels = [text.get_text() for text in figure.legends[0].get_texts()]
        assert "as it is" in labels and any(label.startswith("border, exact") for label in labels)
        assert ds.stickslip.plot("quiet_probability_error").axes


SECTION = "goal: {{axes: [mu_reversal, mu_start], quiet_over: {{belt_speed: [5 mm/s, 60 mm/s]}}{}}}\n"


@cases("explain.yaml")
def test_bad_goals_say_what_is_wrong(section, says):
    with pytest.raises(ConfigError) as error:
        parse_config(MEASURED_FORM + section)
    assert says in str(error.value)


MUS = {"mu_start": (0.3, 0.4), "a1": (0.1, 0.2)}  # one follows from the other, and would not change anything
BOTH = {"mu_start": (0.3, 0.4), "damping": (0, 1)}


@cases("explain.yaml")
def test_bad_calls_say_what_is_wrong(scatters, over, plane, says):
    known = COULOMB | {"mu_static": 0.45, "damping": 0.0}
    with pytest.raises(ValueError, match=says):
        stickslip.goal(scattered({scatters: {"uniform": [0.1, 0.2]}}) if scatters else known, over, *plane)
