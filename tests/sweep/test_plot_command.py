"""`stickslip plot` and `output.report`: pictures and pages on the command line."""

import shutil

import pytest
from PIL import Image

from helpers.commands import call
from helpers.configs import write_config
from helpers.data import cases

MARK = "rig: stiffness=1 N/m, belt_speed=200 mm/s"


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    """A map, and the picture of its run."""
    folder = tmp_path_factory.mktemp("once")
    done = call("run", write_config(folder), "-o", folder / "map.nc", "--plot", folder / "map.png")
    assert done.exit_code == 0, done.output
    return folder


@pytest.fixture
def computed(once, tmp_path, monkeypatch):
    shutil.copytree(once, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def size_of(path):
    with Image.open(path) as image:
        return image.size


def written(*arguments):
    done = call("plot", "map.nc", *arguments)
    assert done.exit_code == 0, done.output
    return done.stdout.split()[-1]


def test_the_name_of_a_picture_nobody_named_says_what_it_shows(computed):
    requests = [["--mark", MARK], ["--variable", "period"], ["--select", "stiffness=1 N/m", "--variable", "period"]]
    names = [written(*request) for request in requests]
    assert names == ["map.png", "map-period.png", "map-period-stiffness-1_N_m.png"]


def test_size_and_resolution_are_those_asked_for(computed):
    for arguments, size in (
        (["--size", "16x9 cm", "--dpi", "127"], (800, 450)),
        (["--size", "640 px x 360 px"], (640, 360)),
    ):
        got = size_of(computed / written(*arguments, "-o", "one.png"))
        assert all(abs(one - other) <= 1 for one, other in zip(got, size, strict=True)), (got, size)


@cases("sweep.yaml")
def test_wrong_wishes_are_explained(computed, arguments, message):
    done = call("plot", "map.nc", *arguments)
    assert done.exit_code == 2 and message in done.stderr and "Traceback" not in done.output


def test_limits_in_a_unit_show_the_variable_in_it(computed, monkeypatch):
    from stickslip import plots

    drawn = []
    monkeypatch.setattr(plots, "save", lambda figure, *rest, **more: drawn.append(figure))
    written("--variable", "period", "--limits", "period=1..1e6 ms")
    assert drawn[0].axes[-1].get_ylabel() == "period of the limit cycle (ms)"
    assert drawn[0].axes[-1].get_ylim() == pytest.approx((1, 1e6))


def test_what_only_maps_have_is_refused_for_other_plots(computed):
    assert (
        call("simulate", "map.nc", "--at", "stiffness=1", "--at", "belt_speed=0.1", "-t", 9, "-o", "t.nc").exit_code
        == 0
    )
    done = call("plot", "t.nc", "--mark", MARK)
    assert done.exit_code == 2 and "axes are time" in done.stderr
    assert call("plot", "t.nc", "--title", "Mine", "--size", "10 cm x 8 cm").stdout == "plot     t.png\n"


def test_a_run_writes_a_page_and_plot_writes_it_again(computed):
    config = computed / "small.yaml"
    done = call("run", config, "--set", "output.report=page.html")
    assert done.exit_code == 0 and "page     page.html (" in done.stdout
    page = (computed / "page.html").read_text(encoding="utf-8")
    assert page.count("<img ") == 3 and "Regimes of the cells" in page
    assert "page     again.html" in call("plot", "map.nc", "-o", "again.html", "--title", "Mine").stdout
    assert "<h1>Mine</h1>" in (computed / "again.html").read_text(encoding="utf-8")
    wrong = call("run", config, "--set", "output.report=page.docx")
    assert wrong.exit_code == 2 and "expected a file name that ends in .html" in wrong.stderr


@pytest.mark.slow
def test_more_panels_than_fit_are_a_picture_of_a_part_which_is_said(here):
    config = write_config(here, num=4, more="output: {file: map.nc, plot: map.png}\n")
    config.write_text(config.read_text().replace("axes:\n", "axes:\n  damping: {start: 0, stop: 1.9, num: 20}\n"))
    done = call("run", config, "--set", "output.report=map.html")
    assert done.exit_code == 0
    assert done.stdout.count("drawn    damping = 1 N s/m") == 2 and "plot     map.png" in done.stdout
    assert size_of(here / "map.png") == size_of_one_panel(here)
    assert "panels over" not in (here / "map.html").read_text() and (here / "map.html").stat().st_size > 50_000
    refused = call("plot", "map.nc")
    assert refused.exit_code == 2 and "--select damping=" in refused.output and "select={'damping'" in refused.output


def size_of_one_panel(folder):
    assert call("plot", "map.nc", "--select", "damping=1", "-o", "one.png").exit_code == 0
    return size_of(folder / "one.png")
