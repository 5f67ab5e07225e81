"""The decision between materials: what is not ranked, several speeds and ranges, what varies, what to measure next."""

import json
import warnings

import numpy as np
import pytest
from click.testing import CliRunner

import stickslip
from stickslip.cli import main
from stickslip.config.examples import points_path
from stickslip.errors import UnitWarning
from stickslip.materials.stick_slip_end import best_measurements
from stickslip.materials.table import RankTable
from stickslip.plots import plot_materials

FILES = [points_path(f"configs/measured/{name}.csv") for name in ("dry", "grease_a", "grease_b")]
SYSTEM = {"mass": "100 g", "stiffness": "5 N/mm", "normal_load": "10 N", "damping": "1 N s/m"}
SI = {"mass": 0.1, "stiffness": 5000.0, "normal_load": 10.0, "damping": 1.0}
SPEED = np.geomspace(0.0005, 0.4, 14)
NOISE = 0.003 * np.array([1, -1, 0.5, -0.5, 1, 0, -1, 0.8, -0.6, 0.4, -0.9, 0.7, 0.6, -0.5])
DRY = 0.27 + 0.19 * SPEED + 0.15 * np.exp(-SPEED / 0.024) + NOISE
FOUR = (SPEED[[0, 5, 8, 12]], DRY[[0, 5, 8, 12]])


def call(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def compared(points, **options):
    return stickslip.compare(points, **{**SYSTEM, "draws": 100, "scan": 24, "tolerance": 1e-6, **options})


# --- what is not ranked -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("factor", [5, 60, 100])
def test_friction_in_percent_is_asked_about_and_never_ranked(factor):
    with pytest.warns(UnitWarning, match="odd: measured friction"):
        ds = compared({"odd": (SPEED, factor * DRY), "dry": (SPEED, DRY)}, belt_speed=0.02)
    assert list(ds["material"].values) == ["dry", "odd"]
    assert ds["rank"].values[0] == 1 and np.isnan(ds["rank"].values[1])
    odd = ds.isel(material=1)
    assert str(odd["quiet_state"].attrs["flag_meanings"]).split()[int(odd["quiet_state"])] == "not_determined"
    assert np.isnan(odd["quiet_above"]) and np.isnan(odd["quiet_probability"]) and np.isnan(odd["margin"])
    assert "measured friction" in str(odd["fit_quality"].values)
    words = RankTable(ds, "mm/s")
    assert "odd is not determined" in words.answer() and [c.cells[1] for c in words.columns()][0] == "-"


def test_an_extrapolated_friction_at_break_away_is_no_friction():
    """Points that are plausible, and a curve that is not before the first of them."""
    late = np.geomspace(0.1, 0.4, 14)
    steep = 0.2 + 0.1 * late + 30 * np.exp(-late / 0.02) + 1e-4 * NOISE
    with pytest.warns(UnitWarning, match="follows from the fit, not from a point"):
        ds = compared({"steep": (late, steep), "dry": (SPEED, DRY)}, draws=0)
    assert list(ds["material"].values) == ["dry", "steep"] and np.isnan(ds["rank"].values[1])


@pytest.mark.filterwarnings("ignore::stickslip.errors.UnitWarning")
def test_where_nothing_is_determined_nothing_is_best(tmp_path):
    points = {"four": FOUR, "percent": (SPEED, 100 * DRY)}
    ds = compared(points, belt_speed=[0.01, 0.03], damping=[0.1, 1.0])
    assert np.isnan(ds["rank"]).all() and np.isnan(ds["quiet_above"]).all()
    assert np.isnan(ds["quiet_above_over_damping"]).all() and (ds["regime"] == 0).all()
    words = RankTable(ds)
    assert words.answer().count("four and percent are not determined") == 2
    assert not next(words.variations())[2]
    plot_materials(ds)
    assert "do not tell where the vibration of four and percent ends" in RankTable(compared(points, draws=0)).answer()


def test_points_that_determine_too_little_come_last_with_the_reason():
    ds = compared({"a four": FOUR, "dry": (SPEED, DRY)})
    assert list(ds["material"].values) == ["dry", "a four"] and np.isnan(ds["rank"].values[1])
    assert any(said.startswith("a four: not determined, and not ranked. ") for said in RankTable(ds).remarks())
    assert np.isfinite(ds.attrs["searched_to"])


@pytest.mark.parametrize("start", [2.0, 23.0, 42.0])
def test_implausible_friction_is_asked_about_everywhere(start, tmp_path):
    cell = {**SI, "belt_speed": 0.02, "a1": 0.3, "a2": 0.2, "a3": start - 0.3, "a4": 0.01}
    with pytest.warns(UnitWarning, match=f"mu_start = {start:g} is more than"):
        stickslip.evaluate(cell)
    stickslip.evaluate(cell | {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "damping": 0.0})  # ratios
    stickslip.evaluate(cell | {"a3": 0.2})
    system = "{mass: 100 g, stiffness: 5 N/mm, normal_load: 10 N, belt_speed: 20 mm/s}"
    friction = f"{{mu_start: {start}, mu_reversal: 0.2, v_reversal: 900 mm/s, a4: 60 mm/s}}"
    with pytest.warns(UnitWarning, match="a friction coefficient"):
        stickslip.load_config(_written(tmp_path, f"system: {system}\nfriction: {friction}\n"))
    table = "\n".join(f"{w}, {y}" for w, y in zip(SPEED, DRY * start / 0.42, strict=True))
    (tmp_path / "odd.csv").write_text(f"speed [m/s], mu\n{table}\n")
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        done = call("fit", tmp_path / "odd.csv")
    assert done.exit_code == 2 or "odd: measured friction" in done.stderr  # refused, or asked about


def _written(folder, text):
    (folder / "odd.yaml").write_text(text)
    return folder / "odd.yaml"


# --- belt speeds ------------------------------------------------------------------------------------------------------


def test_several_belt_speeds_say_what_each_says_alone():
    both = compared(FILES, belt_speed=["30 mm/s", "0.01 m/s"])
    assert both["belt_speed"].values.tolist() == [0.01, 0.03] and "belt_speed" not in both.attrs
    for speed in (0.01, 0.03):
        one, same = compared(FILES, belt_speed=speed), both.sel(belt_speed=speed)
        for name in ("regime", "frequency", "margin", "quiet_probability", "tendency", "quiet_above"):
            np.testing.assert_array_equal(one[name], same[name])
    assert compared(FILES, belt_speed=[0.01, 0.01]).sizes.get("belt_speed") is None


def test_a_range_counts_its_worst_speed():
    ds = compared(FILES, speed_range=("25 mm/s", "60 mm/s"))
    np.testing.assert_allclose(ds["margin"], 0.025 / ds["quiet_above"])
    quiet = ds["quiet_above"].values < 0.025
    assert (np.isin(ds["regime"], (1, 4)) == ~quiet).all() and quiet.any() and not quiet.all()
    assert (ds["worst_speed"].values[quiet] == 0.025).all() and (ds["worst_speed"].values[~quiet] > 0.025).all()
    alone = compared(FILES, belt_speed="25 mm/s")
    np.testing.assert_array_equal(ds["quiet_probability"], alone["quiet_probability"])
    said = RankTable(ds, "mm/s").answer()
    assert (
        said.startswith("From 25 to 60 mm/s grease_b")
        and "is probably quiet throughout" in said
        and "vibrates throughout" in said
    )
    assert float(ds["vibrating_share"][0]) == 0 and float(ds["vibrating_share"][2]) == 1
    same = compared(FILES, belt_speed="25..60 mm/s")
    np.testing.assert_array_equal(same["worst_speed"], ds["worst_speed"])


OPTIONS = ["--mass", "100 g", "--stiffness", "5 N/mm", "--load", "10 N", "--draws", 0]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--speed", "60..5 mm/s"], "swap the ends"),
        (["--speed", "5..5 mm/s"], "the lower end first"),
        (["--speed", "5 mm/s..60"], "upper end has no unit"),
        (["--speed", "-5..60 mm/s"], "expected a speed above 0"),
        (["--speed", "0..60 mm/s"], "expected a speed above 0"),
        (["--speed", "5...60 mm/s"], "with two dots"),
        (["--speed", "5..6..7 mm/s"], "with two dots"),
        (["--speed", "..60 mm/s"], "with two dots"),
        (["--speed", "5..60 kg"], "expected a speed"),
        (["--speed", "5-60 mm/s"], "expected a speed"),
        (["--speed", "5..60 mm/s", "--speed", "7 mm/s"], "several values or one range"),
        (["--damping", "-1 %"], "a share of critical damping"),
        (["--damping", "0,5 %"], "a share of critical damping"),
        (["--damping", "nan %"], "a share of critical damping"),
        (["--damping", "5..0.5 %"], "swap the ends"),
        (["--scale-friction", "0"], "a number above 0"),
        (["--scale-friction", "50 %"], "a number (without unit)"),
        (["--mass", "1..2 kg"], "takes one value"),
        (["--between", "1 mm/s", "10 mm/s", "--speed", "20 mm/s"], "expected it to hold the belt speed"),
        (["--between", "1 m/s", "2 m/s", "--between", "1 m/s", "3 m/s"], "--between is given 2 times"),
        (["--level", "0.9", "--level", "0.8"], "--level is given 2 times"),
    ],
)
def test_what_is_no_speed_or_range_is_refused(words, said):
    done = call("compare", FILES[0], *OPTIONS, *words)
    assert done.exit_code == 2 and said in done.stderr, done.output


def test_ends_of_a_range_may_have_units_of_their_own():
    done = call("compare", FILES[0], *OPTIONS, "--damping", "1 N s/m", "--speed", "5 mm/s..0.06 m/s", "--json")
    told = json.loads(done.stdout)
    assert (told["speed_range_from"], told["speed_range_to"]) == (0.005, 0.06)


@pytest.mark.parametrize(
    "words", [("run", "quickstart.yaml", "-o", "a.nc", "-o", "b.nc"), ("fit", "x.csv", "--unit", "mm/s", "--unit=m/s"),
              ("rig", "run", "x.yaml", "--plot", "a.png", "--plot", "b.png")],
)  # fmt: skip
def test_an_option_that_takes_one_value_is_not_taken_twice(words):
    done = call(*words)
    assert done.exit_code == 2 and "is given 2 times, and takes one value" in done.stderr


# --- what varies ------------------------------------------------------------------------------------------------------


def test_damping_in_percent_is_a_share_of_critical_damping():
    share = compared(FILES[:1], damping="3 %", draws=0)
    assert share.attrs["system_damping"] == pytest.approx(0.03 * 2 * np.sqrt(5000 * 0.1))
    assert dict(RankTable(share).conditions())["viscous damping coefficient"] == "1.342 N s/m, 3 % of critical"
    said = " ".join(RankTable(stickslip.compare(FILES[0], **{**SYSTEM, "damping": None}, draws=0)).remarks())
    assert "Metal in one piece" in said and "Metal" not in " ".join(RankTable(share).remarks())


def test_borders_over_a_range_are_those_of_each_value():
    ds = compared(FILES, damping="0.5..5 %", normal_load=[5, 10], draws=0)
    assert ds.sizes["damping"] == 5 and ds["normal_load"].values.tolist() == [5, 10]
    least = float(ds["damping"][0])
    assert ds.attrs["system_damping"] == least and ds.attrs["system_normal_load"] == 10
    np.testing.assert_allclose(ds["quiet_above_over_damping"][:, 0], ds["quiet_above"], rtol=1e-5)
    between = (ds.attrs["searched_from"], ds.attrs["searched_to"])
    last = compared(FILES, damping=float(ds["damping"][-1]), draws=0, between=between)
    np.testing.assert_allclose(ds["quiet_above_over_damping"][:, -1], last["quiet_above"], rtol=1e-5)
    assert any("Only friction times load counts" in said for said in RankTable(ds).remarks())


def test_half_the_friction_is_half_the_load():
    scaled, light = compared(FILES, friction_scale=0.5), compared(FILES, normal_load="5 N")
    np.testing.assert_allclose(scaled["quiet_above"], light["quiet_above"], rtol=1e-5)
    np.testing.assert_allclose(scaled["quiet_above_high"], light["quiet_above_high"], rtol=2e-3)
    np.testing.assert_array_equal(scaled["a1"], light["a1"])
    again = stickslip.run(stickslip.config.reader.parse_config(str(scaled.attrs["configuration"])))
    np.testing.assert_allclose(np.nanmax(again["border"], axis=1), scaled["quiet_above"], rtol=1e-5)


def test_a_change_of_order_is_told_where_it_happens():
    """A small drop at high speeds, which little damping ends, and a large one at low speeds, which it does not."""
    points = {"small": (SPEED, 0.2 + 0.02 * SPEED + 0.01 * np.exp(-SPEED / 0.1)),
              "large": (SPEED, 0.2 + 0.1 * SPEED + 0.1 * np.exp(-SPEED / 0.01))}  # fmt: skip
    ds = compared(points, damping=["0.01 N s/m", "1.2 N s/m", "20 N s/m"], draws=0)
    _, _, remarks = next(RankTable(ds).variations())
    borders = ds["quiet_above_over_damping"]
    assert float(borders.sel(material="small")[0]) > float(borders.sel(material="large")[0])
    assert float(borders.sel(material="small")[1]) < float(borders.sel(material="large")[1])
    assert len(remarks) == 1 and "change places between 0.01 N s/m and 1.2 N s/m" in remarks[0]


def test_the_answer_for_programs_has_a_row_a_speed_and_what_varies():
    done = call("compare", *FILES, *OPTIONS, "--damping", "1 %", "--damping", "3 %", "--speed", "10 mm/s", "--speed",
                "30 mm/s", "--json")  # fmt: skip
    told = json.loads(done.stdout)
    best = told["materials"][0]
    assert [row["belt_speed"] for row in best["at"]] == [0.01, 0.03] and best["at"][1]["regime"] == "damped"
    assert best["at"][0]["margin"] == pytest.approx(0.01 / best["quiet_above"])
    assert len(best["quiet_above_over_damping"]) == len(told["damping"]) == 2


# --- what to measure next ---------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_two_more_points_where_they_are_proposed_narrow_the_interval_about_as_expected():
    random = np.random.default_rng(11)
    truth = [(0.27, 0.19, 0.15, 0.024), (0.2, 0.5, 0.1, 0.012), (0.15, 0.3, 0.1, 0.03), (0.3, 0.2, 0.2, 0.05)]
    points = {}
    for i, (a1, a2, a3, a4) in enumerate(truth):
        w = np.geomspace(0.05 * a4, 12 * a4, 14)
        points[f"m{i}"] = (w, a1 + a2 * w + a3 * np.exp(-w / a4) + random.normal(0, 0.02 * a3, w.size))
    ds = compared(points, draws=400).sortby("material")
    width = ds["quiet_above_high"] - ds["quiet_above_low"]
    expected = ((ds["next_high"] - ds["next_low"]) / width).values
    assert (expected < 1).all() and (expected > 0.1).all()
    more = {}
    for i, (a1, a2, a3, a4) in enumerate(truth):
        for repeat in range(3):
            at = np.array([ds["next_speed_1"][i], ds["next_speed_2"][i]])
            mu = a1 + a2 * at + a3 * np.exp(-at / a4) + random.normal(0, 0.02 * a3, 2)
            more[f"m{i}{repeat}"] = tuple(map(np.append, points[f"m{i}"], (at, mu)))
    again = compared(more, draws=400).sortby("material")
    narrowed = (again["quiet_above_high"] - again["quiet_above_low"]).values.reshape(4, 3).mean(axis=1) / width.values
    assert abs(narrowed.mean() / expected.mean() - 1) < 0.3
    assert any("the interval would shrink from" in said for said in RankTable(ds).remarks())


def test_the_best_measurements_are_where_the_target_is():
    """What is asked for is the friction at 0.1 m/s on a line: two points about it halve nothing but its own scatter."""
    random = np.random.default_rng(2)
    curves = {"a1": random.normal(0.3, 0.01, 5000), "a2": np.full(5000, 0.1), "a3": np.zeros(5000), "a4": np.ones(5000)}
    speeds, factor = best_measurements(curves["a1"], curves, (0.01, 1.0), 0.02)
    assert factor == pytest.approx(np.sqrt(1 / (1 + 2 * 0.01**2 / 0.02**2)), rel=0.01)
    assert best_measurements(curves["a1"][:50], {k: v[:50] for k, v in curves.items()}, (0.01, 1.0), 0.02) is None
