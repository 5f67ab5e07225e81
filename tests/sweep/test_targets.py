"""Where results are to go: what could not be written is refused before anything is computed, by every command, and
nothing but regular files is ever replaced."""

import os
import stat
from pathlib import Path

import pytest

from helpers.commands import call
from helpers.configs import write_config
from helpers.data import rows
from helpers.installed import is_command
from stickslip.errors import StoreError
from stickslip.files import targets
from stickslip.files.locations import location

pytestmark = pytest.mark.skipif(os.name == "nt", reason="links, pipes and /proc")
CELL = ("--at", "stiffness=1", "--at", "belt_speed=0.1")
COMPARED = ("--mass", "1 kg", "--stiffness", "1 N/m", "--load", "1 N")
# What writes a file: the words before its name, and the suffixes it may have.
COMMANDS = rows("sweep.yaml")["test_targets"]["COMMANDS"]


PRESENT = {name: row for name, row in COMMANDS.items() if is_command(row[0][0])}


def hostile_place(kind, here, suffix):
    """A path at which nothing can be written, in a folder."""
    place = here / f"x{suffix}"
    match kind:
        case "device behind a link" | "link to a link to a device":
            os.symlink("/dev/null", place)
            if "link to a link" in kind:
                os.symlink(place, place := here / f"y{suffix}")
        case "pipe":
            os.mkfifo(place)
        case "folder":
            place.mkdir()
        case "link to itself":
            os.symlink(place, place)
        case "place where nothing can be made":
            place = Path(f"/proc/x{suffix}")
        case "file in the place of the folder":
            (here / "file").write_text("")
            place = here / "file" / place.name
        case "name too long":
            place = here / f"{'x' * 256}{suffix}"
        case "name that is not utf8":
            place = here / f"\udcff{suffix}"
    return place


HOSTILE = (
    "device behind a link", "link to a link to a device", "pipe", "folder", "link to itself",
    "place where nothing can be made", "file in the place of the folder", "name too long", "name that is not utf8",
)  # fmt: skip


@pytest.mark.parametrize("words", PRESENT.values(), ids=PRESENT)
def test_what_cannot_be_written_is_refused_by_every_command_before_anything_is_read_or_computed(words, here):
    """No input is there, which would be told if it were read first."""
    command, suffixes = words
    for number, suffix in enumerate(suffixes):
        for kind in ("device behind a link", "pipe", "place where nothing can be made"):
            folder = here / f"{number}{kind}"
            folder.mkdir()
            place = hostile_place(kind, folder, suffix)
            before = {path: stat.S_IFMT(os.lstat(path).st_mode) for path in folder.iterdir()}
            done = call(*command, place)
            assert done.exit_code == 2 and not done.stdout, done.output
            assert "left alone" in done.stderr or "cannot be written" in done.stderr, done.stderr
            assert {path: stat.S_IFMT(os.lstat(path).st_mode) for path in folder.iterdir()} == before


@pytest.mark.parametrize("hostile", HOSTILE)
@pytest.mark.parametrize("kind", targets.KINDS)
def test_each_kind_of_file_is_refused_where_it_cannot_be_written(kind, hostile, tmp_path):
    for number, suffix in enumerate(targets.KINDS[kind].suffixes):
        folder = tmp_path / str(number)
        folder.mkdir()
        place = hostile_place(hostile, folder, suffix)
        before = sorted(folder.rglob("*"))
        with pytest.raises(StoreError):
            targets.check_target(place, kind)
        assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("hostile", HOSTILE)
def test_nothing_but_a_regular_file_is_replaced_by_whatever_writes(hostile, tmp_path):
    if hostile == "name that is not utf8":
        pytest.skip("can be written, but not told")
    place = hostile_place(hostile, tmp_path, ".csv")
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
