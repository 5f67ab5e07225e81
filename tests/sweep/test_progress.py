"""How far a computation is moves inside its items, in every study and on every way to it."""

import io

import numpy as np
import pytest
from rich.console import Console

import stickslip
from helpers.commands import call
from stickslip import progress
from stickslip.engine import Options, cells, compute_range, stop_flag
from stickslip.progress import Bar
from stickslip.runs.threads import Meter
from stickslip.vocabulary.cells import Cells

CELL = {"mass": 1.0, "stiffness": 100.0, "damping": 0.5, "normal_load": 10.0, "belt_speed": 0.1,
        "a1": 0.2, "a2": 0.0, "a3": 0.2, "a4": 0.1}  # fmt: skip
BOX = {"displacement": (-0.2, 0.2), "velocity": (-1.0, 1.0)}


@pytest.mark.parametrize(
    "compute",
    [
        lambda moved: stickslip.contours(CELL, ("stiffness", "belt_speed"), {"stiffness": (50, 200),
                                          "belt_speed": (0.01, 1)}, points=64, scan=16, progress=moved),
        lambda moved: stickslip.margins(CELL, progress=moved),
        lambda moved: stickslip.border(CELL, "belt_speed", (0.01, 1), progress=moved),
        lambda moved: stickslip.attractors(CELL, BOX, samples=64, progress=moved),
    ],
    ids=["contours", "margins", "border", "attractors"],
)  # fmt: skip
def test_progress_rises_to_all_items(compute):
    moves = []
    compute(lambda done, total: moves.append((done, total)))
    assert moves[-1] == (1, 1)
    assert (np.diff([done for done, _ in moves]) >= 0).all() and moves[0][0] < 1 or len(moves) == 1


def test_items_under_way_count_by_their_cells_and_never_as_all():
    meter = Meter(cells_each=100, done=3)
    moved = meter.watch(0, items=2)
    shares = []
    for _ in range(20):
        moved(20)
        shares.append(meter.items)
    assert shares[:8] == pytest.approx(3 + 2 * np.arange(1, 9) / 10)  # as expected, while that is sure
    assert (np.diff(shares) >= 0).all() and shares[-1] < 5
    meter.end(0, 2)
    assert meter.items == 5
    meter.watch(1, items=4)(100)
    meter.end(1, 0)  # it failed
    assert meter.items == 5


def test_cells_that_take_long_are_told_of_every_second_and_keep_their_numbers(monkeypatch):
    some = {name: np.full(1000, values[0]) for name, values in stickslip.vocabulary.cells.as_cells(CELL).items()}
    some = Cells.of(some)
    whole = compute_range(some, 0, 1000, Options(early_stop=True), stop_flag())
    seen, clock = [], iter(np.arange(0.0, 1e5, 16.0))  # every part takes 16 s
    monkeypatch.setattr(cells, "perf_counter", lambda: next(clock))
    parts = compute_range(some, 0, 1000, Options(early_stop=True), stop_flag(), seen.append, often=True)
    assert seen[0] == 512 and seen[1] == 64 and sum(seen) == 1000
    for name, values in whole.items():
        np.testing.assert_array_equal(values, parts[name])


def test_a_bar_shows_the_part_of_a_single_item_and_the_time_left():
    console = Console(file=io.StringIO(), force_terminal=True, width=100)
    bar = Bar(console, "panels")
    for done in (0.0, 0.2, 0.4):
        bar.move(done, 1)
    bar.end()
    shown = console.file.getvalue()
    assert "40.0 %" in shown and "0 of 1 panels" in shown


def test_progress_that_is_asked_for_is_lines_in_a_file(capsys, monkeypatch):
    """A bar is drawn over and over, and by Rich not at all where there is no terminal."""
    monkeypatch.setattr(progress, "EVERY", 0.0)
    stickslip.ramp(CELL, "belt_speed", (0.01, 1.0), points=20, progress=True)
    shown = capsys.readouterr().err.splitlines()
    assert len(shown) >= 2 and shown[0].split() == "0.0 % 0 of 1 lines".split() and "1 of 1 lines" in shown[-1]


def test_advise_says_how_far_it_is(monkeypatch):
    monkeypatch.setattr(progress, "EVERY", 0.0)
    done = call("advise", "quickstart", "--at", "stiffness=50 N/m", "--at", "belt_speed=500 mm/s")
    assert done.exit_code == 0 and "1 of 1 cells searched" in done.stderr
