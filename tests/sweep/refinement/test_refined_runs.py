"""Refined maps through runs: the cells of the full map, the same store, the same files."""

import re

import numpy as np
import pytest

import stickslip
from helpers.commands import told
from helpers.refined_maps import CURVES, compared, map_config
from helpers.runs import block_files, opened, same
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError, StoreError
from stickslip.runs import work
from stickslip.studies import refine

PLANE = """\
system: {mass: 1, normal_load: 1}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes:
  stiffness: {start: 0.1, stop: 100, num: 150, spacing: log}
  belt_speed: {start: 0.05, stop: 1.2, num: 201}
"""
REFINED = PLANE + "refine: {depth: 3, audit: 0.5}\n"


def plain(text: str):
    return stickslip.run(parse_config(re.sub(r"^refine:.*$", "", text, flags=re.MULTILINE)))


def assert_refines(found, whole):
    """Computed cells are those of the full map, bit for bit; inferred ones have its regime and nothing else."""
    computed = found["computed"].values == 1
    for name in whole.data_vars:
        assert np.array_equal(found[name].values[computed], whole[name].values[computed], equal_nan=True)
        assert (found[name].attrs["units"], found[name].dtype) == (whole[name].attrs["units"], whole[name].dtype)
    np.testing.assert_array_equal(found["regime"], whole["regime"])
    assert np.isnan(found["spring_force_max"].values[~computed]).all()
    assert (found["status"].values[~computed] == 0).all()


@pytest.fixture(scope="module")
def whole():
    return plain(REFINED)


@pytest.fixture(scope="module")
def refined():
    return stickslip.run(parse_config(REFINED))


def test_a_refined_map_has_the_regimes_of_the_full_one_and_the_numbers_of_its_computed_cells(refined, whole):
    assert_refines(refined, whole)
    assert refined["computed"].mean() < 0.2
    assert refined["computed"].attrs["flag_meanings"] == "inferred computed"


def test_the_audit_is_in_the_attributes(refined):
    attributes = refined.attrs
    inferred = int((refined["computed"] == 0).sum())
    assert attributes["refine_cells_computed"] == refined["computed"].sum()  # one tile: none is looked at twice
    assert 0.3 * 988 < attributes["audit_points"] < 0.6 * 988  # 20 x 26 corners, 19 x 25 centres; some are computed
    assert attributes["audit_wrong"] == 0
    exact = (1 - 0.05 ** (1 / attributes["audit_points"])) * (inferred + attributes["audit_points"]) / 30150
    assert attributes["audit_bound"] == pytest.approx(exact, rel=1e-2)  # points may fall on one cell twice


def test_without_an_audit_nothing_is_claimed():
    found = stickslip.run(parse_config(PLANE + "refine: {depth: 3, audit: 0}"))
    assert found.attrs["audit_bound"] == (found["computed"] == 0).mean()


SHORT = PLANE.replace("num: 150", "num: 6")
SPACE = (
    PLANE.replace("num: 150", "num: 40").replace("num: 201", "num: 45") + "  damping: {start: 0, stop: 1, num: 30}\n"
)


@pytest.mark.parametrize(
    "text",
    [
        PLANE.replace("  stiffness: {start: 0.1, stop: 100, num: 150, spacing: log}\n", "").replace(
            "mass: 1,", "mass: 1, stiffness: 1,"
        ),
        SHORT,
        SPACE,
        PLANE.replace("num: 150", "num: 50") + "  mu_stop: [none, 1.1, 0.9]\n",
        PLANE.replace("num: 150", "num: 40") + "  curve: {zip: {damping: [0, 0.2], mass: [1, 2]}, labels: [a, b]}\n",
    ],
    ids=["one dimension", "a short range", "three dimensions", "a list", "a group"],
)
def test_any_number_of_axes_of_any_kind_is_refined(text):
    text = text.replace("mass: 1,", "") if "zip" in text else text
    found = stickslip.run(parse_config(text + "refine: {depth: 3}"))
    assert_refines(found, plain(text))
    assert found["computed"].mean() < 0.7


@pytest.mark.slow
def test_the_numbers_do_not_depend_on_where_and_when_tiles_are_computed(tmp_path, monkeypatch):
    """Many small tiles; blocks in a store, in shards, in memory; written at once and region by region."""
    monkeypatch.setattr(refine, "_TILE", 8)  # 16 x 16 cells a tile
    monkeypatch.setattr(work, "_FEWEST", 1)  # and each a block
    monkeypatch.setattr(work, "_BLOCKS", 10**9)
    config = tmp_path / "map.yaml"
    config.write_text(REFINED)
    memory = stickslip.run(parse_config(REFINED))
    assert memory.attrs["refine_cells_computed"] > memory["computed"].sum()
    for number in (1, 2, 3):
        stickslip.run_shard(config, f"{number}/3", tmp_path / "store")
    assert len(block_files(tmp_path / "store")) == 130
    same(stickslip.collect(tmp_path / "store", tmp_path / "map.zarr"), memory)
    same(stickslip.run(config, tmp_path / "map.nc"), memory)
    assert opened(tmp_path / "map.nc").attrs["audit_bound"] == memory.attrs["audit_bound"]


def test_a_map_and_its_refinement_do_not_overwrite_each_other(tmp_path):
    stickslip.run(parse_config(REFINED), tmp_path / "map.nc").close()
    with pytest.raises(StoreError, match="refine.depth"):
        stickslip.run(parse_config(PLANE), tmp_path / "map.nc")
    with pytest.raises(StoreError, match=r"refine.depth: 3 there, 4 here"):
        stickslip.run(parse_config(REFINED.replace("depth: 3", "depth: 4")), tmp_path / "map.nc")


LISTS = PLANE[: PLANE.index("axes")] + "axes: {stiffness: [1, 2, 3], belt_speed: [0.1, 0.2]}\n"
WIDE = SPACE.replace("num: 30", "num: 200").replace("num: 4", "num: 20")


@pytest.mark.parametrize(("text", "section", "message"), [
    (PLANE, "refine: {depth: -1}", "my.yaml:6:17: refine.depth: got -1, expected a whole number from 0 to 18"),
    (PLANE, "refine: {depth: 8}", "my.yaml:6:17: refine.depth: got 8, expected at most 7"),
    (PLANE, "refine: {audit: -0.1}", "my.yaml:6:17: refine.audit: got -0.1, expected "),
    (PLANE, "refine: {deep: 3}", "my.yaml:6:10: refine.deep: unknown key, expected depth or audit"),
    (PLANE, "refine: 3", "my.yaml:6:9: refine: got 3, expected"),
    (PLANE, "refine: {}\nborder: {along: mass, between: [1, 2]}", "got border besides refine on line 6"),
    (LISTS, "refine: {depth: 1}", "my.yaml:4:1: refine: got no range among the axes, expected an axis with "),
    (WIDE, "refine: {depth: 7}", "refine.depth: got 7, expected at most 6\n"),
    (PLANE.replace("num: 150", "num: 5").replace("num: 201", "num: 5"), "refine: {audit: 1}",
     "refine.depth: got its default, expected at most 2"),
])  # fmt: skip
def test_bad_sections_are_refused_with_file_line_and_key(text, section, message):
    with pytest.raises(ConfigError) as caught:
        parse_config(text + section, "my.yaml")
    assert message in str(caught.value)


def test_the_commands_tell_what_is_computed_and_what_the_audit_says(tmp_path):
    config = tmp_path / "map.yaml"
    config.write_text(REFINED)

    assert "30,150 cells: stiffness (150) x belt_speed (201), refined in 1 tile" in told("validate", config)
    planned = told("plan", config)
    assert re.search(r"^cells    about [\d,]{5} are computed", planned, re.MULTILINE)
    said = told("run", config, "-o", tmp_path / "map.nc", "--plot", tmp_path / "map.png")
    assert re.search(r"^refined  [\d,]{5} cells computed for 30,150$", said, re.MULTILINE)
    assert re.search(r"^audit    \d+ random points among the inferred cells, 0 of them wrong", said, re.MULTILINE)
    assert (tmp_path / "map.png").stat().st_size > 0
    told("plot", tmp_path / "map.nc", "--variable", "computed", "-o", tmp_path / "computed.png")


@pytest.mark.slow
@pytest.mark.parametrize("curve", CURVES)
def test_the_article_maps_at_4096_x_4096_take_a_hundredth_of_the_cells(curve):
    found = compared(map_config(4096, CURVES[curve]))
    assert found.cells >= 100 * found.computed
    assert found.wrong <= 1e-4 * found.cells
    assert found.wrong / found.cells <= found.bound < 1e-4
    assert found.seconds_full > 10 * found.seconds
