"""Pages of results: one self-contained file each."""

import re
from html.parser import HTMLParser

import numpy as np
import pytest

import stickslip
from helpers.maps import axis, make_map, plane
from stickslip.config.reader import parse_config
from stickslip.errors import StoreError
from stickslip.plots import pages
from stickslip.plots.pages import Picture, pictures_of, result_page
from stickslip.vocabulary.quantities import REGIMES, STATUS_MESSAGES, STATUSES

HOSTILE = '<script>alert("1")</script> & $x$'
VOID = {"meta", "img", "br"}


class Page(HTMLParser):
    """Text by section, elements, and whether they are well formed."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.elements, self.sections, self.heading = [], [], {}, ""
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)
        if tag == "h2":
            self.heading = ""

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        if tag == "h2":
            self.sections[self.heading] = ""

    def handle_data(self, data):
        if self.open and self.open[-1] == "h2":
            self.heading += data
        elif self.heading in self.sections:
            self.sections[self.heading] += f"{data}\n"

    def images(self):
        return [attributes for tag, attributes in self.elements if tag == "img"]


def page_of(ds):
    """The page without pictures, which take most of the time."""
    return Page(result_page(ds, []))


def test_a_page_of_a_map_loads_nothing_and_escapes_what_users_wrote():
    ds = make_map(axis("stiffness", [1.0, 10.0, 100.0], "log"), axis("belt_speed", [0.02, 0.3, 0.6]), title=HOSTILE)
    text = result_page(ds, pictures_of(ds))
    page = Page(text)
    assert {"script", "link", "iframe"}.isdisjoint(tag for tag, _ in page.elements)
    assert not re.search(r"@import|url\(|https?://", re.sub(r"base64,[^\"]*", "", text))
    assert [image["src"][:11] for image in page.images()] == ["data:image/"] * 3
    assert all(image["alt"] for image in page.images())


CELLS = "Regimes of the cells, and how they were found"


def test_a_page_of_a_map_says_what_one_needs_to_read_it():
    ds = plane(rows=6, columns=8)
    page = page_of(ds)
    cells = int((ds["regime"] == REGIMES.index("stick_slip")).sum())
    shares = page.sections[CELLS].split()
    assert shares[shares.index("stick-slip") + 1 :][:2] == [str(cells), f"{cells / 48:.2%}"]
    assert "0.1 N/m; 0.630957 N/m; 3.98107 N/m" in page.sections["What varies, and what is held fixed"]
    assert "normal load\n1 N\n" in page.sections["What varies, and what is held fixed"]
    assert "a limit cycle with a stick phase" in page.sections["What the words mean"]
    assert "never breaks away" not in page.sections["What the words mean"]
    assert "title: made up µ" in page.sections["Where this comes from"]


def test_undecided_cells_are_counted_by_their_reason():
    ds = plane()
    ds["regime"][0, :3] = REGIMES.index("unresolved")
    ds["status"][0, :2], ds["status"][0, 2] = STATUSES.index("step_limit"), STATUSES.index("horizon_reached")
    page = page_of(ds)
    rows = page.sections[CELLS].splitlines()
    assert rows[rows.index(STATUS_MESSAGES["step_limit"]) - 2] == "2"
    assert rows[rows.index(STATUS_MESSAGES["horizon_reached"]) - 2] == "1"
    text = result_page(ds, [])
    assert "3 cells are not decided" in text and 'class="warning"' in text


def test_a_picture_that_cannot_be_drawn_is_replaced_by_the_reason():
    ds = plane()
    ds["regime"][:] = REGIMES.index("damped")
    ds["period"][:] = np.nan
    said = [one.caption for one in pictures_of(ds) if one.figure is None]
    assert len(said) == 1 and "no cell has a value of period" in said[0]
    assert "the reason" in Page(result_page(ds, [Picture("the reason")])).sections["The picture"]


def test_results_that_are_no_maps_have_pages():
    text = """
system: {mass: 1, stiffness: 1 N/mm, normal_load: 1 N, damping: 0, belt_speed: 1}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 100 mm/s}
"""
    borders = stickslip.run(parse_config(text + "border: {along: belt_speed, between: [10 mm/s, 2 m/s]}\n"))
    page = Page(result_page(borders, []))
    assert "border tolerance\n1e-09" in page.sections["What was found"]
    place = f"{float(borders['border'].values.item()) * 1e3:.12g} mm/s"
    assert f"{place}\nstick-slip\ndamped\n" in page.sections["The borders"]
    none = borders.assign(border=borders["border"] * np.nan)
    assert "\nnone\n" in Page(result_page(none, [])).sections["The borders"]
    uncertain = (
        text
        + "axes: {belt_speed: [0.1, 0.9]}\n"
        + ("uncertain: {quantities: {damping: {uniform: {low: 0, high: 1}}}, draws: 64}\n")
    )
    ds = stickslip.run(parse_config(uncertain.replace(", damping: 0, belt_speed: 1", "")))
    page = Page(result_page(ds, pictures_of(ds)))
    assert len(page.images()) == 1 and "probability of a regime" in page.sections["What the words mean"]
    assert "1 N/mm" in page.sections["What varies, and what is held fixed"]


def test_a_page_promises_only_what_holds_for_its_result():
    ds = plane()
    assert "gives the same result again" in result_page(ds, []) and "within the width of a cell" in result_page(ds, [])
    ramp = ds.expand_dims(direction=["up", "down"]).assign_attrs(result="ramp")
    assert "gives the same result again" not in (text := result_page(ramp, [])) and "width of a cell" not in text


def test_a_title_may_be_given():
    assert "<h1>Mine &amp; yours</h1>" in result_page(plane(), [], title="Mine & yours")
    drawn = pictures_of(plane().drop_vars("period"), title="Mine")
    assert [one.figure.axes[0].get_title() for one in drawn] == ["Mine"] * len(drawn) and drawn
    assert "<figcaption>linear damping ratio" in result_page(plane(), drawn)


def test_parts_escape_their_text():
    columns = pages.Column(HOSTILE, HOSTILE), pages.Column("b", is_text=True)
    html = pages.table(columns, [[HOSTILE, pages.PageCell(HOSTILE, "green")]]) + pages.terms([(HOSTILE, HOSTILE)])
    html += pages.paragraph(HOSTILE) + pages.warning(HOSTILE) + pages.configuration(HOSTILE)
    assert "<script" not in html and html.count("&lt;script&gt;") == 9


def test_a_page_is_whole_or_not_there(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(StoreError, match="cannot be written"):
        pages.write_page(tmp_path / "file" / "x.html", "text")
    assert pages.write_page(tmp_path / "ü.html", "text").read_text(encoding="utf-8") == "text"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "ü.html"]
