"""A few cells of a map computed before all of them."""

import numpy as np
import pytest

import stickslip
from helpers.configs import write_config
from stickslip import engine
from stickslip.config.grid import build_grid
from stickslip.config.reader import load_config
from stickslip.files import writing
from stickslip.runs import estimate as probing
from stickslip.runs.estimate import probe


def grid(folder, num):
    return build_grid(load_config(write_config(folder, num=num)))


def test_a_probe_times_cells_from_all_over_the_map(tmp_path, monkeypatch):
    known, stiffness = [], np.geomspace(0.001, 10, 70)
    compute = probing.compute

    def noted(cells, options):
        known.append(cells[:]["stiffness"])
        return compute(cells, options)

    monkeypatch.setattr(probing, "compute", noted)
    found = probe(grid(tmp_path, 70), engine.Options(threads=1), most=320)
    assert found.cells == 320 == known[0].size and found.threads == 1 and found.seconds_per_cell > 0.0
    assert known[0].min() == stiffness[0] and known[0].max() == stiffness[-1] and np.unique(known[0]).size >= 10


def test_cells_that_run_out_of_steps_are_counted(tmp_path):
    assert probe(grid(tmp_path, 8), engine.Options(max_steps=1)).at_step_limit == 64
    assert probe(grid(tmp_path, 8), engine.Options()).at_step_limit == 0


def test_an_interrupted_probe_is_no_probe(tmp_path, monkeypatch):
    monkeypatch.setattr(probing, "compute", lambda *_: engine.Computed({"regime": np.zeros(9)}, 3))
    with pytest.raises(KeyboardInterrupt):
        probe(grid(tmp_path, 3), engine.Options())


@pytest.mark.parametrize("kind", ["zarr", "nc"])
def test_the_plan_says_how_large_the_file_will_be_and_counts_its_files(tmp_path, monkeypatch, kind):
    """Those that describe variables, fixed parameters and the table of marks among them."""
    monkeypatch.setattr(writing, "_CHUNK_VALUES", 1000)
    config, place = write_config(tmp_path, num=120), tmp_path / f"map.{kind}"
    config.write_text(config.read_text() + f"output: {{file: {place}}}\n")
    planned = probing.estimate(load_config(config)).last_write
    stickslip.run(config, place).close()
    files = [path for path in (place.rglob("*") if kind == "zarr" else [place]) if path.is_file()]
    assert len(files) == planned.files
    assert sum(path.stat().st_size for path in files) == pytest.approx(planned.size, rel=0.5)
