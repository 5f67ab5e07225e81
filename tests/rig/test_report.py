"""The report of a test matrix: one self-contained file."""

import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from stickslip.config.reader import parse_config
from stickslip.errors import StoreError
from stickslip.pages import write_page
from stickslip.vocabulary.flags import STATUSES
from stickslip_rig import report as reports
from stickslip_rig.api import RPN_NAME, RigTests, load_rig, make_rig, run_matrix
from stickslip_rig.report import report

HOSTILE = '<script>alert("1")</script> & $x$'
VOID = {"meta", "img", "br", "hr", "link", "input"}


def rig_of(**more):
    """Two materials at two speeds, two strokes of 2 mm."""
    data = {
        "title": f"Report {HOSTILE}",
        "system": {"mass": 0.1, "stiffness": 5000.0, "damping": 2.0, "normal_load": 10.0},
        "drive": {"stroke": 0.002, "strokes": 2, "ramp": 0.02, "waiting_time": 1.0},
        "sensor": {"rate": 500.0, "oversampling": 4},
        "axes": {
            "material": {"labels": [HOSTILE, "_felt"],
                         "zip": {"a1": [0.3, 0.2], "a3": [0.2, 0.02], "a4": [0.02, 0.02], "a2": [0.0, 0.1]}},
            "belt_speed": {"values": [0.005, 0.01]},
        },
    }  # fmt: skip
    return make_rig(data | more)


@pytest.fixture(scope="module")
def computed():
    rig = rig_of()
    return rig, run_matrix(rig), {test.name: test.record for test in RigTests(rig).tests([0, 2])}


@pytest.fixture(scope="module")
def page(computed):
    rig, ds, records = computed
    return Page(report(ds, records, rig))


class Page(HTMLParser):
    """Elements of a page that must be well formed, and the text in them."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.text, self.open, self.elements, self.rows, self.configuration = "", [], [], [], ""
        self.feed(text)
        self.close()
        assert not self.open, f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        assert len(dict(attrs)) == len(attrs), f"{tag} has an attribute twice"
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> closes another element"

    def handle_data(self, data):
        if "style" in self.open:
            return
        self.text += data
        if "pre" in self.open:
            self.configuration += data
        if self.open and self.open[-1] in ("td", "th", "small"):
            self.rows[-1][-1] += data

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


def test_nothing_comes_from_elsewhere_and_nothing_runs(page):
    assert {"script", "link", "iframe", "object", "base"}.isdisjoint(name for name, _ in page.elements)
    for name, attributes in page.elements:
        assert "href" not in attributes and not any(key.startswith("on") for key in attributes)
        assert name == "img" or "src" not in attributes
    assert all(image["src"].startswith("data:image/") and image["alt"] for image in page.all("img"))
    assert len(page.all("img")) == 4  # two heat maps, the traces, and the first stroke of them


def test_style_sheets_load_nothing(computed):
    rig, ds, _ = computed
    assert not re.search(r"@import|url\(", report(ds, {}, rig))


def test_every_test_stands_in_the_table_with_its_number_on_its_light(computed, page):
    _, ds, _ = computed
    head, *rows = page.rows
    assert head[:4] == ["test", "material", "belt speedmm/s", "RPN"]
    assert [row[:4] for row in rows] == [
        [str(n), material, speed, str(int(ds["model_rpn"].values.flat[n]))]
        for n, (material, speed) in enumerate((m, s) for m in (HOSTILE, "_felt") for s in ("5", "10"))
    ]
    assert [row[4] for row in rows] == [f"{n:.0f}" for n in ds["sticks"].values.ravel()]
    lights = [cell["class"] for cell in page.all("td") if cell.get("class") in ("green", "yellow", "red", "unknown")]
    names = ("unknown", "green", "yellow", "red")
    assert lights == [names[band] for band in ds["model_rpn_band"].values.ravel()]


def test_what_users_write_is_text_and_nothing_else(computed, page):
    assert page.text.count(f"Report {HOSTILE}") == 3  # the title of the page, its heading, the configuration
    assert any(HOSTILE in image["alt"] for image in page.all("img"))


def test_the_page_says_whose_number_it_is_and_where_it_comes_from(computed, page):
    _, ds, _ = computed
    assert page.text.count(RPN_NAME) >= 3 and "not public" in page.text
    assert all(ds.attrs[key] in page.text for key in ("source", "software", "date_created"))
    assert "1–3: low noise" in page.text and "6–10: bad noise" in page.text
    assert "spring stiffness" in page.text and "5 N/mm" in page.text
    assert "Warning" not in page.text


def test_the_configuration_in_the_page_gives_the_same_rig_again(computed, page):
    rig, _, _ = computed
    assert parse_config(page.configuration) == rig


def test_tests_not_integrated_to_the_end_are_named(computed):
    rig, ds, _ = computed
    broken = ds.copy(deep=True)
    broken["status"][1, 0] = STATUSES.index("step_limit")
    broken["model_rpn"][1, 0] = broken["model_rpn_band"][1, 0] = 0
    broken["sticks"][1, 0] = np.nan
    page = Page(report(broken, {}, rig))
    assert "Warning. 1 test was not integrated to the end: the step budget ran out" in page.text
    assert "_felt, 5\N{NO-BREAK SPACE}mm/s" in page.text
    assert page.rows[3][3:5] == ["?", "–"]
    assert "No traces were asked for." in page.text


def test_a_long_table_is_cut_and_says_so(computed, monkeypatch):
    rig, ds, _ = computed
    monkeypatch.setattr(reports, "MOST_ROWS", 3)
    page = Page(report(ds, {}, rig))
    assert len(page.rows) == 1 + 3 and "1 more tests are left out" in page.text


def test_a_single_test_has_a_report(computed):
    rig, ds, records = computed
    one = ds.isel(material=0, belt_speed=0)
    page = Page(report(one, {"whatever": next(iter(records.values()))}, rig))
    assert "One test." in page.text and len(page.rows) == 2


def test_band_limited_accelerations_are_shown_where_the_model_uses_them(computed):
    rig, ds, _ = computed
    limited = ds.copy(deep=True)
    limited["acceleration_max_limited"][:] = 0.125
    page = Page(report(limited, {}, rig))
    assert {row[5] for row in page.rows[1:]} == {"0.125"}
    assert "within the bandwidth" in page.text


def test_a_report_is_one_file_whatever_its_name(computed, tmp_path):
    rig, ds, _ = computed
    path = tmp_path / "a report & its name ü.html"
    path.write_text("old")
    assert write_page(path, report(ds, {}, rig)) == path
    assert path.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_report_that_cannot_be_written_leaves_nothing_behind(computed, tmp_path):
    rig, ds, _ = computed
    (tmp_path / "taken.html").mkdir()
    (tmp_path / "file").touch()
    for path in (tmp_path / "taken.html", tmp_path / "file" / "x.html"):
        with pytest.raises(StoreError, match="cannot be written|left alone"):
            write_page(path, report(ds, {}, rig))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "taken.html"]


def test_the_matrix_that_ships_has_the_conditions_of_table_1_of_the_article():
    grid = RigTests(load_rig(Path(__file__).resolve().parents[2] / "configs" / "rig" / "test_matrix.yaml")).grid
    points = {c.name: c.values.tolist() for c in grid.coords}
    assert points["belt_speed"] == [0.001, 0.005, 0.01] and points["normal_load"] == [10, 20, 80]
    assert points["waiting_time"] == [10, 60, 300]
    temperatures = {label.split()[-2] for c in grid.coords for label in c.labels or ()}
    assert temperatures == {"-30", "23", "80"} and grid.size == 324
