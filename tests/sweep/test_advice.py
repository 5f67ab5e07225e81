"""The commands `contours` and `advise`, and what is said of their files."""

import re

import numpy as np
import pytest

import stickslip
from helpers.commands import told
from helpers.data import cases
from stickslip.files import writing

PAIR = """\
title: Pair
system: {mass: 1, normal_load: 1}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes:
  stiffness: {start: 0.5, stop: 2, num: 4}
  belt_speed: {start: 0.3, stop: 1, num: 8}
"""


CELL = {"mass": 1, "stiffness": 1, "normal_load": 1, "a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1}
AT = ("--at", "stiffness=1", "--at", "belt_speed=1")


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pair.yaml").write_text(PAIR)
    return tmp_path


def test_contours_go_to_a_file_a_table_and_a_plot(here):
    numbers = ("--set", "contours.points=16", "--set", "contours.tolerance=1e-4")
    arguments = (*numbers, "-o", "lines.csv", "--plot", "lines.png")
    words = told("contours", "pair.yaml", *arguments)
    assert re.search(r"^stick_slip +damped +line +[\d.]+ to [\d.]+ m/s", words, re.MULTILINE)
    ds = stickslip.open("lines.nc")
    table = np.genfromtxt("lines.csv", delimiter=",", names=True, dtype=None, encoding="utf-8-sig",
                          deletechars="")  # fmt: skip
    assert {"belt_speed_[m/s]", "stiffness_[N/m]"} <= set(table.dtype.names)
    np.testing.assert_allclose(table["belt_speed_[m/s]"], ds["belt_speed"], rtol=1e-5)
    assert (table["line"] == np.repeat(np.arange(ds.sizes["line"]), ds["node_count"])).all()
    assert (here / "lines.png").stat().st_size > 1000
    assert "complete already" in told("contours", "pair.yaml", *arguments)


def test_borders_are_drawn_over_the_map_of_a_file_or_a_coarse_one(here):
    told("run", "pair.yaml", "-o", "map.nc")
    numbers = ("--set", "border.scan=8", "--set", "border.tolerance=1e-4")
    told("border", "pair.yaml", "--along", "belt_speed", *numbers, "-o", "b.nc", "--plot", "b.png")
    told("border", "pair.yaml", "--along", "damping", "--between", "0", "1", *numbers, "-o", "d.nc", "--plot", "d.png")
    assert "plot     c.png" in told("plot", "b.nc", "-o", "c.png")
    assert "plot     m.png" in told("plot", "map.nc", "--lines", "b.nc", "-o", "m.png")
    for name in ("b", "c", "d", "m"):
        assert (here / f"{name}.png").stat().st_size > 1000


def test_inspect_says_what_a_file_holds(here):
    told("border", "pair.yaml", "--along", "belt_speed", "--set", "border.scan=8", "-o", "b.nc")
    told("contours", "pair.yaml", "--set", "contours.points=8", "--set", "contours.tolerance=1e-3", "-o", "c.nc")
    assert "borders  4 on 4 of 4 lines" in told("inspect", "b.nc") and "lines    1, 0" in told("inspect", "c.nc")
    writing.write(stickslip.margins("pair.yaml", ("belt_speed",), joint=False, tolerance=1e-3), "m.nc")
    assert re.search(r"^belt_speed +\d+ of 32 +x", told("inspect", "m.nc"), re.MULTILINE)
    assert "holds none" in told("inspect", "b.nc", "--regime", "damped", code=2)


def rows(text):
    """The first rows of tables by parameter, cells between two spaces or more."""
    cells = [re.split(r"  +", line) for line in reversed(text.splitlines())]
    return {row[0]: row[1:] for row in cells if len(row) > 2}


def test_advice_is_a_table_and_a_change_that_was_simulated(here):
    words = told("advise", "pair.yaml", *AT[:2], "--at", "belt_speed=0.7", "--parameter", "belt_speed",
                "--parameter", "damping", "--set", "margins.costs.damping=0.5", "-o", "advice.nc")  # fmt: skip
    single, joint = words.split("cheapest joint change: ")
    assert "regime   stick_slip; wanted: damped, creep or stuck" in single
    value, border, by, into, simulated, _ = rows(single)["belt_speed"]
    assert (value, by, into, simulated) == ("0.7 m/s", "x 1.14", "damped", "damped")
    assert border.startswith("above 0.798175") and rows(single)["damping"][0] == "0 N s/m"
    ds = stickslip.open("advice.nc")
    assert float(ds["ratio_belt_speed"]) == pytest.approx(0.79817535635 / 0.7, rel=1e-8)
    cost, end = re.match(r"cost (\S+), simulated: (\S+)\n", joint).groups()
    assert end == "damped" and float(cost) == pytest.approx(float(ds["joint_cost"]), rel=5e-3)
    for name in ("belt_speed", "damping"):
        to, share = rows(joint)[name][1].split()[0], rows(joint)[name][2]
        assert float(to) == pytest.approx(float(ds[f"joint_proposed_{name}"]), rel=5e-4)
        assert float(share.rstrip(" %")) == pytest.approx(100 * float(ds[f"joint_share_{name}"]), rel=5e-3)


def test_python_says_of_a_cell_what_the_command_says(here):
    words = told(
        "advise", "pair.yaml", *AT[:2], "--at", "belt_speed=0.9", "--parameter", "belt_speed", "-o", "advice.nc"
    )
    assert "regime   damped; wanted: stick_slip or sustained" in words
    cell = CELL | {"belt_speed": 0.9}
    report = stickslip.margins(cell, ("belt_speed",), into=("opposite",)).stickslip.report()
    assert rows(report)["belt_speed"][:2] == rows(words)["belt_speed"][:2]
    assert rows(report)["belt_speed"][1].startswith("below 0.798175")
    assert stickslip.open("advice.nc").stickslip.report().splitlines()[0] == report.splitlines()[0]
    with pytest.raises(ValueError, match="a result of no study"):
        stickslip.evaluate(cell).stickslip.report()


def test_the_opposite_of_each_cell_is_looked_for(here):
    """Of a cell that vibrates the regimes that are quiet, of one that is quiet those that vibrate: as each by name."""
    both = stickslip.margins(CELL | {"belt_speed": [0.5, 0.9]}, ("damping", "belt_speed"), into=("opposite",))
    quiet, loud = ("damped", "creep", "stuck"), ("stick_slip", "sustained")
    for i, (speed, into) in enumerate(((0.5, quiet), (0.9, loud))):
        alone = stickslip.margins(CELL | {"belt_speed": speed}, ("damping", "belt_speed"), into=into).isel(cell=0)
        for name in ("margin_belt_speed", "margin_damping", "joint_cost", "joint_proposed_belt_speed"):
            np.testing.assert_array_equal(both[name][i], alone[name])


@cases("sweep.yaml")
def test_wrong_input_is_said_before_anything_is_computed(here, arguments, message):
    assert message in told(*arguments, code=2)


def test_what_is_measured_of_a_curve_may_change_with_the_rest_of_it_held(here):
    """The borders are those of a search along it in the measured form of the configuration."""
    words = told("advise", "pair.yaml", *AT[:2], "--at", "belt_speed=0.7", "--parameter", "mu_start", "--parameter",
                "mu_reversal", "--parameter", "v_reversal", "-o", "advice.nc")  # fmt: skip
    ds = stickslip.open("advice.nc")
    start, least, speed = (float(ds[name]) for name in ("mu_start", "mu_reversal", "v_reversal"))
    assert start == pytest.approx(1.3) and speed == pytest.approx(0.1 * np.log(0.3 / (0.1 * 0.1)))
    assert least == pytest.approx(1 + 0.1 * speed + 0.3 * np.exp(-speed / 0.1))
    form = {"mu_start": start, "mu_reversal": least, "v_reversal": speed, "a4": 0.1}
    system = {"mass": 1, "stiffness": 1, "normal_load": 1, "belt_speed": 0.7}
    for name, value in form.items():
        sides = [] if name == "a4" else ds[f"border_{name}"].values
        for found in sides:
            if np.isfinite(found):
                line = stickslip.border(
                    {"system": system, "friction": form}, name, (float(0.9 * found), float(1.1 * found)), scan=8
                )
                assert np.abs(line["border"].values - found).min() < 1e-7 * found, (name, value)
    assert np.isfinite([ds[f"margin_{name}"] for name in ("mu_start", "v_reversal")]).all()
    assert np.isnan(ds["margin_mu_reversal"])  # undamped, the end of stick-slip does not depend on the drop
    assert re.search(r"simulated: (damped|creep)", words)


def test_what_cannot_change_and_what_lies_further_away_is_told(here):
    words = told("advise", "pair.yaml", *AT[:2], "--at", "belt_speed=0.3", "--parameter", "belt_speed",
                "--parameter", "mu_stop", "--set", "margins.within=1.2")  # fmt: skip
    assert rows(words)["belt_speed"][1] == "none within reach" and rows(words)["mu_stop"][0] == "none"
    assert "cheapest" not in words
    words = told("advise", "pair.yaml", *AT, "--parameter", "mu_start", "--parameter", "a3", code=2)
    assert "expected one form of the curve: mu_start, mu_reversal and v_reversal, or a1, a2 and a3" in words


def test_a_goal_for_a_range_of_speeds_holds_at_all_of_them(here):
    words = told(
        "advise", "pair.yaml", *AT[:2], "--speed-range", "0.4..0.9 m/s", "--parameter", "damping", "-o", "a.nc"
    )
    assert "the worst of 9 from 0.4 to 0.9 m/s counts" in words
    border = float(stickslip.open("a.nc")["border_damping"].sel(side="above").values)
    speeds = np.geomspace(0.4, 0.9, 9)
    for factor, loud in ((0.999, True), (1.001, False)):
        ds = stickslip.evaluate({**CELL, "damping": factor * border, "belt_speed": speeds}, rtol=1e-9)
        assert np.isin(ds["regime"], (1, 4)).any() == loud
    margins = stickslip.margins({**CELL, "belt_speed": 7.0}, ("damping",), speed_range=(0.4, 0.9), joint=False,
                                into=("damped", "creep"))  # fmt: skip
    assert float(margins["border_damping"].sel(side="above")[0]) == pytest.approx(border, rel=1e-8)
    for words, why in (
        (("--speed-range", "0.9..0.4"), "swap the ends"),
        (("--speed-range", "0.4"), "with two dots"),
        (("--speed-range", "0.4..0.9", "--at", "belt_speed=0.5"), "expected one of them"),
        (("--speed-range", "0.4..0.9", "--parameter", "belt_speed"), "what the range of speeds is about"),
        (("--speed-range", "0..0.9"), "expected a speed above 0"),
    ):
        assert why in told("advise", "pair.yaml", *AT[:2], *words, code=2)


def test_border_takes_the_values_of_axes_as_advise_does(here):
    told("border", "pair.yaml", "--along", "belt_speed", "--at", "stiffness=1 N/m", "--at", "damping=0.05 N s/m",
         "-o", "at.nc")  # fmt: skip
    alone = stickslip.border(CELL | {"damping": 0.05}, "belt_speed", (0.3, 1))
    assert float(stickslip.open("at.nc")["border"].max()) == pytest.approx(float(alone["border"].max()), rel=1e-8)
    assert "did you mean stiffness" in told(
        "border", "pair.yaml", "--along", "belt_speed", "--at", "stifness=1", code=2
    )
