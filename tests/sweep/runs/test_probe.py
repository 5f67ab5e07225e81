"""A few cells of a map computed before all of them."""

import numpy as np
import pytest

from helpers.configs import write_config
from stickslip import engine
from stickslip.config.grid import build_grid
from stickslip.config.reader import load_config
from stickslip.runs import report, work
from stickslip.runs.report import Estimate, Probe, probe


def grid(folder, num):
    return build_grid(load_config(write_config(folder, num=num)))


def test_a_probe_times_cells_from_all_over_the_map(tmp_path, monkeypatch):
    known, stiffness = [], np.geomspace(0.001, 10, 70)
    compute = report.compute

    def noted(cells, options):
        known.append(cells[:]["stiffness"])
        return compute(cells, options)

    monkeypatch.setattr(report, "compute", noted)
    found = probe(grid(tmp_path, 70), engine.Options(threads=1), most=320)
    assert found.cells == 320 == known[0].size and found.threads == 1 and found.seconds_per_cell > 0.0
    assert known[0].min() == stiffness[0] and known[0].max() == stiffness[-1] and np.unique(known[0]).size >= 10


def test_an_interrupted_probe_is_no_probe(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "compute", lambda *_: engine.Computed({"regime": np.zeros(9)}, 3))
    with pytest.raises(KeyboardInterrupt):
        probe(grid(tmp_path, 3), engine.Options())


def test_a_shard_lasts_as_long_as_its_threads_need_for_their_blocks(monkeypatch):
    monkeypatch.setattr(report, "processors", lambda: 1)
    blocks = work.Blocks(7630, 1, 7630)
    whole = Estimate(None, blocks, Probe(1, 2.0, 1), 1, 7630, 7630, 0, 0, 0, 0, 0, 0.0)
    many = whole.on(nodes=40, threads=64)
    assert (many.shards, many.most, many.seconds) == (40, 191, 3 * 2.0)
