"""The page: its figures, its words, its buttons, and the template that puts them in their places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

from bokeh.events import MouseLeave, MouseMove
from bokeh.models import Button, ColumnDataSource, CustomJS, Div, UIElement

from stickslip.explore import scripts
from stickslip.explore.figures import LINES, CellFigures, MapFigure
from stickslip.explore.maps import Picture
from stickslip.explore.motions import CellMotions, Motion
from stickslip.explore.readable import Unit
from stickslip.explore.subject import Subject
from stickslip.explore.told import legend_html, numbers_html
from stickslip.plots.palette import FLAG_COLOURS

_LINES_CSS = "\n".join(
    f".line.{name} {{ border-top: {width + 1}px {'dashed' if dash != 'solid' else 'solid'} {colour}; }}"
    for name, (colour, dash, width) in LINES.items()
)
_REGIMES_CSS = "\n".join(
    f".regime.{name} {{ border-color: {colour}; }}" for name, colour in FLAG_COLOURS["regime"].items()
)
WIDGETS = ":host { font-size: 13px; --font-size: 13px; } .bk-slider-title, label { color: #1b1b1b; }"
_WORDS = f"""
:host {{ font: 13px/1.45 system-ui, sans-serif; color: #1b1b1b; width: 100%; }}
.legend {{ display: flex; flex-wrap: wrap; gap: 2px 14px; align-items: center; padding: 2px 4px; }}
.legend i {{ display: inline-block; width: 13px; height: 13px; border: 1px solid #333; margin-right: 4px;
  vertical-align: -2px; }}
.note, .hint {{ color: #5a5a5a; }} .hint {{ margin: 4px 0; }}
.scale {{ flex: 1 1 260px; max-width: 460px; }} .scale .bar {{ height: 12px; border: 1px solid #333; }}
.ticks {{ display: flex; justify-content: space-between; font-size: 11px; white-space: nowrap; }}
.numbers {{ border-collapse: collapse; margin-top: 4px; font-variant-numeric: tabular-nums; }}
.numbers th {{ text-align: left; font-weight: 400; color: #444; padding: 1px 14px 1px 0; }}
.numbers td {{ text-align: right; padding: 1px 0 1px 18px; white-space: nowrap; }}
.numbers tr:first-child th {{ color: #1b1b1b; font-weight: 600; text-align: right; padding: 1px 0 3px 18px; }}
.numbers tr {{ border-bottom: 1px solid #ececec; }}
.line {{ display: inline-block; width: 26px; margin-right: 6px; vertical-align: middle; }}
{_LINES_CSS}
.regime {{ border-bottom: 3px solid; padding: 0 2px; }}
{_REGIMES_CSS}
.error {{ color: #9c1c00; white-space: pre-wrap; font-family: ui-monospace, monospace; font-size: 12px; }}
pre {{ white-space: pre-wrap; overflow-wrap: anywhere; background: #f5f5f5; padding: 6px 8px; margin: 4px 0;
  font: 12px/1.4 ui-monospace, monospace; max-height: 260px; overflow: auto; }}
summary {{ cursor: pointer; }}
"""


class Page:
    """All that is on the page but the widgets beside the map; its parts are named as their places in the template."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.map, self.cell = MapFigure(), CellFigures()
        self.columns = ColumnDataSource({}, name="map_columns")
        self.legend, self.status = words("legend"), words("status")
        self.cell_words, self.numbers = words("cell_words"), words("numbers", numbers_html([]))
        self.map.plot.js_on_event(MouseMove, CustomJS(args={"columns": self.columns}, code=scripts.READOUT))
        self.map.plot.js_on_event(MouseLeave, CustomJS(code=scripts.HIDE_READOUT))

    @property
    def roots(self) -> list[UIElement]:
        """What is embedded in the template, by their names."""
        return [self.map.plot, *self.cell.plots, self.legend, self.status, self.cell_words, self.numbers]

    def show_map(self, shown: Picture) -> None:
        """Draw a picture, with its legend and the numbers under the pointer."""
        self.map.show(shown)
        self.columns.data = columns_data(shown)
        self.columns.tags = [scripts.meta_of(shown)]
        self.legend.text = legend_html(shown)

    def show_cell(
        self, current: CellMotions | None, pinned: Mapping[str, CellMotions], said: str, units: Mapping[str, Unit]
    ) -> None:
        """Draw the motions of the clicked cell and of the pinned ones, and say their numbers, in units by variable."""
        self.cell.show(current, pinned)
        self.cell_words.text = said
        self.numbers.text = numbers_html(columns_of(current, pinned), units)


def columns_data(shown: Picture) -> dict[str, Any]:
    """The numbers of all pixels as columns of a source."""
    return {one.name: one.values.ravel() for one in shown.columns}


def columns_of(current: CellMotions | None, pinned: Mapping[str, CellMotions]) -> list[tuple[str, str, Motion]]:
    """The motions that are told side by side: names of their lines, headings, and they themselves."""
    found = []
    if current is not None:
        found.append(("stick", current.stick.label, current.stick))
        if current.sliding is not None:
            found.append(("sliding", current.sliding.label, current.sliding))
    return [*found, *((name, name, one.stick) for name, one in pinned.items())]


def words(name: str, text: str = "") -> Div:
    """A place for words. What stands between dollars in them is no formula: MathJax would make links of `\\href`."""
    return Div(text=text, name=name, disable_math=True, sizing_mode="stretch_width", stylesheets=[_WORDS])


def button(label: str, name: str) -> Button:
    """A button."""
    return Button(label=label, name=name, stylesheets=[WIDGETS])


def template_variables(subject: Subject, names: Sequence[str]) -> dict[str, Any]:
    """What the template has to know. names : of the roots."""
    return {
        "heading": subject.config.title or "Stick-slip explorer", "source": subject.source,
        "notes": "; ".join(subject.notes), "names": list(names),
    }  # fmt: skip


def template() -> str:
    """The HTML around the roots."""
    return files("stickslip.explore").joinpath("page.html").read_text(encoding="utf-8")
