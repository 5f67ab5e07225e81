"""Probabilities as a result: through the working store, in files, on screen and drawn."""

import re

import pytest

import stickslip
from helpers.commands import call, told
from helpers.runs import same
from stickslip import plots
from stickslip.errors import ArgumentError, PlotError
from stickslip.runs import work

TEXT = """\
title: A pad whose speed scatters
system: {{mass: 1 kg, normal_load: 1 N{more}}}
friction: {{a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}}
axes: {{{axes}}}
solver: {{max_steps: {steps}}}
uncertain:
  draws: 32
  quantities: {{belt_speed: {{normal: {{mean: 0.78, std: 0.05}}}}, damping: {{uniform: [0, 0.02]}}}}
"""
LINE = "stiffness: {start: 0.1, stop: 10, num: 3, spacing: log}"


def write(folder, axes=LINE, more="", steps=100_000):
    path = folder / "scatter.yaml"
    path.write_text(TEXT.format(axes=axes, more=more, steps=steps))
    return path


@pytest.fixture
def config(tmp_path, monkeypatch):
    monkeypatch.setattr(work, "_FEWEST", 300)
    return write(tmp_path)


def test_draws_of_missing_shards_are_carried_as_bounds(config, tmp_path):
    store, output = tmp_path / "store", tmp_path / "scatter.nc"
    stickslip.run_shard(config, "1/2", store)
    part = stickslip.collect(store, output).load()
    assert "draws are not computed" in part.attrs["incomplete"]
    assert 0.2 < float(part["undecided"].mean()) < 0.8
    part.close()
    stickslip.run_shard(config, "2/2", store)
    whole = stickslip.collect(store, output)
    assert (whole["probability"] >= part["probability_low"] - 1e-12).all()
    assert (whole["probability"] <= part["probability_high"] + 1e-12).all()
    same(whole, stickslip.run(config))


def test_the_command_tells_and_draws(config, tmp_path):
    assert "3,072 draws: stiffness (3) x draw (1024)" in told("validate", config)
    assert "3,072 draws" in told("plan", config)
    output, plot = tmp_path / "scatter.nc", tmp_path / "scatter.png"
    said = told("run", config, "-o", output, "--plot", plot)
    assert re.search(r"^stick_slip +0\.\d+ +0\.\d+ +0\.\d+", said, re.MULTILINE)
    assert "scrambled Sobol points: 8 scramblings of 32 draws, seed 1" in said
    assert plot.stat().st_size > 0
    assert "damped.png" in told("plot", output, "--select", "state=damped", "-o", tmp_path / "damped.png")
    alone = told("run", write(tmp_path, "", ", stiffness: 1"))
    assert re.search(r"^stick_slip +belt_speed +0\.\d+ +0\.\d+$", alone, re.M)
    bounded = told("run", write(tmp_path, "", ", stiffness: 1", 16))
    assert re.search(r"^bounds   .* \d", bounded, re.MULTILINE)


def test_probabilities_are_drawn_as_bars_a_line_or_a_map(tmp_path):
    cell = plots.plot_probability(stickslip.run(write(tmp_path, "", ", stiffness: 1")))
    bars, indices = cell.axes
    assert [text.get_text() for text in bars.get_yticklabels()] == ["stick-slip", "damped"]
    assert [text.get_text() for text in indices.get_yticklabels()] == ["belt speed", "damping"]
    ds = stickslip.run(write(tmp_path))
    upper, lower = plots.plot_probability(ds).axes
    drawn = upper.lines[0].get_ydata()
    assert drawn == pytest.approx(ds["probability"].sel(state="stick_slip").values)
    assert upper.get_xscale() == "log" and "total" in lower.get_ylabel()
    both = stickslip.run(write(tmp_path, f"{LINE}, contact_time: [0, 1]"))
    assert "probability of stick-slip" in plots.plot_probability(both).axes[-1].get_ylabel()
    with pytest.raises(PlotError, match="no probability"):
        plots.plot_probability(ds, "sustaind")


def test_borders_and_margins_are_not_searched_among_uncertain_quantities(config):
    with pytest.raises(ArgumentError, match="uncertain quantities"):
        stickslip.border(config, "stiffness")
    with pytest.raises(ValueError, match="uncertain quantities"):
        stickslip.margins(config, ["stiffness"])
    for words in (["border", "--along", "stiffness"], ["contours", "--over", "stiffness", "belt_speed"]):
        done = call(words[0], config, *words[1:])
        assert done.exit_code == 2 and "uncertain quantities" in done.output
