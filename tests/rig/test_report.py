"""The report of a test matrix: one self-contained file."""

import re
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from stickslip.config.reader import parse_config
from stickslip.vocabulary.flags import STATUSES
from stickslip_rig import plots as reports
from stickslip_rig.api import RPN_NAME, RigTests, load_rig, make_rig, run_matrix
from stickslip_rig.plots import report

HOSTILE = '<script>alert("1")</script> & $x$'
RIG = {
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


@pytest.fixture(scope="module")
def computed():
    rig = make_rig(RIG)
    return rig, run_matrix(rig), {test.name: test.record for test in RigTests(rig).tests([0, 2])}


@pytest.fixture(scope="module")
def page(computed):
    rig, ds, records = computed
    return report(ds, records, rig)


def rows_of(page):
    """The texts in the cells of the table, and the classes of its cells; tests/sweep/test_pages.py reads the frame."""
    lines = re.findall(r"<tr>(.*?)</tr>", page, re.DOTALL)
    cells = (re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", line, re.DOTALL) for line in lines)
    rows = [[unescape(re.sub(r"<[^>]*>", "", cell)) for cell in row] for row in cells]
    return rows, re.findall(r'<td class="(green|yellow|red|unknown)"', page)


def test_every_test_stands_in_the_table_with_its_number_on_its_light(computed, page):
    _, ds, _ = computed
    (head, *rows), lights = rows_of(page)
    assert head[:3] == ["test", "RPN", "sticks"] and page.count("<img") == 3  # the heat map, traces, their first stroke
    assert [row[:2] for row in rows] == [
        [f"{material}, {speed} m/s", str(int(ds["model_rpn"].values.flat[n]))]
        for n, (material, speed) in enumerate((m, s) for m in (HOSTILE, "_felt") for s in ("0.005", "0.01"))
    ]
    assert [row[2] for row in rows] == [f"{n:.0f}" for n in ds["sticks"].values.ravel()]
    assert lights == [("unknown", "green", "yellow", "red")[band] for band in ds["model_rpn_band"].values.ravel()]


def test_what_users_write_is_text_and_the_page_says_where_it_comes_from(computed, page):
    rig, ds, _ = computed
    assert "<script" not in page and unescape(page).count(f"Report {HOSTILE}") == 3  # title, heading, configuration
    assert RPN_NAME in unescape(page) and "Warning" not in page
    assert all(ds.attrs[key] in unescape(page) for key in ("source", "software", "date_created"))
    assert parse_config(unescape(re.search(r"(?s)<pre[^>]*>(.*?)</pre>", page)[1])) == rig


def test_tests_not_integrated_to_the_end_are_named_and_a_long_table_is_cut(computed, monkeypatch):
    rig, ds, _ = computed
    broken = ds.copy(deep=True)
    broken["status"][1, 0] = STATUSES.index("step_limit")
    broken["model_rpn"][1, 0] = broken["model_rpn_band"][1, 0] = 0
    broken["sticks"][1, 0] = np.nan
    page = report(broken, {}, rig)
    assert "1 not integrated to the end (_felt, 0.005 m/s): the step budget ran out" in page
    assert rows_of(page)[0][3][1:3] == ["?", "–"]
    monkeypatch.setattr(reports, "MOST_ROWS", 3)
    page = report(ds, {}, rig)
    assert len(rows_of(page)[0]) == 1 + 3 and "1 more tests are left out" in page


def test_a_single_test_has_a_report_with_band_limited_accelerations_where_the_model_uses_them(computed):
    rig, ds, records = computed
    limited = ds.isel(material=0, belt_speed=0).copy(deep=True)
    limited["acceleration_max_limited"][()] = 0.125
    rows, _ = rows_of(report(limited, {"whatever": next(iter(records.values()))}, rig))
    assert len(rows) == 2 and rows[1][3] == "0.125"


def test_the_matrix_that_ships_has_the_conditions_of_table_1_of_the_article():
    grid = RigTests(load_rig(Path(__file__).resolve().parents[2] / "configs" / "rig" / "test_matrix.yaml")).grid
    points = {c.name: c.values.tolist() for c in grid.coords}
    assert points["belt_speed"] == [0.001, 0.005, 0.01] and points["normal_load"] == [10, 20, 80]
    assert points["waiting_time"] == [10, 60, 300]
    temperatures = {label.split()[-2] for c in grid.coords for label in c.labels or ()}
    assert temperatures == {"-30", "23", "80"} and grid.size == 324
