"""Maps that keep some variables: bytes, resume, shards, clusters, and what is said where one is missing."""

import pytest

import stickslip
from helpers.commands import call
from helpers.configs import message, write_config
from helpers.data import cases
from helpers.runs import block_files, same
from stickslip.config.reader import load_config, parse_config
from stickslip.errors import ConfigError, StoreError
from stickslip.runs.formats import opened_block

SIDE = 30
KEPT = "output: {variables: [period, regime]}\n"


@pytest.fixture
def few(tmp_path, small_blocks):
    return write_config(tmp_path, num=SIDE, more=KEPT, name="few.yaml")


@pytest.fixture
def regimes(tmp_path, small_blocks):
    return write_config(tmp_path, num=SIDE, more="output: {variables: regime}\n", name="regimes.yaml")


# --- what is asked ----------------------------------------------------------------------------------------------------


def test_the_regime_is_always_kept_and_names_are_in_the_order_of_the_table(few):
    assert load_config(few).output.variables == ("regime", "period")
    text = few.read_text().replace("[period, regime]", "[steps, period, steps]")
    assert parse_config(text).output.variables == ("regime", "period", "steps")


@cases("runs.yaml")
def test_variables_that_are_none_are_refused_with_those_there_are(few, asked, complaint):
    assert complaint in message(few.read_text().replace("[period, regime]", asked))


def test_python_asks_by_an_argument_and_is_told_the_same(config, few):
    same(stickslip.run(config, variables=["period"]), stickslip.run(few))
    assert list(stickslip.run(few, variables="steps").data_vars) == ["regime", "steps"]
    with pytest.raises(ConfigError, match=r"^output.variables\[0\]: got 'perod'.*\n.*did you mean period"):
        stickslip.run(config, variables=["perod"])
    axes = {"stiffness": [1.0, 2.0], "belt_speed": [0.1, 0.2]}
    found = stickslip.sweep(system={"mass": 1, "normal_load": 1}, friction={"a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1},
                            axes=axes, variables="regime")  # fmt: skip
    assert list(found.data_vars) == ["regime"] and found.sizes == {"stiffness": 2, "belt_speed": 2}


# --- the numbers ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_what_is_kept_is_bit_identical_and_nothing_else_is_stored(few, whole, tmp_path, suffix):
    output = tmp_path / f"few{suffix}"
    found = stickslip.run(few, output, keep_parts=True)
    assert list(found.data_vars) == ["regime", "period"]
    for name in found.data_vars:
        assert found[name].values.tobytes() == whole[name].values.tobytes()
    store = tmp_path / f"few{suffix}.parts"
    for name in block_files(store):
        header, stored = opened_block((store / name).read_bytes())
        assert stored.keys() == {"regime", "period"} and header["stop"] - header["start"] == 2 * SIDE
    same(found, stickslip.run(few))


# --- runs in parts ----------------------------------------------------------------------------------------------------


def test_shards_give_the_map_of_one_run_and_one_with_other_variables_is_refused(few, regimes, config, tmp_path):
    store = tmp_path / "store"
    stickslip.run_shard(few, "1/2", store)
    for other, kept in ((config, "all"), (regimes, r'\["regime"\]')):
        with pytest.raises(StoreError, match=rf'output.variables: \["regime", "period"\] there, {kept} here'):
            stickslip.run_shard(other, "2/2", store)
    stickslip.run_shard(few, "2/2", store)
    same(stickslip.collect(store, tmp_path / "few.nc"), stickslip.run(few))


def test_a_map_with_other_variables_is_neither_taken_from_nor_replaced(few, config, tmp_path):
    for first, second in ((few, config), (config, few)):
        output = tmp_path / f"{first.stem}.nc"
        before = stickslip.run(first, output).load()
        with pytest.raises(StoreError, match=r"output\.variables: .*\n.*fresh=True starts over") as refused:
            stickslip.run(second, output)
        assert "all" in str(refused.value)
        same(stickslip.open(output), before)
        same(stickslip.run(second, output, fresh=True), stickslip.run(second))


# --- what is missing --------------------------------------------------------------------------------------------------


@pytest.fixture
def file(tmp_path):
    config = write_config(tmp_path, more="solver: {max_steps: 9}\noutput: {variables: regime}\n")
    stickslip.run(config, tmp_path / "map.nc").close()
    return tmp_path / "map.nc"


def test_inspect_lists_cells_by_regime_and_says_what_is_needed_for_more(file):
    done = call("inspect", file)
    assert done.exit_code == 0 and "unresolved" in done.stdout and "not kept" in done.stdout
    refused = call("inspect", file, "--status", "step_limit")
    assert refused.exit_code == 2
    assert "holds no status" in refused.stderr and "output.variables" in refused.stderr


def test_plots_say_what_is_there(file, tmp_path):
    refused = call("plot", file, "--variable", "period")
    assert refused.exit_code == 2 and "no variable 'period'; there are regime" in refused.stderr
    done = call("plot", file, "-o", tmp_path / "p.png")  # the borders of linear theory follow from the configuration
    assert done.exit_code == 0 and not done.stderr
