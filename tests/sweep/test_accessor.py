"""`ds.stickslip`, and what a notebook shows."""

import subprocess
import sys
import tomllib
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import stickslip
from helpers.data import cases
from helpers.nightly import few
from helpers.plotted import draws_what_the_command_draws
from stickslip import plots
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError, PlotError
from stickslip.vocabulary.quantities import REGIMES

ROOT = Path(__file__).parents[2]
FRICTION = {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
PAIR = FRICTION | {"mass": 1.0, "normal_load": 1.0, "stiffness": 10.0, "belt_speed": 0.1}


@pytest.fixture(scope="module")
def ds():
    group = xr.Dataset({"damping": ("grease", [0.01, 0.2])}, {"grease": ["A", "B"]})
    axes = {"grease": group, "mu_stop": ["none", 1.2], "belt_speed": np.linspace(0.01, 1.0, 5)}
    system = {"mass": 1, "normal_load": 1, "stiffness": 10}
    return stickslip.sweep(system=system, friction=FRICTION, axes=axes, title="two greases")


# --- the accessor -----------------------------------------------------------------------------------------------------


def test_a_cell_is_found_by_values_labels_and_what_was_selected_before(ds):
    cell = ds.stickslip.cell(grease="B", mu_stop=1.2, belt_speed="20 mm/s")
    assert (cell["damping"], cell["mu_stop"], cell["belt_speed"], cell["mass"]) == (0.2, 1.2, 0.02, 1.0)
    part = ds.sel(grease="A", mu_stop_case="none").isel(belt_speed=2)
    np.testing.assert_equal(part.stickslip.cell(), stickslip.evaluate(part).stickslip.cell())
    assert np.isnan(part.stickslip.cell()["mu_stop"]) and np.isnan(ds.stickslip.cell(
        grease="A", mu_stop="none", belt_speed=ds["belt_speed"][1])["mu_stop"])  # fmt: skip
    for name in ("belt_speed", "damping"):
        assert part.stickslip.cell()[name] == part[name]
    for i, position in enumerate(np.ndindex(ds["regime"].shape)):
        one = ds.isel(dict(zip(ds["regime"].dims, position, strict=True)))
        assert stickslip.evaluate(one.stickslip.cell())["regime"] == one["regime"], i


@cases("sweep.yaml")
def test_a_cell_that_is_not_there_is_refused_with_what_is(ds, at, message):
    with pytest.raises(ValueError, match=message):
        ds.stickslip.cell(**at)


def test_a_cell_is_simulated_as_it_was_computed():
    law = stickslip.sweep(system={"mass": 1, "normal_load": 1, "stiffness": 1}, axes={"belt_speed": [0.1, 0.2]},
                          friction=FRICTION | {"law": "stribeck_delta"}, solver={"rtol": 1e-9})  # fmt: skip
    motion = law.stickslip.simulate("20 s", samples=101, belt_speed=0.1)
    cell = law.stickslip.cell(belt_speed=0.1)
    same = stickslip.simulate(duration=20, samples=101, law="stribeck_delta", rtol=1e-9, **cell)
    xr.testing.assert_equal(motion, same)
    cells = stickslip.evaluate(PAIR | {"stiffness": [1.0, 10.0]})
    some = cells.stickslip.simulate(cell=1)
    period = float(cells["period"][1])
    assert 3 * period < float(some["time"][-1]) < 20 * period, "some cycles, unless a duration is given"


def test_the_configuration_computes_the_result_again(ds):
    again = stickslip.run(ds.stickslip.configuration)
    xr.testing.assert_equal(again, ds)
    with pytest.raises(ConfigError):
        stickslip.evaluate(PAIR).stickslip.configuration  # noqa: B018


def test_the_summary_counts_what_is_there(ds):
    table = ds.stickslip.summary()
    assert table["cells"].sum() == ds["regime"].size and table["share"].sum() == pytest.approx(1.0)
    for name, cells in table["cells"].items():
        assert cells == (ds["regime"] == REGIMES.index(name)).sum()
    part = ds.where(ds["belt_speed"] > 0.5)
    assert part.stickslip.summary()["cells"].sum() == part["regime"].notnull().sum()
    with pytest.raises(ValueError, match="no regimes"):
        stickslip.simulate(duration=1.0, **PAIR).stickslip.summary()
    assert "two greases" in repr(ds.stickslip)


def test_cells_are_masked_by_the_names_of_flags(ds):
    sticks = ds.stickslip.mask("stick_slip")
    np.testing.assert_array_equal(sticks, ds["regime"] == REGIMES.index("stick_slip"))
    both = ds.stickslip.mask("stick_slip", "damped")
    np.testing.assert_array_equal(both, ds["regime"].isin([1, 2]))
    assert ds["period"].where(sticks).notnull().equals(sticks.drop_attrs()), "cycles have periods"
    np.testing.assert_array_equal(ds.stickslip.mask("settled", flag="status"), ~sticks)
    with pytest.raises(ValueError, match="regime has no squeaks, expected not_computed, stick_slip, .* or failed"):
        ds.stickslip.mask("squeaks")


CELL = {name: value for name, value in PAIR.items() if name != "belt_speed"}
BOX = {"displacement": (0.0, 1.5), "velocity": (-0.5, 0.5)}
SPEEDS = np.linspace(0.1, 1.0, 4)
CONFIG = """
title: small
system: {mass: 1, normal_load: 1 N, damping: 0, belt_speed: 0.5 m/s}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 100 mm/s}
axes: {stiffness: {start: 0.1, stop: 100, num: 4, spacing: log}}
"""
PLANE = CONFIG.replace(", belt_speed: 0.5 m/s", "").replace(
    "axes: {", "axes: {belt_speed: {start: 20 mm/s, stop: 1 m/s, num: 5}, "
)
SCATTER = "uncertain: {quantities: {belt_speed: {uniform: {low: 0.2, high: 1}}}, draws: 64}"
KINDS = {
    "map": lambda: stickslip.run(parse_config(PLANE)),
    "borders": lambda: stickslip.run(parse_config(CONFIG + "border: {along: belt_speed, between: [0.05, 2]}")),
    "contours": lambda: stickslip.run(parse_config(PLANE + "contours: {points: 8, scan: 8}")),
    "margins": lambda: stickslip.run(parse_config(PLANE + "margins: {parameters: [stiffness]}")),
    "refined": lambda: stickslip.run(parse_config(PLANE + "refine: {depth: 1}")),
    "attractors": lambda: stickslip.attractors(PAIR | {"belt_speed": SPEEDS}, BOX, samples=64),
    "probability": lambda: stickslip.run(parse_config(CONFIG.replace(", belt_speed: 0.5 m/s", "") + SCATTER)),
    "ramp": lambda: stickslip.ramp(CELL, "belt_speed", (0.1, 1.0), 4),
    "trajectory": lambda: stickslip.simulate(duration=10.0, **PAIR),
    "cells": lambda: stickslip.evaluate(PAIR | {"stiffness": [1.0, 10.0]}),
}


@pytest.mark.parametrize("kind", few(KINDS, 2))
def test_the_accessor_draws_what_the_command_draws(kind, tmp_path):
    expected = {"borders": "border", "probability": "uncertain"} | dict.fromkeys(("refined", "cells"), "map")
    assert draws_what_the_command_draws(KINDS[kind](), tmp_path) == expected.get(kind, kind)


def test_what_has_no_plot_is_refused_with_the_reason(ds):
    with pytest.raises(PlotError, match="no variable 'perid'"):
        ds.stickslip.plot("perid")
    borders = stickslip.border(CELL, "belt_speed", (0.05, 2.0))
    with pytest.raises(PlotError, match="single lines"):
        borders.stickslip.plot()
    contours = stickslip.run(parse_config(PLANE + "contours: {points: 8, scan: 8}"))
    with pytest.raises(PlotError, match="over a map, which is missing"):
        plots.plot_result(contours)
    with pytest.raises(PlotError, match="scales, limits and marks are for maps"):
        plots.plot_result(KINDS["trajectory"](), look=plots.Look(log=frozenset({"time"})))


# --- where it comes from ----------------------------------------------------------------------------------------------


def python(code, *paths):
    lines = "\n".join(code)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", lines], capture_output=True, text=True, cwd=ROOT,
        env={"PYTHONPATH": ":".join([str(ROOT / "sweep"), str(ROOT / "kernels"), *map(str, paths)]), "PATH": ""},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.fixture(scope="module")
def entry(tmp_path_factory):
    """A folder whose packages have the entry point of our pyproject, unless ours is installed with it."""
    folder = tmp_path_factory.mktemp("site")
    named = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    ((name, target),) = named["xarray.backends"].items()
    if not [point for point in entry_points(group="xarray.backends") if point.name == name]:
        info = folder / "stickslip_door-1.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: stickslip-door\nVersion: 1\n")
        (info / "entry_points.txt").write_text(f"[xarray.backends]\n{name} = {target}\n")
    return folder


@pytest.mark.skipif(sys.platform == "win32", reason="paths are joined by a colon")
def test_the_accessor_is_there_where_xarray_alone_is_imported(entry, ds, tmp_path):
    ds.to_netcdf(tmp_path / "map.nc")
    stickslip.sweep(system={"mass": 1, "normal_load": 1, "stiffness": 10}, friction=FRICTION,
                    axes={"belt_speed": [0.1, 0.2]}, output=tmp_path / "own.nc").close()  # fmt: skip
    said = python([
        "import xarray as xr", f"ds = xr.open_dataset({str(tmp_path / 'map.nc')!r})",
        "print(int(ds.stickslip.summary().cells.sum()))",
        f"own = xr.open_dataset({str(tmp_path / 'own.nc')!r}, engine='stickslip')", "print(own.sizes['belt_speed'])",
        "print(own.stickslip.configuration.friction.a1)",
    ], entry)  # fmt: skip
    assert said == [str(ds["regime"].size), "2", "1.0"]


# --- what is wrong, in a notebook -------------------------------------------------------------------------------------


def test_words_that_are_nearly_right_are_recognised():
    with pytest.raises(TypeError, match=r"sweep\(\) got an unexpected keyword argument 'axis'; did you mean axes\?"):
        stickslip.sweep(system={"mass": 1}, axis={})
    found = stickslip.evaluate({"mass": 1, "stiffness": 1, "normal_load": 1, "belt_speed": 0.1, **FRICTION})
    with pytest.raises(ValueError, match=r"did you mean stick_slip\?"):
        found.stickslip.mask("stickslip")
