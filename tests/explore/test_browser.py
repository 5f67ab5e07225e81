"""The page in headless Chromium: clicks, a slider, what is under the pointer, sound, errors, and hostile text."""

import shutil
import threading
import time
from contextlib import contextmanager

import pytest

from helpers.configs import HOSTILE
from stickslip_explore.view import open_source

pytest.importorskip("bokeh")
selenium = pytest.importorskip("selenium")
from selenium import webdriver  # noqa: E402
from selenium.webdriver.chrome.service import Service  # noqa: E402
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.support.ui import WebDriverWait  # noqa: E402

from stickslip_explore.server import Explorer  # noqa: E402
from stickslip_explore.static import write_page  # noqa: E402

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="no Chromium with its driver on this machine"),
]
FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--window-size=1500,1000",
)  # fmt: skip
PATIENCE = 30  # s
MODEL = "const model = (name) => Bokeh.documents[0].get_model_by_name(name);"
PLACE = (
    MODEL + "const view = Bokeh.index.find_one(model('map')); const box = view.el.getBoundingClientRect();"
    "const frame = view.frame.bbox; const [x, y] = [view.frame.x_scale.compute(arguments[0]),"
    "view.frame.y_scale.compute(arguments[1])]; return [box.left + x, box.top + y]"
)
# Links, pictures of files and formulas that stand anywhere on the page, in the shadows of its widgets too.
MARKUP = """(() => {
  const found = [], look = (root) => root.querySelectorAll("*").forEach((one) => {
    if (one.matches("a:not([href^='https://bokeh.org']), img[src^='x'], mjx-container, math, script[src='x']"))
      found.push(one.outerHTML)
    if (one.shadowRoot) look(one.shadowRoot)
  })
  look(document)
  return found
})()"""


@contextmanager
def served(source):
    explorer = Explorer(source)
    ready = threading.Event()
    thread = threading.Thread(target=explorer.run, args=(ready.set,), daemon=True)
    thread.start()
    assert ready.wait(PATIENCE)
    yield explorer
    explorer.stop()
    thread.join(10)


@pytest.fixture(scope="module")
def server():
    with served(open_source("configs/quickstart.yaml")) as explorer:
        yield explorer


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    found = webdriver.Chrome(options=options, service=Service(executable_path=DRIVER))
    yield found
    found.quit()


class Tab:
    """The page in a tab of the browser."""

    def __init__(self, browser, address):
        self.browser = browser
        browser.get(address)
        self.until("typeof Bokeh != 'undefined' && Bokeh.documents.length > 0 && model('map_cells') != null")
        self.until("model('map_cells').data.image.length == 1")

    def ask(self, expression, *given):
        return self.browser.execute_script(f"{MODEL} return {expression}", *given)

    def until(self, expression):
        guarded = f"{MODEL} try {{ return {expression} }} catch (error) {{ return false }}"
        WebDriverWait(self.browser, PATIENCE, 0.05).until(lambda b: b.execute_script(guarded), expression)

    def full_map(self):
        self.until("model('reproduce').text.includes('axes:')")

    def click(self, x, y):
        """At a place on the map: m/s, log10 of N/m."""
        at = self.browser.execute_script(PLACE, x, y)
        chain = ActionChains(self.browser, duration=0)
        chain.w3c_actions.pointer_action.move_to_location(round(at[0]), round(at[1]))
        chain.w3c_actions.pointer_action.click()
        chain.perform()

    def press(self, name):
        script = f"{MODEL} Bokeh.index.find_one(model(arguments[0])).shadow_el.querySelector('button').click()"
        self.browser.execute_script(script, name)

    def text(self, name):
        return self.ask("model(arguments[0]).text", name)

    def faults(self):
        return [line["message"] for line in self.browser.get_log("browser") if line["level"] == "SEVERE"]


@pytest.fixture
def tab(browser, server):
    found = Tab(browser, server.address)
    found.full_map()
    browser.get_log("browser")
    yield found
    assert found.faults() == []


def test_a_click_on_a_cell_that_sticks_and_slips_draws_it_and_it_can_be_heard(tab):
    tab.click(0.2, 2.0)
    tab.until("model('motion_stick').data.t.length > 100")
    numbers = tab.text("numbers")
    assert "stick-slip" in numbers and "damped" not in numbers and "frequency" in numbers
    stick = tab.ask("Array.from(model('motion_stick').data.v)")
    assert max(stick) == pytest.approx(200.0, abs=3.0)  # mm/s: it sticks to the belt
    assert tab.ask("model('phase').below[0].axis_label") == "displacement (mm)"
    tab.until("document.getElementById('readout').style.display == 'block'")  # the pointer is there still
    words = tab.ask("document.getElementById('readout').innerText")
    assert "stick-slip" in words and "frequency" in words and "Hz" in words and "belt speed" in words
    tab.press("hear")
    tab.until("window.stickslip_sound?.duration > 1.9")
    assert tab.ask("window.stickslip_sound.error") is None


def test_a_slider_recomputes_the_map_and_what_is_impossible_is_said(tab):
    def sticking():
        return tab.ask("Array.from(model('map_cells').data.image[0]).filter((code) => code == 1).length")

    before = sticking()
    tab.browser.execute_script(f"{MODEL} model('slider_damping').value = 1.5")
    tab.until("model('reproduce').text.includes('damping: 1.5')")
    assert tab.ask("model('map_cells').data.image[0].length") == 240 * 240 and sticking() < 0.95 * before
    tab.browser.execute_script(f"{MODEL} model('on_mu_stop').active = true")
    tab.until("model('reproduce').text.includes('mu_stop: 1.3')")
    tab.browser.execute_script(f"{MODEL} model('slider_a1').value = 0.5")
    tab.until("model('status').text.includes('at most mu_start')")


def test_the_page_without_a_server(browser, tmp_path):
    path = write_page(open_source("configs/quickstart.yaml"), tmp_path / "page.html")
    tab = Tab(browser, path.as_uri())
    browser.get_log("browser")
    tab.click(0.2, 2.0)
    tab.until("model('motion_stick').data.t.length > 50")
    assert "stick-slip" in tab.text("numbers") and "nearest cell" in tab.text("cell_words")
    shades = tab.ask("Array.from(model('map_cells').data.image[0]).slice(0, 50)")
    browser.execute_script(f"{MODEL} model('variable').value = 'frequency'")
    tab.until("model('legend').text.includes('frequency')")
    assert tab.ask("Array.from(model('map_cells').data.image[0]).slice(0, 50)") != shades
    assert tab.ask("performance.getEntriesByType('resource').length") == 0
    assert tab.faults() == []


def test_no_text_of_a_file_becomes_a_formula_a_link_or_a_script(browser, tmp_path):
    """Served and in one file, after a click: MathJax, which Bokeh brings along, would make a link of `\\href`."""
    path = tmp_path / "hostile.yaml"
    path.write_text(HOSTILE)
    with served(open_source(path)) as explorer:
        for address in (explorer.address, write_page(open_source(path), tmp_path / "page.html").as_uri()):
            tab = Tab(browser, address)
            tab.click(0.3, 0.0)
            tab.until(r"model('cell_words').text.includes('\\href')")
            time.sleep(1.0)  # MathJax comes later than the words
            assert tab.ask(MARKUP) == []
            assert tab.ask(r"document.querySelector('h1').innerText.includes('\\href')")
            assert tab.ask("window.hit ?? null") is None and tab.ask("window.MathJax ?? null") is None
            assert tab.faults() == []
