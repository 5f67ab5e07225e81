"""What quantities owe each other: forms of the curve, bounds of friction, what is missing or given twice."""

from helpers.configs import GOOD, message, with_line
from stickslip.config.reader import parse_config


def test_curves_that_strengthen_from_zero_speed_or_weaken_at_speed_are_read():
    text = with_line(9, "  a2: -0.05") + "axes: {a3: {start: -0.4, stop: 0.4, num: 9}}\n"
    config = parse_config(text.replace("  a3: 0.3\n", ""))
    assert config.friction.a2 == -0.05 and config.axes[0].start == -0.4


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
