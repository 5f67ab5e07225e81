"""Axes that become longer: only new cells are computed, and none is lost."""

from decimal import Decimal

import numpy as np
import pytest

import stickslip
from helpers.runs import FEW, MANY, same, stop_early, with_axes
from stickslip.config.grid import build_grid
from stickslip.config.reader import make_config
from stickslip.errors import StoreError
from stickslip.runs.output import as_before, points_of


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_extending_axes_computes_only_the_new_cells(tmp_path, small_blocks, computed, suffix):
    output = tmp_path / f"map{suffix}"
    speeds, more = (f"{{start: 0.0, stop: {stop}, num: {num}}}" for stop, num in ((1, 41), (2, 81)))
    config = with_axes(tmp_path / "a.yaml", FEW, speeds)
    stickslip.run(config, output).close()
    with_axes(config, MANY, more)
    expected = stickslip.run(config)
    del computed[:]
    same(stickslip.run(config, output), expected)
    assert sum(computed) == 7 * 81 - 3 * 41


def _decimal_ranges(seed):
    """Ranges whose ends and steps have few digits, and the same ones lengthened by whole steps at either end."""
    rng = np.random.default_rng(seed)
    step = Decimal(int(rng.integers(1, 40))).scaleb(int(rng.integers(-6, 1)))
    start = step * int(rng.integers(-60, 2000)) + step / 2
    num, before, after = (int(n) for n in (rng.integers(2, 200), rng.integers(0, 30), rng.integers(0, 200)))
    begin, end = start - before * step, start + (num - 1 + after) * step
    old = {"start": float(start), "stop": float(start + (num - 1) * step), "num": num}
    return old, {"start": float(begin), "stop": float(end), "num": before + num + after}, before


def _logarithmic_ranges(seed):
    """So many points a decade, lengthened by decades at either end."""
    rng = np.random.default_rng(seed)
    each, decades, below, above = (int(n) for n in rng.integers([3, 1, 0, 0], [50, 6, 4, 4]))
    start, log = float(f"{rng.integers(1, 90)}e{rng.integers(-9, 3)}"), {"spacing": "log"}
    old = {"start": start, "stop": start * 10.0**decades, "num": each * decades + 1} | log
    whole = decades + below + above
    new = {"start": start / 10.0**below, "stop": start * 10.0 ** (decades + above), "num": each * whole + 1} | log
    return old, new, each * below


def _grid(starts):
    """Cells that differ in where they start, which has no sign."""
    system = {"mass": 1, "normal_load": 1, "stiffness": 1, "belt_speed": 1}
    friction = {"a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1}
    return build_grid(make_config({"system": system, "friction": friction, "axes": {"displacement": starts}}))


@pytest.mark.parametrize("ranges", [_decimal_ranges, _logarithmic_ranges])
def test_points_of_a_lengthened_range_are_those_of_before(ranges):
    """For all of many ranges, to the bit and once each; new points are where the range has them."""
    for seed in range(400):
        before, after, first = ranges(seed)
        old, new = _grid(before), _grid(after)
        (values,) = (c.values for c in old.coords)
        grid = as_before(new, {c.name: c.values for c in old.coords})
        (places,) = points_of(old, grid)
        assert places[first : first + values.size].tolist() == [*range(values.size)], (before, after)
        assert (places >= 0).sum() == values.size
        (points,), (unmoved,) = ([c.values for c in one.coords] for one in (grid, new))
        np.testing.assert_array_equal(points[places >= 0], values)
        np.testing.assert_array_equal(points[places < 0], unmoved[places < 0])
        np.testing.assert_array_equal(grid.along["displacement"][1], points)


@pytest.mark.parametrize("values", [[0.1, 0.1000001, 0.2], [1e-9, 1e-3, 1.0], [1.0, 1.0 + 2**-52, 1.0 + 2**-50]])
def test_what_differs_by_more_than_rounding_is_another_value(values):
    old, new = _grid(values[:1]), _grid(values)
    (places,) = points_of(old, as_before(new, {c.name: c.values for c in old.coords}))
    assert places.tolist() == [0, -1, -1]


def test_cells_of_before_keep_their_values_and_new_ones_are_computed_for_what_the_file_says(tmp_path, computed):
    """Both axes are lengthened, and lengthened again; their steps are rounded in each case."""
    output, old = tmp_path / "map.nc", None
    steps = ((0.142, 138, 0.3, 3), (0.279, 275, 0.5, 5), (0.301, 297, 0.7, 7))
    for stop, num, stiffest, of_stiffness in steps:
        config = with_axes(
            tmp_path / "a.yaml",
            f"{{start: 0.1, stop: {stiffest}, num: {of_stiffness}}}",
            f"{{start: 0.005, stop: {stop}, num: {num}}}",
        )
        del computed[:]
        map_now = stickslip.run(config, output).load()
        assert sum(computed) == map_now["regime"].size - (0 if old is None else old["regime"].size)
        if old is not None:
            part = map_now.isel(
                stiffness=slice(0, old.sizes["stiffness"]), belt_speed=slice(0, old.sizes["belt_speed"])
            )
            same(part.assign_attrs(old.attrs), old)
        old = map_now
    friction = {"a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1}
    again = stickslip.evaluate({"mass": 1, "normal_load": 1, **friction} | dict(old.coords))
    for name in ("regime", "period", "breakaway_time"):
        np.testing.assert_array_equal(old[name].transpose(*again[name].dims), again[name])


def test_an_interrupted_extension_goes_on(tmp_path, small_blocks, computed):
    output = tmp_path / "map.nc"
    config = with_axes(tmp_path / "a.yaml", FEW, [0.1, 0.2, 0.3])
    stickslip.run(config, output).close()
    with_axes(config, [float(k) for k in range(1, 200)], [0.05, 0.1, 0.2, 0.3])
    expected = stickslip.run(config)
    stop_early(config, output, 100)
    del computed[:]
    same(stickslip.run(config, output), expected)
    assert sum(computed) < 199 * 4 - 9 - 64


def test_cells_that_would_be_lost_stop_an_extension(tmp_path, small_blocks):
    output = tmp_path / "map.nc"
    config = with_axes(tmp_path / "a.yaml", FEW, [0.1, 0.2])
    stickslip.run(config, output).close()
    with_axes(config, [1.0, 2.0, 3.0], [0.1, 0.2])
    with pytest.raises(StoreError, match="holds 2 cells that are not part of the new map and would be lost"):
        stickslip.run(config, output)
    with_axes(config, [11.0, 12.0], [0.1, 0.2])
    with pytest.raises(StoreError, match=r"axes.stiffness.values: \[1.0, 2.0, 5.0\] there, \[11.0, 12.0\] here"):
        stickslip.run(config, output)
