"""What goes to a boss: a page of two sheets, a picture for a slide, tables that open in Excel."""

import numpy as np
import pytest

import stickslip
from helpers.commands import call
from helpers.data import cases
from stickslip import plots
from stickslip.plots.layout import inches, resize
from stickslip.plots.marks import marks_in
from stickslip_materials.compare.table import material_page

NAMES = [
    "Fett A (lithiumverseift, Öl ISO VG 68)", "Gleitlack Größe 2 – äußere Führung Süd", "PTFE", "Trocken", "Wachs $1$",
    "Polyharnstofffett mit Festschmierstoffen", "Silikonfett, hochviskos, Charge 2024-11", "=cmd|' /C calc'!A0",
    "Kalziumsulfonat-Komplexfett, Prüfmuster Ü", "Molybdändisulfid-Paste auf Naßschicht 9",
]  # fmt: skip
SLIDE = 16 / 2.54, 9 / 2.54  # inches
MAP = """\
title: small
system: {mass: 100 g, normal_load: 10 N}
friction: {a1: 1.0, a2: 0.1, a3: 0.3, a4: 0.1}
axes:
  stiffness: {start: 100 N/m, stop: 10000 N/m, num: 6, spacing: log}
  belt_speed: {start: 10 mm/s, stop: 1200 mm/s, num: 8}
"""


@pytest.fixture(scope="module")
def ten():
    speed = np.geomspace(0.5e-3, 0.5, 24)
    scatter = np.random.default_rng(3).normal(size=(10, 24))
    points = {
        name: (speed, (0.06 + 0.03 * k + 0.1 * speed + (0.03 + 0.02 * k) * np.exp(-speed / (0.006 + 0.003 * k)))
               * (1 + 0.02 * scatter[k]))
        for k, name in enumerate(NAMES)
    }  # fmt: skip
    return stickslip.compare(
        points, mass=0.1, stiffness=5000, normal_load=10, damping=1, belt_speed="30 mm/s", draws=50
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("map")
    (path / "small.yaml").write_text(MAP)
    assert call("run", path / "small.yaml", "-o", path / "map.nc", "-q").exit_code == 0
    return path


def share_of(artist, figure):
    box = artist.get_window_extent()
    return box.width * box.height / (figure.bbox.width * figure.bbox.height)


def test_a_slide_of_ten_materials_has_its_names_beside_the_data_in_a_quarter(ten):
    figure = plots.plot_materials(ten)
    resize(figure, *SLIDE)
    figure.draw_without_rendering()
    names = {"".join(name.split()) for name in NAMES}
    rows = [text for text in figure.axes[1].texts if "".join(text.get_text().split()) in names]
    assert len(rows) == 10
    boxes = [text.get_window_extent() for text in rows]
    assert all(not box.overlaps(ax.get_window_extent()) for box in boxes for ax in figure.axes)
    assert all(upper.y0 >= lower.y1 - 1 for upper, lower in zip(boxes, boxes[1:], strict=False))
    assert max(box.x1 for box in boxes) <= figure.bbox.width
    assert figure.bbox.width - min(box.x0 for box in boxes) <= 0.25 * figure.bbox.width
    assert all(share_of(one, figure) <= 0.25 for one in figure.legends)
    assert min(ax.get_window_extent().height for ax in figure.axes) > 0.5 * figure.bbox.height


def test_the_page_begins_with_answer_table_and_picture(ten):
    text = material_page(ten)
    order = ["at 0.03 m/s", "<table>", "<img ", "<h2>The fitted curves", 'id="configuration"']
    places = [text.index(one) for one in order]
    assert places == sorted(places)


POINTS = "label;stiffness [N/mm];Belt speed (mm/s)\nFett 1: gut, Öl;0,9;90\nB;2;400\nC;0,2;700\nD;0,1;1100\n"


def test_marks_of_a_file_have_a_legend_below_the_axes(folder, monkeypatch):
    (folder / "points.csv").write_text(POINTS, encoding="utf-8")
    drawn = []

    def save(figure, _path, dpi, size):
        resize(figure, *inches(size, dpi))
        drawn.append(figure)

    monkeypatch.setattr(plots, "save", save)
    done = call("plot", folder / "map.nc", "--mark", folder / "points.csv", "--size", "16 cm x 9 cm")
    assert done.exit_code == 0, done.output
    first, *_ = marks_in(stickslip.open(folder / "map.nc"), folder / "points.csv")
    assert dict(first.at) == pytest.approx({"stiffness": 900.0, "belt_speed": 0.09})
    figure = drawn[0]
    figure.draw_without_rendering()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert any("1: Fett 1: gut, Öl" in " ".join(label.split()) for label in labels)
    assert not figure.legends[0].get_window_extent().overlaps(figure.axes[0].get_window_extent())
    rings = [line for line in figure.axes[0].lines if line.get_marker() == "o"]
    assert len(rings) == 4 and all(line.get_linestyle() == "None" for line in rings)


@cases("materials.yaml")
def test_a_file_of_marks_that_is_wrong_is_refused_with_its_line(folder, tmp_path, text, said):
    (tmp_path / "points.csv").write_text(text)
    done = call("plot", folder / "map.nc", "--mark", tmp_path / "points.csv", "-o", tmp_path / "x.png")
    assert done.exit_code == 2 and said in done.stderr and not (tmp_path / "x.png").exists()


def test_borders_and_comparisons_are_drawn_from_python_as_by_the_command(ten):
    text = MAP + "border: {along: belt_speed, scan: 8}\n"
    config = stickslip.config.reader.parse_config(text)
    figure = stickslip.run(config).stickslip.plot()
    assert figure.axes[0].get_xlabel().startswith("belt speed") and len(figure.axes[0].collections) > 1
    assert len(ten.stickslip.plot().axes) == 2


def test_named_points_are_not_joined_by_lines(ten):
    figure = plots.plot_map(ten, "quiet_above")
    assert not [
        line for ax in figure.axes for line in ax.lines if line.get_linestyle() == "-" and len(line.get_xdata()) == 10
    ]
