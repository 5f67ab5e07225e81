"""What quantities owe each other: forms of the curve, bounds of friction, what is missing or given twice."""

import pytest

from helpers.configs import GOOD, MEASURED_FORM, message, with_line
from stickslip.config.reader import parse_config


def test_curves_that_strengthen_from_zero_speed_or_weaken_at_speed_are_read():
    text = with_line(9, "  a2: -0.05") + "axes: {a3: {start: -0.4, stop: 0.4, num: 9}}\n"
    config = parse_config(text.replace("  a3: 0.3\n", ""))
    assert config.friction.a2 == -0.05 and config.axes[0].start == -0.4


BAD = {
    "an exponent the law has not": (
        with_line(7, "friction:", "  law: rational", "  delta: 2"),
        "map.yaml:9:3: friction.delta: got delta with the law rational, expected none: "
        "it is for the law stribeck_delta",
    ),
    "a measured curve of another law": (
        GOOD.partition("friction")[0]
        + "friction: {law: cubic, mu_start: 1, mu_reversal: 0.8, v_reversal: 0.1, a4: 0.1}\n",
        "map.yaml:7:24: friction.mu_start: got mu_start with the law cubic, "
        "expected a1, a2, a3 and a4: it is for the law stribeck\n"
        "map.yaml:7:37: friction.mu_reversal: got mu_reversal with the law cubic, "
        "expected a1, a2, a3 and a4: it is for the law stribeck\n"
        "map.yaml:7:55: friction.v_reversal: got v_reversal with the law cubic, "
        "expected a1, a2, a3 and a4: it is for the law stribeck",
    ),
    "a missing quantity": (
        with_line(4),
        "map.yaml:2:1: system.stiffness: missing, "
        "expected the spring stiffness: a stiffness such as '5 N/mm' or a number in N/m\n"
        "  hint: or vary it: axes: {stiffness: ...}",
    ),
    "a missing curve": (
        "".join(GOOD.splitlines(keepends=True)[:6]),
        "map.yaml:1:1: friction: the friction curve is missing, "
        "expected a1, a2, a3, a4, or mu_start, mu_reversal, v_reversal, a4\n  hint: `stickslip help model`",
    ),
    "half a curve": (
        with_line(9),
        "map.yaml:7:1: friction.a2: missing, expected the slope a2 of the rising branch of the Stribeck curve: "
        "a slope over speed such as '0.1 s/m' or a number in s/m\n  hint: or vary it: axes: {a2: ...}",
    ),
    "two forms of the curve": (
        GOOD + "axes: {mu_start: [1, 2]}\n",
        "map.yaml:8:3: friction.a1: got a1 besides mu_start on line 12, expected one form of the curve\n"
        "  hint: the forms are a1, a2, a3, a4, or mu_start, mu_reversal, v_reversal, a4\n"
        "map.yaml:9:3: friction.a2: got a2 besides mu_start on line 12, expected one form of the curve\n"
        "  hint: the forms are a1, a2, a3, a4, or mu_start, mu_reversal, v_reversal, a4\n"
        "map.yaml:10:3: friction.a3: got a3 besides mu_start on line 12, expected one form of the curve\n"
        "  hint: the forms are a1, a2, a3, a4, or mu_start, mu_reversal, v_reversal, a4",
    ),
    "fixed and varied": (
        GOOD + "axes: {mass: [1, 2]}\n",
        "map.yaml:12:8: axes.mass: given twice, as system.mass on line 3 already, expected once\n"
        "  hint: keep the one you mean",
    ),
    "varied twice": (
        with_line(3, text=GOOD) + "axes:\n  mass: [1, 2]\n  both: {zip: {mass: [1, 2]}}\n",
        "map.yaml:13:16: axes.both.zip.mass: given twice, as axes.mass on line 12 already, expected once\n"
        "  hint: keep the one you mean",
    ),
    "too many cells": (
        with_line(3, text=with_line(6, "axes:", "  mass: {start: 1, stop: 2, num: 1000000}",
                                    "  belt_speed: {start: 1, stop: 2, num: 100000}")),
        "map.yaml:6:3: axes: got 1e+11 cells (1000000 x 100000), expected at most 1e+10\n"
        "  hint: use fewer points, or fewer axes",
    ),
    "mu_stop above mu_start": (
        GOOD + "  mu_stop: 1.4\n",
        "map.yaml:12:12: friction.mu_stop: got 1.4, expected at most mu_start = a1 + a3 = 1.3\n"
        "  hint: friction at standstill cannot exceed that at break-away",
    ),
    "mu_stop above mu_start in a corner of the grid": (
        with_line(8, text=GOOD) + "axes: {mu_stop: [none, 0.7, 1.2], a1: {start: 0.8, stop: 1, num: 1000000}}\n",
        "map.yaml:11:29: axes.mu_stop[2]: got 1.2, expected at most mu_start = a1 + a3 = 1.1\n"
        "  hint: friction at standstill cannot exceed that at break-away",
    ),
    "static friction below zero": (
        with_line(10, "  a3: -1.5") + "  mu_stop: 0.2\n",
        "map.yaml:10:7: friction.a3: got -1.5, expected at least -a1 = -1\n"
        "  hint: the curve starts at mu_start = a1 + a3, which is the static friction",
    ),
    "static friction below zero in a corner of the grid": (
        with_line(8, text=with_line(10)) + "axes: {a1: [0.2, 0.7], a3: {start: -0.5, stop: 0.1, num: 9}}\n",
        "map.yaml:10:36: axes.a3.start: got -0.5, expected at least -a1 = -0.2\n"
        "  hint: the curve starts at mu_start = a1 + a3, which is the static friction",
    ),
    "mu_static below mu_start": (
        MEASURED_FORM + "  mu_static: 0.39\n",
        "map.yaml:12:14: friction.mu_static: got 0.39, expected at least mu_start = 0.4\n"
        "  hint: static friction is at least that of the curve; leave mu_static out for mu_start",
    ),
    "a minimum above the start": (
        with_line(9, "  mu_reversal: 0.5", text=MEASURED_FORM),
        "map.yaml:9:16: friction.mu_reversal: got 0.5, expected less than mu_start = 0.4\n"
        "  hint: a curve without a minimum is given by a1, a2, a3 and a4, with a3: 0",
    ),
    "a minimum at rest": (
        with_line(10, "  v_reversal: 0 m/s", text=MEASURED_FORM),
        "map.yaml:10:15: friction.v_reversal: got '0 m/s', expected a speed above 0 m/s",
    ),
    "a curve that would have to start below zero": (
        with_line(10, "  v_reversal: 0.02", text=MEASURED_FORM),
        "map.yaml:10:15: friction.v_reversal: got 0.02, expected more: "
        "with mu_start = 0.4, mu_reversal = 0.3, a4 = 0.05 it makes a1 = -1.22, which is below 0\n"
        "  hint: raise v_reversal or lower a4",
    ),
    "to the end of no horizon": (
        GOOD + "solver: {early_stop: false}\n",
        "map.yaml:12:22: solver.early_stop: got false, expected true, because no horizon is given\n"
        "  hint: add a horizon such as '100 s' to solver",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_broken_rule_is_explained(name):
    text, expected = BAD[name]
    assert message(text) == expected


def test_the_worst_point_of_a_group_is_found_jointly():
    """mu_stop 1.2 stands beside a1 = 1: only point by point is there nothing wrong."""
    group = "axes: {oil: {zip: {mu_stop: [0.7, 1.2, none], a1: [0.5, 1, 0.1]}}}\n"
    assert parse_config(with_line(8, text=GOOD) + group).axes[0].size == 3
    swapped = group.replace("[0.5, 1, 0.1]", "[1, 0.5, 0.1]")
    assert "axes.oil.zip.mu_stop[1]: got 1.2, expected at most mu_start = a1 + a3 = 0.8" in message(
        with_line(8, text=GOOD) + swapped
    )


def test_rounding_is_no_reason_to_refuse():
    """0.1 + 0.2 is above 0.3."""
    text = with_line(8, "  a1: 0.1", text=with_line(10, "  a3: 0.2", text=GOOD))
    assert parse_config(text + "  mu_static: 0.3\n").friction.mu_static == 0.3
    assert parse_config(text + "  mu_stop: 0.3\n").friction.mu_stop == 0.3
