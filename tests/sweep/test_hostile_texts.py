"""Texts that come from anybody, in titles, labels and names: shown as they are, and never obeyed."""

import csv
import os
import signal
import socket
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text

import stickslip
from helpers.commands import call
from helpers.configs import write_config
from helpers.nightly import few
from stickslip import plots
from stickslip.cli import screen
from stickslip.dataset.export import write_table
from stickslip.errors import ConfigError, visible

HOSTILE = ["$x^{$", "\x1b[31mred", "a\rb", "\x07", "a\ud800b", "\u202eevil", "\\frac{", "_hidden", "50 $ & 60 $"]
SOURCES = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
CELL = {"mass": 1.0, "normal_load": 1.0, "a1": 0.3, "a2": 0.1, "a3": 0.2, "a4": 0.1}


@pytest.fixture(scope="module")
def labelled():
    """A map over labels, all of them hostile."""
    speeds = xr.DataArray(np.linspace(0.1, 0.2, len(HOSTILE)), {"pad": HOSTILE}, "pad")
    ds = stickslip.evaluate(CELL | {"belt_speed": speeds, "stiffness": xr.DataArray([1.0, 10.0], dims="stiffness")})
    return ds.assign_attrs(title="".join(HOSTILE))


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_titles_and_labels_are_drawn_as_texts_and_never_as_formulas(suffix, labelled, tmp_path):
    figure = plots.plot_map(labelled, title="".join(HOSTILE))
    plots.save(figure, tmp_path / f"map{suffix}")
    shown = {text.get_text() for text in figure.findobj(Text)}
    assert {"$x^{$", "a\\rb", "50 $ & 60 $"} <= shown and not any("\x1b" in one for one in shown)
    if suffix == ".svg":
        import xml.dom.minidom

        xml.dom.minidom.parse(str(tmp_path / "map.svg"))


@pytest.mark.parametrize("text", [text for text in HOSTILE if visible(text) != text])
@pytest.mark.parametrize("key", ["title", "label"])
def test_a_configuration_with_control_characters_is_refused(text, key):
    config = {
        "system": {"mass": 1, "normal_load": 1, "stiffness": 1},
        "friction": {k: CELL[k] for k in CELL if k[0] == "a"},
    }
    config["axes"] = {"pad": {"zip": {"belt_speed": [0.1, 0.2]}, "labels": ["a", text if key == "label" else "b"]}}
    with pytest.raises(ConfigError, match="without control characters"):
        stickslip.run(config | ({"title": text} if key == "title" else {}), progress=False)


@pytest.mark.parametrize("suffix", [".csv", ".xlsx"])
def test_a_table_has_one_row_for_each_cell_whatever_its_labels_are(suffix, labelled, tmp_path):
    path = tmp_path / f"map{suffix}"
    write_table(labelled, path)
    if suffix == ".csv":
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.reader(file))
        assert len(rows) == 1 + labelled["regime"].size and {len(row) for row in rows} == {len(rows[0])}
        assert path.read_bytes().count(b"\r") == 0


def test_nothing_that_is_printed_is_obeyed_by_a_terminal(capsys):
    screen.echo("".join(HOSTILE))
    screen.terminal().print("".join(HOSTILE), markup=False)
    for line in capsys.readouterr().out.splitlines():
        assert "\\x1b[31mred" in line and visible(line) == line


def test_a_name_with_control_characters_is_told_without_them(here):
    (here / "a\x1b[2J.yaml").write_text("")
    done = call()
    assert "\x1b" not in done.output and "a\\x1b[2J.yaml" in done.output


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device of Linux")
def test_a_full_standard_output_is_said_and_no_traceback():
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "stickslip", "init", "--schema"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            env=SOURCES,
        )
    assert done.returncode == 1
    assert done.stderr == "standard output: cannot be written (No space left on device)\n"


@pytest.mark.slow
@pytest.mark.skipif(signal.getsignal(signal.SIGINT) is signal.SIG_IGN, reason="Ctrl-C is ignored, as by a shell's jobs")
@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C as a signal")
def test_a_silent_scheduler_ends_a_run_in_time_and_ctrl_c_says_what_it_interrupts(tmp_path):
    """Something listens at the port, and never answers."""
    pytest.importorskip("distributed")
    config = write_config(tmp_path, num=3)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": SOURCES}
    with socket.create_server(("127.0.0.1", 0)) as one, socket.create_server(("127.0.0.1", 0)) as other:
        addresses = [f"tcp://127.0.0.1:{server.getsockname()[1]}" for server in (one, other)]
        words = [sys.executable, "-m", "stickslip", "run", str(config), "-o", str(tmp_path / "m.nc"), "--set"]
        began = [subprocess.Popen([*words, f"execution.dask={address}"], **pipes) for address in addresses]
        connections = [server.accept() for server in (one, other)]
        connected = time.monotonic()
        time.sleep(0.5)
        began[0].send_signal(signal.SIGINT)
        errors = [process.communicate(timeout=60)[1] for process in began]
        assert time.monotonic() - connected < 20.0
        for connection, _ in connections:
            connection.close()
    assert [process.returncode for process in began] == [1, 2], errors
    assert f"interrupted while connecting to the Dask scheduler ({addresses[0]})" in errors[0]
    assert f"{addresses[1]}: no Dask scheduler answered within 10 s" in errors[1]
    assert not list(tmp_path.glob("*.parts"))


@pytest.mark.parametrize("unit", few(["blub", "$x^{$", "", "m/", "°", "m s-", "2", "kg**"], 3))
def test_an_unknown_unit_in_a_file_of_others_is_told_without_a_traceback(unit, labelled, here):
    speeds = xr.DataArray([0.1, 0.2], dims="belt_speed", attrs={"units": unit})
    ds = labelled.isel(pad=[0, 1]).drop_vars(["pad", "belt_speed"]).rename(pad="belt_speed")
    ds.assign_attrs(title="theirs").assign_coords(belt_speed=speeds).to_netcdf("theirs.nc")
    for more in ((), ("--units", "belt_speed=mm/s"), ("--limits", "belt_speed=0.1..0.2 m/s")):
        done = call("plot", "theirs.nc", "-o", "theirs.png", *more)
        assert isinstance(done.exception, SystemExit | None), (unit, more, done.exception)
        assert done.exit_code == (2 if more else 0), done.output
