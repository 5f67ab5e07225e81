"""Axes that become longer: only new cells are computed, and none is lost."""

import numpy as np
import pytest

import stickslip
from helpers.runs import FEW, MANY, same, stop_early, with_axes
from stickslip.errors import StoreError


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_extending_axes_computes_only_the_new_cells(tmp_path, small_blocks, computed, suffix):
    if suffix == ".zarr":
        pytest.importorskip("zarr")
    output = tmp_path / f"map{suffix}"
    speeds, more = (f"{{start: 0.0, stop: {stop}, num: {num}}}" for stop, num in ((1, 41), (2, 81)))
    config = with_axes(tmp_path / "a.yaml", FEW, speeds)
    stickslip.run(config, output).close()
    with_axes(config, MANY, more)
    expected = stickslip.run(config)
    shared = np.isin(expected["belt_speed"], np.linspace(0, 1, 41)).sum()
    del computed[:]
    same(stickslip.run(config, output), expected)
    assert sum(computed) == 7 * 81 - 3 * shared and shared >= 40


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
