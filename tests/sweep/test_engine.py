"""The seam: units in and out, threads, interruption."""

import threading
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers.data import cases, rows
from stickslip import engine
from stickslip.engine import Options, compute
from stickslip.engine import cells as maps
from stickslip.vocabulary.cells import Cells, as_cells

PAIR = {"mass": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}


def mixed(n=700):
    """Cells of every regime: plain, hysteretic and damped curves, thrown or sticking at the start."""
    random = np.random.default_rng(3)
    stop = np.where(random.random(n) < 0.5, np.nan, random.uniform(0.5, 1.2, n))
    return as_cells(PAIR | {
        "stiffness": np.geomspace(1e-3, 100, n), "belt_speed": random.uniform(-1, 1, n), "mu_stop": stop,
        "damping": random.choice([0.0, 0.1, 3.0], n), "displacement": random.uniform(-0.1, 0.1, n),
        "velocity": np.where(random.random(n) < 0.5, np.nan, random.uniform(-1, 1, n)),
    })  # fmt: skip


def computed(cells, **options):
    return compute(Cells.of(cells), Options(**options)).results


@settings(max_examples=12)
@given(st.integers(1, 4), st.integers(1, 900))
def test_numbers_do_not_depend_on_threads_or_blocks(threads, block):
    cells = mixed()
    alone = computed(cells, threads=1)
    spread = computed(cells, threads=threads, block=block)
    for name, values in alone.items():
        np.testing.assert_array_equal(spread[name], values, err_msg=name)


@pytest.mark.slow
def test_a_cell_does_not_depend_on_the_exponents_of_its_neighbours():
    """Exponents 1 and 2 have kernels of their own."""
    cells = mixed(120) | {"delta": np.resize([2.0, 1.5, 1.0, 2.0, 2.0000001], 120)}
    together = computed(cells, law="stribeck_delta", threads=1)
    for delta in (1.0, 1.5, 2.0):
        here = cells["delta"] == delta
        alone = computed({name: values[here] for name, values in cells.items()}, law="stribeck_delta", threads=1)
        for name, values in alone.items():
            np.testing.assert_array_equal(together[name][here], values, err_msg=f"{name}, delta = {delta}")
    plain = computed({name: values[cells["delta"] == 1.0] for name, values in cells.items()})
    for name, values in plain.items():
        np.testing.assert_array_equal(together[name][cells["delta"] == 1.0], values, err_msg=name)


DIMENSIONS = rows("sweep.yaml")["test_engine"]["DIMENSIONS"]  # powers of mass, length and time
scales = st.floats(-9.0, 9.0).map(lambda x: 10.0**x)


@settings(max_examples=25)
@given(scales, scales, scales)
def test_numbers_do_not_depend_on_the_units_of_mass_length_and_time(mass, length, time_unit):
    def factor(name):
        powers = DIMENSIONS.get(name, (0, 0, 0))
        return mass ** powers[0] * length ** powers[1] * time_unit ** powers[2]

    cells = mixed(150)
    here = computed(cells)
    there = computed({name: values * factor(name) for name, values in cells.items()})
    forces = ("spring_force_max", "spring_force_min", "cycle_force_max", "cycle_force_min")
    for name, values in here.items():
        if name in ("regime", "status", "equilibrium_crossings"):
            np.testing.assert_array_equal(there[name], values, err_msg=name)
        elif name not in ("steps", *forces):
            np.testing.assert_allclose(there[name], values * factor(name), rtol=1e-9, err_msg=name)
    force = here["spring_force_max"] - here["spring_force_min"]
    for name in forces:
        off = np.abs(there[name] / factor(name) - here[name])
        assert (np.isnan(off) | (off < 1e-9 * force + 1e-12)).all(), name


def test_an_interruption_keeps_what_is_finished_and_stops_at_once():
    """The progress callback stands for the keyboard: both raise in the thread that waits."""
    size = 400_000
    cells = as_cells(PAIR | {"stiffness": np.geomspace(0.001, 100, size), "belt_speed": 0.5})

    def interrupt(done, of):
        if done:
            raise KeyboardInterrupt

    stopped = compute(Cells.of(cells), Options(block=1000), interrupt)
    assert 1000 <= stopped.done < size and not stopped.complete
    regime = stopped.results["regime"]
    assert np.count_nonzero(regime) == stopped.done
    np.testing.assert_array_equal(np.isnan(stopped.results["breakaway_time"]), regime == 0)
    few = np.flatnonzero(regime)[:50]
    again = computed({name: values[few] for name, values in cells.items()})
    np.testing.assert_array_equal(again["period"], stopped.results["period"][few])


def test_a_kernel_under_way_leaves_within_a_moment_of_being_told(kernels):
    """One cell that would go on for minutes: undamped flat friction to a far horizon."""
    cell = as_cells({"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "belt_speed": 1.0, "a1": 0.5, "a2": 0.0,
                     "a3": 0.0, "a4": 1.0, "velocity": 0.5})  # fmt: skip
    stop = np.zeros(1, np.int64)
    options = Options(horizon=1e9, early_stop=False, max_steps=2 * 10**9)
    rows = []
    worker = threading.Thread(target=lambda: rows.append(maps._run_block(cell, options, stop)))
    worker.start()
    time.sleep(0.2)
    assert worker.is_alive()
    stop[0] = 1
    worker.join(timeout=5.0)
    assert not worker.is_alive()
    assert rows[0][1] == 0


def test_an_error_in_a_block_comes_out_as_it_is():
    class Broken(Cells):
        def __getitem__(self, part):
            raise ZeroDivisionError("a bug")

    with pytest.raises(ZeroDivisionError, match="a bug"):
        compute(Broken.of(mixed(10)), Options())


def test_progress_ends_with_all_cells():
    seen = []
    cells = mixed()
    compute(Cells.of(cells), Options(block=100), lambda done, of: seen.append((done, of)))
    assert seen[-1] == (700, 700)
    assert seen == sorted(seen)


def test_no_cells_are_computed_at_once():
    none = {name: values[:0] for name, values in mixed(1).items()}
    done = compute(Cells.of(none), Options())
    assert done.complete and done.done == 0


@cases("sweep.yaml")
def test_options_out_of_range_are_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        Options(**wrong)


@given(st.integers(0, 30_000), st.integers(1, 5), st.integers(1, 5000))
def test_blocks_hold_every_cell_once_and_in_order(size, threads, block):
    parts = list(engine.blocks(size, Options(threads=threads, block=block)))
    assert [n for part in parts for n in part] == list(range(size))
    assert all(0 < len(part) <= block for part in parts)
