"""The decision between materials: what is not ranked, several speeds and ranges, verdicts and their numbers."""

import json
import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip
from helpers.commands import call
from helpers.data import cases
from helpers.measured import FILES, SYSTEM
from stickslip.errors import UnitWarning
from stickslip.plots import plot_materials
from stickslip.vocabulary.quantities import REGIMES
from stickslip_materials.compare.table import RankTable, verdict

SPEED = np.geomspace(0.0005, 0.4, 14)
NOISE = 0.003 * np.array([1, -1, 0.5, -0.5, 1, 0, -1, 0.8, -0.6, 0.4, -0.9, 0.7, 0.6, -0.5])
DRY = 0.27 + 0.19 * SPEED + 0.15 * np.exp(-SPEED / 0.024) + NOISE
FOUR = (SPEED[[0, 5, 8, 12]], DRY[[0, 5, 8, 12]])


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
    assert "open odd" in words.answer() and words.table().rows[1][0] == "-"


def test_an_extrapolated_friction_at_break_away_is_no_friction():
    """Points that are plausible, and a curve that is not before the first of them."""
    late = np.geomspace(0.1, 0.4, 14)
    steep = 0.2 + 0.1 * late + 30 * np.exp(-late / 0.02) + 1e-4 * NOISE
    with pytest.warns(UnitWarning, match="of the fit = "):
        ds = compared({"steep": (late, steep), "dry": (SPEED, DRY)}, draws=0)
    assert list(ds["material"].values) == ["dry", "steep"] and np.isnan(ds["rank"].values[1])


@pytest.mark.filterwarnings("ignore::stickslip.errors.UnitWarning")
def test_where_nothing_is_determined_nothing_is_best(tmp_path):
    points = {"four": FOUR, "percent": (SPEED, 100 * DRY)}
    ds = compared(points, belt_speed=[0.01, 0.03])
    assert np.isnan(ds["rank"]).all() and np.isnan(ds["quiet_above"]).all()
    assert (ds["regime"] == 0).all()
    assert RankTable(ds).answer().count("open four and percent") == 2
    plot_materials(ds)
    assert RankTable(compared(points, draws=0)).answer() == "not determined: four and percent"


def test_points_that_determine_too_little_come_last_with_the_reason():
    ds = compared({"a four": FOUR, "dry": (SPEED, DRY)})
    assert list(ds["material"].values) == ["dry", "a four"] and np.isnan(ds["rank"].values[1])
    assert [name for name, _ in RankTable(ds).notes()] == ["a four"]
    assert np.isfinite(ds.attrs["searched_to"])


def test_neighbours_whose_order_is_open_and_points_that_nobody_measured_are_named():
    ds = compared({"dry": (SPEED, DRY), "drier": (SPEED, 1.01 * DRY), "oil": (SPEED, 0.3 * DRY)})
    (note,) = [text for name, text in RankTable(ds).notes() if not name]
    assert "dry may be behind drier" in note or "drier may be behind dry" in note
    assert [text for _, text in RankTable(compared(FILES)).notes()][0].endswith("grease_b, grease_a and dry")


# --- belt speeds ------------------------------------------------------------------------------------------------------


def test_several_belt_speeds_say_what_each_says_alone():
    both = compared(FILES, belt_speed=["30 mm/s", "0.01 m/s"])
    assert both["belt_speed"].values.tolist() == [0.01, 0.03] and "belt_speed" not in both.attrs
    for speed in (0.01, 0.03):
        one, same = compared(FILES, belt_speed=speed), both.sel(belt_speed=speed)
        for name in ("regime", "frequency", "margin", "quiet_probability", "quiet_above"):
            np.testing.assert_array_equal(one[name], same[name])


def test_a_range_counts_its_worst_speed():
    ds = compared(FILES, belt_speed="25..60 mm/s")
    np.testing.assert_allclose(ds["margin"], 0.025 / ds["quiet_above"])
    quiet = ds["quiet_above"].values < 0.025
    assert (np.isin(ds["regime"], (1, 4)) == ~quiet).all() and quiet.any() and not quiet.all()
    assert (ds["worst_speed"].values[quiet] == 0.025).all() and (ds["worst_speed"].values[~quiet] > 0.025).all()
    alone = compared(FILES, belt_speed="25 mm/s")
    np.testing.assert_array_equal(ds["quiet_probability"], alone["quiet_probability"])
    assert RankTable(ds, "mm/s").answer() == "from 25 to 60 mm/s: quiet grease_b; vibrates grease_a and dry"


OPTIONS = ["--mass", "100 g", "--stiffness", "5 N/mm", "--load", "10 N", "--draws", 0]


@cases("materials.yaml")
def test_what_is_no_speed_or_range_is_refused(words, said):
    done = call("compare", FILES[0], *OPTIONS, *words)
    assert done.exit_code == 2 and said in done.stderr, done.output


def test_ends_of_a_range_may_have_units_of_their_own():
    done = call("compare", FILES[0], *OPTIONS, "--damping", "1 N s/m", "--speed", "5 mm/s..0.06 m/s", "--json")
    told = json.loads(done.stdout)
    assert (told["speed_range_from"], told["speed_range_to"]) == (0.005, 0.06)


# --- damping ------------------------------------------------------------------------------------------------------


def test_damping_in_percent_is_a_share_of_critical_damping():
    share = compared(FILES[:1], damping="3 %", draws=0)
    assert share.attrs["system_damping"] == pytest.approx(0.03 * 2 * np.sqrt(5000 * 0.1))
    assert dict(RankTable(share).conditions())["viscous damping coefficient"] == "1.342 N s/m (3 % of critical)"
    bare = compared(FILES[:1], damping=None, draws=0)
    for ds, is_assumed in ((share, False), (bare, True)):
        assert any("damping" in text for _, text in RankTable(ds).notes()) == is_assumed


def test_the_answer_for_programs_has_a_row_a_speed():
    done = call("compare", *FILES, *OPTIONS, "--damping", "1 %", "--speed", "10 mm/s", "--speed",
                "30 mm/s", "--json")  # fmt: skip
    told = json.loads(done.stdout)
    best = told["materials"][0]
    assert [row["belt_speed"] for row in best["at"]] == [0.01, 0.03] and best["at"][1]["regime"] == "damped"
    assert best["at"][0]["margin"] == pytest.approx(0.01 / best["quiet_above"])


# --- a verdict and its numbers ----------------------------------------------------------------------------------------

STATES = ("border", "quiet_throughout", "vibrates_throughout", "unresolved", "not_determined")
SHARE = st.floats(0, 1) | st.just(math.nan)


MARGIN = st.floats(0.01, 100) | st.just(math.inf)


@given(st.sampled_from(STATES), st.integers(0, len(REGIMES) - 1), MARGIN, SHARE)
def test_no_verdict_contradicts_a_number_beside_it(state, regime, margin, quiet):
    """Whatever the numbers of a material are."""
    row = SimpleNamespace(state=state, regime=regime, margin=margin, quiet_probability=quiet)
    kind, name = verdict(row), REGIMES[regime]
    if kind == "quiet":
        assert name in ("damped", "creep", "stuck") and margin > 1 and not quiet < 0.5
    if kind == "vibrates":
        assert name in ("stick_slip", "sustained") and margin <= 1 and not quiet > 0.5
    if state == "not_determined":
        assert kind == "open"


def test_ranked_borders_lie_in_their_intervals_and_agree_with_their_verdicts():
    """Tables of all shapes, scatters and lengths, some with rows of a footer among their points."""
    random, points = np.random.default_rng(2026), {}
    for i in range(24):
        speed = np.geomspace(random.uniform(0.3, 3) * 1e-3, random.uniform(0.1, 0.5), random.integers(6, 21))
        drop, decay = random.choice([-0.02, 0, 0.01, 0.05, 0.2]), 10 ** random.uniform(-3, -1)
        mu = 0.2 + random.uniform(0, 0.6) * speed + drop * np.exp(-speed / decay)
        mu *= 1 + random.choice([0, 0.01, 0.03, 0.08]) * random.standard_normal(speed.size)
        if i % 3 == 0:  # Mittelwert, Maximum, Minimum, in the columns of the points
            speed, mu = (np.append(column, [column.mean(), column.max(), column.min()]) for column in (speed, mu))
        points[f"m{i}"] = speed, mu
    ds = compared(points, belt_speed="5..60 mm/s", draws=80)
    ranked = ds.isel(material=np.isfinite(ds["rank"].values) & np.isfinite(ds["quiet_above_low"].values))
    assert ranked.sizes["material"] >= 8
    known = str(ds["quiet_state"].attrs["flag_meanings"]).split()
    for i in range(ranked.sizes["material"]):
        one = ranked.isel(material=i)
        state, border = known[int(one["quiet_state"])], float(one["quiet_above"])
        border = {"quiet_throughout": 0.0, "vibrates_throughout": math.inf}.get(state, border)
        assert float(one["quiet_above_low"]) <= border <= float(one["quiet_above_high"]), str(one["material"].values)
        if state == "quiet_throughout":
            assert one["quiet_probability"] >= 0.5
    for part in RankTable(ds).answer().partition(": ")[2].split("; "):
        least = {"quiet": 0.5, "vibrates": 0.0, "open": 0.0}[part.split()[0]]
        names = re.findall(r"m\d+", part)
        assert names and all(ds["quiet_probability"].sel(material=name) >= least for name in names if least)
