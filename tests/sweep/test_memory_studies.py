"""Studies of contacts with memory: borders where linear theory says, and what depends on the model."""

import numpy as np
import pytest

import stickslip
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError
from stickslip.studies.search import Looked, Scan, search_lines
from stickslip.vocabulary.quantities import METHODS, REGIMES

PAIR = {"mass": 1.0, "normal_load": 10.0, "mu_0": 0.6, "v_0": 1e-6, "a": 0.01, "b": 0.018, "D_c": 1e-6}
BRISTLES = {
    "mass": 0.1, "damping": 1.0, "normal_load": 10.0, "a1": 0.25, "a2": 0.0, "a3": 0.05, "a4": 0.02,
    "contact_stiffness": 2e4, "contact_damping": 5.0,
}  # fmt: skip
CASES = [
    ("rate_state_ageing", PAIR, [1e-6, 1e-4], (1e2, 1e7)),
    pytest.param("rate_state_slip", PAIR, [1e-5, 1e-3], (1e2, 1e7), marks=pytest.mark.slow),
    ("stribeck", BRISTLES, [2e-3, 8e-3, 0.03], (1e2, 1e6)),
]
BY_THEORY = METHODS.index("growth_rate")
QUIET, VIBRATING = (
    {REGIMES.index(name) for name in names} for names in (("damped", "creep"), ("sustained", "stick_slip"))
)


@pytest.mark.parametrize(("law", "pair", "speeds", "ends"), CASES)
def test_steady_sliding_loses_its_stability_at_the_critical_stiffness(law, pair, speeds, ends):
    """The border is there to rounding, its width is what could not be decided about it, and says so."""
    cell = pair | {"belt_speed": speeds}
    ds = stickslip.border(cell, "stiffness", ends, law=law)
    assert (ds.attrs["border_tolerance"], ds.attrs["border_rtol"]) == (1e-4, 1e-6)
    critical = stickslip.evaluate(cell | {"stiffness": 1e4}, law=law)["critical_stiffness"].values
    for line, expected in enumerate(critical):
        one = ds.isel(cell=line).dropna("crossing")
        at = int(np.argmin(np.abs(one["border"].values - expected)))
        border, width = float(one["border"][at]), float(one["border_width"][at])
        by_theory = one["method"].values[at] == BY_THEORY
        # The ageing law has a cycle beside stable sliding on springs up to some thousandths stiffer.
        assert border == pytest.approx(expected, rel=1e-9 if by_theory else 2e-3)
        assert width < (0.1 if by_theory else 1e-4) * border
        assert {int(one["regime_below"][at])} <= VIBRATING and {int(one["regime_above"][at])} <= QUIET
        assert by_theory == (law != "rate_state_ageing" or line == 0)


@pytest.mark.slow
def test_a_margin_ends_where_linear_theory_says():
    cell = PAIR | {"belt_speed": 1e-3, "stiffness": 1e5}
    ds = stickslip.margins(cell, ["stiffness"], into=["damped"], joint=False, law="rate_state_slip")
    critical = float(stickslip.evaluate(cell, law="rate_state_slip")["critical_stiffness"][0])
    assert float(ds["border_stiffness"].sel(side="above").values.ravel()[0]) == pytest.approx(critical, rel=1e-9)
    assert ds.attrs["margin_tolerance"] == 1e-4


@pytest.mark.parametrize("name", ["mu_stop", "a1", "contact_stiffness", "mu_start"])
def test_a_margin_along_a_parameter_of_another_law_names_that_law(name):
    cell = PAIR | {"belt_speed": 1e-3, "stiffness": 1e5}
    with pytest.raises(ValueError, match=r"parameters: .*\b(stribeck|lugre_stribeck)\b"):
        stickslip.margins(cell, [name], law="rate_state_slip")
    text = f"""
system: {{mass: 1 kg, normal_load: 10 N, belt_speed: 1 mm/s, stiffness: 100 N/mm}}
friction: {{law: rate_state_slip, mu_0: 0.6, v_0: 1 um/s, a: 0.010, b: 0.018, D_c: 1 um}}
margins: {{parameters: [{name}]}}
"""
    with pytest.raises(ConfigError, match=r"margins.parameters: .*\b(stribeck|lugre_stribeck)\b"):
        parse_config(text)


@pytest.mark.slow
def test_contours_follow_the_critical_stiffness_past_what_is_undecided():
    """One line, no speckles, though grid points next to it are unresolved."""
    ds = stickslip.contours(
        PAIR, ("stiffness", "belt_speed"), {"stiffness": (2e4, 4e5), "belt_speed": (1e-5, 1e-2)},
        points=48, scan=24, law="rate_state_ageing",
    )  # fmt: skip
    unresolved = REGIMES.index("unresolved")
    sides = np.stack([ds["regime_left"].values, ds["regime_right"].values])
    assert not (sides == unresolved).any()
    quiet = np.isin(sides, [*QUIET])
    along = np.repeat(quiet[0] != quiet[1], ds["node_count"].values)
    places = {name: ds[name].values[along] for name in ("stiffness", "belt_speed")}
    critical = stickslip.evaluate(PAIR | places, law="rate_state_ageing")["critical_stiffness"].values
    exact = np.isclose(places["stiffness"], critical, rtol=1e-9)
    assert along.sum() > 40 and exact.sum() > 10
    np.testing.assert_allclose(places["stiffness"], critical, rtol=2e-2)


@pytest.mark.parametrize("zero", [0.31, 0.5, 0.69])
def test_a_border_amid_undecided_places_is_where_the_guide_vanishes(zero):
    """And keeps the width of these; where it vanishes elsewhere, it says nothing."""

    def labels(line, place):
        undecided = np.abs(place - 0.5) < 0.2
        return Looked((place > 0.5).astype(np.int8), ~undecided, place - zero)

    found, _ = search_lines(1, Scan(0.0, 1.0, 9, "linear"), 1e-6, labels, lambda line, place: place - zero)
    (one,) = found
    assert one["guided"] and one["place"] == pytest.approx(zero, abs=1e-11)
    assert one["low"] <= 0.3 and one["high"] >= 0.7 and one["high"] - one["low"] <= 0.8
    found, _ = search_lines(
        1, Scan(0.0, 1.0, 9, "linear"), 1e-6, lambda *at: labels(*at)._replace(guide=at[1] - 0.05),
        lambda line, place: place - 0.05,
    )  # fmt: skip
    assert not found["guided"][0] and found["place"][0] == pytest.approx(0.5, abs=1e-6)
    assert found["high"][0] - found["low"][0] == pytest.approx(0.4, rel=1e-4)


def test_one_undecided_place_does_not_hand_a_border_to_theory():
    """Nor do two with decided ones between: labels change at 0.6, the guide at 0.5; neither is decided."""

    def labels(line, place):
        undecided = (np.abs(place - 0.5) < 1e-3) | (np.abs(place - 0.6) < 1e-4)
        quiet = place > 0.6
        guide = np.where(undecided | (quiet == (place > 0.5)), place - 0.5, np.nan)
        return Looked(quiet.astype(np.int8), ~undecided, guide)

    for points in (2, 3, 5, 9, 11):
        (one,), _ = search_lines(1, Scan(0.0, 1.0, points, "linear"), 1e-5, labels, lambda line, place: place - 0.5)
        assert one["low"] <= 0.6 - 1e-4 and 0.6 + 1e-4 <= one["high"] and not one["guided"]
        assert one["high"] - one["low"] < 2e-4 + 4e-5 and one["place"] == pytest.approx(0.6, abs=2e-5)


BESIDE_STABLE = PAIR | {"belt_speed": 1e-4}  # a vibration persists beside stable sliding: 88,000 to 88,116 N/m


@pytest.mark.parametrize("ends", [(2e4, 4e6), (8e4, 9e4), (8.80e4, 8.83e4), (3e4, 1.7e5)])
def test_a_border_does_not_depend_on_the_range_that_is_searched(ends):
    """Both ends of the last bracket are cells, whose regimes are computed once more on their own."""
    ds = stickslip.border(BESIDE_STABLE, "stiffness", ends, law="rate_state_ageing").squeeze("cell")
    quiet = np.isin(ds["regime_above"].values, [*QUIET]) & np.isin(ds["regime_below"].values, [*VIBRATING])
    (border,), (width,) = ds["border"].values[quiet], ds["border_width"].values[quiet]
    assert width < 2e-4 * border and abs(border - 88116) < width
    beside = border + np.array([-3.0, -2.0, 2.0, 3.0]) * width
    regimes = stickslip.evaluate(BESIDE_STABLE | {"stiffness": beside}, law="rate_state_ageing")["regime"].values
    assert {*regimes[:2].tolist()} <= VIBRATING and {*regimes[2:].tolist()} <= QUIET


def test_contours_lie_where_borders_do():
    """Also where grid points beside them are undecided: at 88,010 N/m."""
    around = {"stiffness": (8.7e4, 2 * 88010.0 - 8.7e4), "damping": (0.0, 1e-3)}
    ds = stickslip.contours(BESIDE_STABLE, ("stiffness", "damping"), around, points=3, scan=3, law="rate_state_ageing")
    np.testing.assert_allclose(ds["stiffness"].values, 88116, rtol=2e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("spacing", "middle"), [("log", 2e4 * 5**0.5), ("linear", 6e4)])
def test_a_ramp_has_the_spacing_of_its_axis(spacing, middle):
    """Vibration ends by the critical stiffness, 88 N/mm."""
    config = parse_config(f"""
system: {{mass: 1 kg, normal_load: 10 N, belt_speed: 100 um/s}}
friction: {{law: rate_state_slip, mu_0: 0.6, v_0: 1 um/s, a: 0.010, b: 0.018, D_c: 1 um}}
axes:
  stiffness: {{start: 20 N/mm, stop: 100 N/mm, num: 9, spacing: {spacing}}}
""")
    ds = stickslip.ramp(config, "stiffness", points=3)
    np.testing.assert_allclose(ds["stiffness"].values, [2e4, middle, 1e5])
    assert ds["stiffness"].attrs["axis_spacing"] == spacing
    assert ds["regime"].sel(direction="up").values.ravel().tolist() == [4, 4, 2]
