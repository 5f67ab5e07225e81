"""Where results are to go: what could not be written is refused before anything is computed, by every command, and
nothing but regular files is ever replaced."""

import os
import stat
from pathlib import Path

import pytest
from click.testing import CliRunner

from helpers.configs import write_config
from stickslip.cli import main
from stickslip.errors import StoreError
from stickslip.files import targets
from stickslip.files.locations import location

pytestmark = pytest.mark.skipif(os.name == "nt", reason="links, pipes and /proc")
CELL = ("--at", "stiffness=1", "--at", "belt_speed=0.1")
COMPARED = ("--mass", "1 kg", "--stiffness", "1 N/m", "--load", "1 N")
COMMANDS = {  # what writes a file: the words before its name, and the suffixes it may have
    "run -o": (("run", "c.yaml", "-o"), (".nc", ".zarr", ".csv")),
    "run --plot": (("run", "c.yaml", "-o", "map.nc", "--plot"), (".png", ".pdf")),
    "border -o": (("border", "c.yaml", "--along", "stiffness", "-o"), (".nc",)),
    "border --plot": (("border", "c.yaml", "--along", "stiffness", "--plot"), (".png",)),
    "contours -o": (("contours", "c.yaml", "-o"), (".csv",)),
    "attractors -o": (("attractors", "c.yaml", "-o"), (".nc",)),
    "ramp -o": (("ramp", "c.yaml", "--along", "stiffness", "-o"), (".nc",)),
    "ramp --plot": (("ramp", "c.yaml", "--along", "stiffness", "--plot"), (".svg",)),
    "advise -o": (("advise", "c.yaml", *CELL, "-o"), (".nc",)),
    "simulate -o": (("simulate", "c.yaml", *CELL, "-o"), (".nc", ".csv")),
    "simulate --plot": (("simulate", "c.yaml", *CELL, "--plot"), (".png",)),
    "listen -o": (("listen", "c.yaml", *CELL, "-o"), (".wav",)),
    "listen --plot": (("listen", "c.yaml", *CELL, "--plot"), (".png",)),
    "listen --level": (("listen", "c.yaml", "--level", "-o"), (".nc",)),
    "fit --plot": (("fit", "p.csv", "--plot"), (".png",)),
    "compare -o": (("compare", "p.csv", *COMPARED, "-o"), (".csv", ".nc", ".xlsx")),
    "compare --plot": (("compare", "p.csv", *COMPARED, "--plot"), (".png",)),
    "compare --report": (("compare", "p.csv", *COMPARED, "--report"), (".html",)),
    "points -o": (("points", "p.csv", "-o"), (".csv",)),
    "export -o": (("export", "map.nc", "-o"), (".csv", ".xlsx")),
    "plot -o": (("plot", "map.nc", "-o"), (".png", ".svg", ".html")),
    "rig run -o": (("rig", "run", "c.yaml", "-o"), (".nc",)),
    "rig run --plot": (("rig", "run", "c.yaml", "--plot"), (".png",)),
    "rig run --report": (("rig", "run", "c.yaml", "--report"), (".html",)),
    "rig run --sound": (("rig", "run", "c.yaml", "--sound"), (".wav",)),
    "rig features -o": (("rig", "features", "r.csv", "-o"), (".csv", ".nc")),
    "rig features --plot": (("rig", "features", "r.csv", "--plot"), (".png",)),
    "explore --static": (("explore", "c.yaml", "--static"), (".html",)),
    "collect -o": (("collect", "c.yaml", "-o"), (".nc",)),
}


def a_device_behind_a_link(here, suffix):
    os.symlink("/dev/null", here / f"x{suffix}")
    return here / f"x{suffix}"


def a_link_to_a_link_to_a_device(here, suffix):
    os.symlink(a_device_behind_a_link(here, suffix), here / f"y{suffix}")
    return here / f"y{suffix}"


def a_pipe(here, suffix):
    os.mkfifo(here / f"x{suffix}")
    return here / f"x{suffix}"


def a_folder(here, suffix):
    (here / f"x{suffix}").mkdir()
    return here / f"x{suffix}"


def a_link_to_itself(here, suffix):
    os.symlink(here / f"x{suffix}", here / f"x{suffix}")
    return here / f"x{suffix}"


def a_place_where_nothing_can_be_made(_here, suffix):
    return Path(f"/proc/x{suffix}")


def a_file_in_the_place_of_the_folder(here, suffix):
    (here / "file").write_text("")
    return here / "file" / f"x{suffix}"


def a_name_too_long(here, suffix):
    return here / f"{'x' * 256}{suffix}"


def a_name_that_is_not_utf8(here, suffix):
    return here / f"\udcff{suffix}"


HOSTILE = [
    a_device_behind_a_link, a_link_to_a_link_to_a_device, a_pipe, a_folder, a_link_to_itself,
    a_place_where_nothing_can_be_made, a_file_in_the_place_of_the_folder, a_name_too_long, a_name_that_is_not_utf8,
]  # fmt: skip


def call(*arguments):
    return CliRunner().invoke(main, [str(one) for one in arguments])


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("words", COMMANDS.values(), ids=COMMANDS)
def test_what_cannot_be_written_is_refused_by_every_command_before_anything_is_read_or_computed(words, here):
    """No input is there, which would be told if it were read first."""
    command, suffixes = words
    for number, suffix in enumerate(suffixes):
        for hostile in (a_device_behind_a_link, a_pipe, a_place_where_nothing_can_be_made):
            folder = here / f"{number}{hostile.__name__}"
            folder.mkdir()
            place = hostile(folder, suffix)
            before = {path: stat.S_IFMT(os.lstat(path).st_mode) for path in folder.iterdir()}
            done = call(*command, place)
            assert done.exit_code == 2 and not done.stdout, done.output
            assert "left alone" in done.stderr or "cannot be written" in done.stderr, done.stderr
            assert {path: stat.S_IFMT(os.lstat(path).st_mode) for path in folder.iterdir()} == before


@pytest.mark.parametrize("hostile", HOSTILE, ids=lambda one: one.__name__)
@pytest.mark.parametrize("kind", targets.KINDS)
def test_each_kind_of_file_is_refused_where_it_cannot_be_written(kind, hostile, tmp_path):
    for number, suffix in enumerate(targets.KINDS[kind].suffixes):
        folder = tmp_path / str(number)
        folder.mkdir()
        place = hostile(folder, suffix)
        before = sorted(folder.rglob("*"))
        with pytest.raises(StoreError):
            targets.check_target(place, kind)
        assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("hostile", HOSTILE, ids=lambda one: one.__name__)
def test_nothing_but_a_regular_file_is_replaced_by_whatever_writes(hostile, tmp_path):
    if hostile is a_name_that_is_not_utf8:
        pytest.skip("can be written, but not told")
    place = hostile(tmp_path, ".csv")
    with pytest.raises(StoreError), targets.replaced(place) as temporary:
        temporary.write_text("x")
    assert not list(tmp_path.glob(".*.part"))


def test_a_link_to_a_file_stays_a_link_and_the_file_is_replaced(tmp_path):
    (tmp_path / "real.csv").write_text("old")
    os.symlink(tmp_path / "real.csv", tmp_path / "link.csv")
    with targets.replaced(tmp_path / "link.csv") as temporary:
        temporary.write_text("new")
    assert (tmp_path / "link.csv").is_symlink() and (tmp_path / "real.csv").read_text() == "new"


@pytest.mark.parametrize("name", ["file: ~/x.nc", "file: x.nc, plot: ~/x.png"])
def test_a_tilde_in_a_configuration_is_the_folder_of_the_user(name, here, monkeypatch):
    (here / "home").mkdir()
    monkeypatch.setenv("NUMBA_CACHE_DIR", os.environ.get("NUMBA_CACHE_DIR", os.path.expanduser("~/.cache/stickslip")))
    monkeypatch.setenv("HOME", str(here / "home"))
    config = write_config(here, num=3, more=f"output: {{{name}}}\n")
    done = call("run", config)
    assert done.exit_code == 0, done.output
    assert list((here / "home").iterdir()) and not (here / "~").exists()
    assert str(here / "home") in done.stdout, "what the path became is said"
    assert location("~/x.nc") == here / "home" / "x.nc"


@pytest.mark.parametrize("key", ["file", "plot"])
@pytest.mark.parametrize("place", ["/proc/x", "pipe", "x" * 256])
def test_what_a_configuration_names_is_checked_before_anything_is_computed(key, place, here):
    suffix = ".nc" if key == "file" else ".png"
    if place == "pipe":
        os.mkfifo(here / f"pipe{suffix}")
    done = call("run", write_config(here, num=3, more=f"output: {{{key}: {place}{suffix}}}\n"))
    assert done.exit_code == 2 and not done.stdout and place[:5] in done.stderr
    assert not list(here.glob("*.parts"))
