"""A tab without a browser: events go in, what is drawn comes out; and the thread that does what was asked for last."""

import base64
import re
import threading
import time
from html import unescape
from pathlib import Path

import numpy as np
import pytest

import stickslip
from helpers.configs import HOSTILE
from helpers.pages import tags
from stickslip.config.reader import parse_config
from stickslip_explore.view import open_source

pytest.importorskip("bokeh")
from bokeh.document import Document  # noqa: E402
from bokeh.embed.bundle import _use_mathjax  # noqa: E402
from bokeh.events import ButtonClick, Tap  # noqa: E402
from bokeh.models import Div  # noqa: E402

from stickslip_explore import maps  # noqa: E402
from stickslip_explore.server import LatestOnly, Session  # noqa: E402

WAIT = 30.0  # s


class Tab:
    """A session whose loop is run by hand."""

    def __init__(self, path):
        self.document = Document()
        self.session = Session(self.document, open_source(path))

    def settle(self, until):
        """Run what threads have handed to the loop, until something holds."""
        end = time.monotonic() + WAIT
        while not until():
            assert time.monotonic() < end, self.status
            for callback in sorted(self.document.session_callbacks, key=lambda added: int(added.id[1:])):  # a set
                self.document.remove_next_tick_callback(callback)
                callback.callback()
            time.sleep(0.005)

    def model(self, name):
        return self.document.get_model_by_name(name)

    def data(self, name):
        return self.document.select_one({"name": name}).data

    @property
    def status(self):
        return self.model("status").text

    @property
    def shades(self):
        (image,) = self.data("map_cells")["image"]
        return image

    def full_map(self, before=""):
        """Wait for the whole map, of another YAML than before."""
        self.settle(lambda: self.yaml != before)

    @property
    def yaml(self):
        return self.session.page.texts.tags[0]["yaml"]

    def click(self, x, y):
        before = self.model("cell_words").text
        plot = self.session.page.map.plot
        plot._trigger_event(Tap(plot, sx=0, sy=0, x=x, y=y))
        self.settle(lambda: self.model("cell_words").text != before)


@pytest.fixture
def small(tmp_path):
    """The shipped map with fewer cells."""
    path = tmp_path / "small.yaml"
    path.write_text(Path("configs/quickstart.yaml").read_text().replace("num: 240", "num: 48"))
    return path


@pytest.fixture
def tab(small):
    opened = []

    def open_tab(path=small):
        opened.append(Tab(path))
        opened[-1].full_map()
        return opened[-1]

    yield open_tab
    for one in opened:
        one.session.close()


def test_a_tab_shows_the_map_of_the_file(tab, small):
    one = tab()
    known = stickslip.run(small)["regime"].values
    assert np.array_equal(one.shades, known.astype(np.uint8))
    assert "2,304 cells" in one.status and "stick-slip" in one.model("legend").text
    columns = one.session.page.map.columns
    assert columns.data["regime"].size == known.size and columns.tags[0]["x"]["n"] == 48


def test_a_click_draws_both_motions_and_their_numbers(tab):
    one = tab()
    one.click(0.45, 2.0)  # 100 N/m: stick-slip and sliding coexist
    stick, sliding = one.data("motion_stick"), one.data("motion_sliding")
    assert np.ptp(stick["v"]) > 0.4 and np.ptp(sliding["v"]) < 1e-3  # m/s
    assert len(one.data("unstable_cycle")["x"]) > 100 and len(one.data("friction_curve")["w"]) > 100
    words = one.model("cell_words").text
    assert re.search("stiffness (9|10).* N/m, belt speed 0.4[3-6]", words)
    assert "unstable cycle" in words
    numbers = one.model("numbers").text
    assert "stick-slip" in numbers and "damped" in numbers and "frequency" in numbers
    assert re.search(r"small.yaml --at \S*stiffness=", one.model("reproduce").text)
    assert one.data("map_mark")["x"] == [pytest.approx(0.45, abs=0.02)]


def test_a_slider_recomputes_the_map_and_the_cell_that_is_seen(tab):
    one = tab()
    one.click(0.45, 2.0)
    before, cell, yaml = one.shades, one.model("numbers").text, one.yaml
    one.model("slider_damping").value = 1.5
    one.full_map(yaml)
    one.settle(lambda: "damping=1.5" in one.model("reproduce").text)
    assert np.count_nonzero(one.shades == 1) < np.count_nonzero(before == 1)
    assert one.model("numbers").text != cell and "damping: 1.5" in one.yaml
    assert np.array_equal(one.shades, stickslip.run(parse_config(one.yaml))["regime"].values)
    one.model("reset")._trigger_event(ButtonClick(one.model("reset")))
    one.settle(lambda: one.yaml == yaml)
    assert np.array_equal(one.shades, before) and one.model("slider_damping").value == 0.0


def test_the_command_of_a_cell_goes_with_its_sides(tab):
    one = tab()
    one.model("on_velocity").active = True
    one.model("slider_velocity").value = -2.842e-14  # what the browser adds up to
    assert one.session.view.values["velocity"] == 0.0
    one.click(0.45, 2.0)
    assert "stickslip simulate" in one.model("reproduce").text
    one.model("side_y").value = "mass"
    assert "stickslip simulate" not in one.model("reproduce").text


def test_what_is_impossible_is_said_on_the_page_and_the_map_stays(tab):
    one = tab()
    before, yaml = one.shades, one.yaml
    one.model("slider_mu_stop").value = 1.2  # nothing happens until it is switched on
    one.model("on_mu_stop").active = True
    one.full_map(yaml)
    hysteretic, yaml = one.shades, one.yaml
    assert not np.array_equal(hysteretic, before) and "mu_stop: 1.2" in yaml
    one.model("slider_a3").value = 0.05
    one.settle(lambda: "error" in one.status)
    assert "mu_stop" in one.status and "at most mu_start" in one.status
    assert np.array_equal(one.shades, hysteretic)
    one.model("on_mu_stop").active = False
    one.full_map(yaml)
    assert not np.array_equal(one.shades, hysteretic) and "mu_stop: none" in one.yaml


def test_a_bug_is_said_on_the_page_and_logged(tab, monkeypatch, caplog):
    one = tab()
    monkeypatch.setattr(maps, "computed", lambda *_: 1 / 0)
    one.model("slider_mass").value = 2.5
    one.settle(lambda: "ZeroDivisionError" in one.status)
    assert "Traceback" in caplog.text and "division by zero" in caplog.text


@pytest.mark.slow
def test_another_variable_and_other_sides(tab):
    one = tab("configs/lubricants.yaml")
    assert one.shades.shape == (5, 400)
    assert {"frequency", "damping_ratio", "regime"} <= {name for name, _ in one.model("variable").options}
    one.model("variable").value = "damping_ratio"
    one.settle(lambda: "damping ratio" in one.model("legend").text)
    one.model("variable").value = "regime"
    yaml = one.yaml
    one.model("side_y").value = "stiffness"
    one.full_map(yaml)
    assert one.shades.shape == (160, 400)
    assert one.model("pick_lubricant").options[1] == ("1", "felt tape")
    dry, yaml = one.shades, one.yaml
    one.model("pick_lubricant").value = "4"
    one.full_map(yaml)
    assert not np.array_equal(one.shades, dry)
    one.click(1.0, 1.0)  # 10 mm/s, 10 N/mm
    assert "stiffness 9.856 N/mm, belt speed 9.989 mm/s" in one.model("cell_words").text
    assert "lubricant=fluid B" in unescape(one.model("reproduce").text).replace("'", "")


def test_the_sound_of_the_cell_reaches_the_page(tab):
    one = tab()
    one.click(0.3, 3.5)
    one.session._hear()
    one.settle(lambda: bool(one.model("below").tags[0].data["wav"]))
    (wav,) = one.model("below").tags[0].data["wav"]
    assert base64.b64decode(wav)[:4] == b"RIFF" and "stick-slip" in one.model("heard").text


def test_what_a_file_says_is_text_and_neither_formula_nor_markup(tab, tmp_path):
    """MathJax, which Bokeh runs over strings, would make a live link of `\\href{javascript:...}` in a label."""
    path = tmp_path / "<img src=x onerror=a>.yaml"
    path.write_text(HOSTILE)
    one = tab(path)
    for place, words in ((0.0, "$$"), (1.0, "&lt;img"), (2.0, r"\[x\]")):
        one.click(0.3, place)
        assert words in one.model("cell_words").text
    one.session._hear()
    one.settle(lambda: r"\[x\]" in one.model("heard").text)
    assert r"sleeve=\[x\]" in unescape(one.model("reproduce").text).replace("'", "")
    assert not _use_mathjax(set(one.document.models))
    shown = [model.text for model in one.document.select({"type": Div})]
    assert all(div.disable_math for div in one.document.select({"type": Div})) and any("javascript" in t for t in shown)
    assert {"table", "b", "span"} <= tags(*shown) and not {"a", "img", "script"} & tags(*shown)


# --- what was asked for last ------------------------------------------------------------------------------------------


def test_of_jobs_asked_for_while_one_runs_the_last_is_done_and_the_running_one_is_told_to_stop():
    started, done, stopped = threading.Event(), [], []

    def work(job, stop):
        started.set()
        while job == 0 and not stop[0]:
            time.sleep(0.001)
        stopped.append((job, int(stop[0])))
        done.append(job)

    latest = LatestOnly(work, "test")
    latest.ask(0)
    assert started.wait(WAIT)
    for job in range(1, 50):
        latest.ask(job)
    end = time.monotonic() + WAIT
    while 49 not in done and time.monotonic() < end:
        time.sleep(0.001)
    latest.close()
    assert stopped[0] == (0, 1) and done[-1] == 49 and len(done) < 50
    assert not any(thread.name.startswith("test_0") for thread in threading.enumerate())
