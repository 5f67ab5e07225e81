"""The page: its figures, words and buttons, the template around them, and the little that runs in the browser."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

from bokeh.document import Document
from bokeh.events import MouseLeave, MouseMove
from bokeh.models import ColumnDataSource, CustomJS, Div, UIElement

from stickslip.dataset.display import spoken
from stickslip.explore.figures import LINES, CellFigures, MapFigure, motions_by_line
from stickslip.explore.html import legend_html, numbers_html
from stickslip.explore.maps import Picture
from stickslip.explore.motions import CellMotions, Motion
from stickslip.explore.source import Source
from stickslip.plots.palette import FLAG_COLOURS
from stickslip.vocabulary.display_units import Unit

# Under the pointer: the cell in words. `columns` has the numbers of all pixels, its tag says what they are.
READOUT = """
const box = document.getElementById("readout")
const meta = columns.tags[0]
if (box == null || meta == null) return
const pixel = (side, place) => {
  const i = Math.floor((place - side.low)/(side.high - side.low)*side.n)
  return i >= 0 && i < side.n ? i : null
}
const digits = (value) => String(Number(value.toPrecision(4)))
const words = (side, i) => {
  if (side.labels.length > 0) return side.labels[i]
  const place = side.low + (i + 0.5)*(side.high - side.low)/side.n
  return `${digits(side.log ? 10**place : place)} ${side.unit}`
}
const [i, j] = [pixel(meta.x, cb_obj.x), pixel(meta.y, cb_obj.y)]
if (i == null || j == null) { box.style.display = "none"; return }
const rows = [[meta.x.label, words(meta.x, i)], [meta.y.label, words(meta.y, j)]]
for (const column of meta.columns) {
  const value = columns.data[column.name][j*meta.x.n + i]
  if (!Number.isFinite(value)) continue
  if (column.names.length > 0) rows.push([column.label, column.names[value]])
  else rows.push([column.label, `${digits(value)} ${column.unit}`])
}
const cell = (kind, text) => { const one = document.createElement(kind); one.textContent = text; return one }
const table = document.createElement("table")
for (const [name, text] of rows) {
  const row = document.createElement("tr")
  row.append(cell("th", name), cell("td", text))
  table.append(row)
}
box.replaceChildren(table)
box.style.display = "block"
const room = box.parentElement.getBoundingClientRect()
const right = cb_obj.sx + 18 + box.offsetWidth < room.width
box.style.left = `${right ? cb_obj.sx + 18 : Math.max(0, cb_obj.sx - 12 - box.offsetWidth)}px`
box.style.top = `${Math.max(0, Math.min(cb_obj.sy + 12, room.height - box.offsetHeight))}px`
"""
HIDE_READOUT = """
const box = document.getElementById("readout")
if (box != null) box.style.display = "none"
"""
# A text that the server has put together, as a file of the person who asked for it.
DOWNLOAD = """
const [name] = box.data.name, [text] = box.data.text
if (name == null) return
const link = document.createElement("a")
link.href = URL.createObjectURL(new Blob([text], {type: "text/plain;charset=utf-8"}))
link.download = name
link.click()
setTimeout(() => URL.revokeObjectURL(link.href), 10000)
"""
# One sound at a time.
PLAY = """
const [wav] = wave.data.wav
if (wav == null) return
window.stickslip_sound?.pause()
window.stickslip_sound = new Audio(`data:audio/wav;base64,${wav}`)
window.stickslip_sound.play().catch((error) => console.warn(`no sound: ${error}`))
"""
COPY = """
const text = texts.tags[0]?.[which] ?? ""
navigator.clipboard.writeText(text).then(
  () => { button.label = "copied"; setTimeout(() => { button.label = label }, 1200) },
  () => { button.label = "not allowed by the browser"; setTimeout(() => { button.label = label }, 2000) },
)
"""


def meta_of(shown: Any) -> dict[str, Any]:
    """The data of a picture that `READOUT` reads."""
    sides = {
        which: {
            "label": spoken(side.name), "low": side.ends[0], "high": side.ends[1], "n": len(side.centres),
            "log": side.kind == "log", "unit": side.unit.name, "labels": list(side.labels),
        }
        for which, side in (("x", shown.x), ("y", shown.y))
    }  # fmt: skip
    columns = [
        {"name": one.name, "label": one.label, "unit": one.unit.name, "names": list(one.names)} for one in shown.columns
    ]
    return {**sides, "columns": columns}


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

    def __init__(self, source: Source) -> None:
        self.source = source
        self.map, self.cell = MapFigure(), CellFigures()
        self.columns = ColumnDataSource({}, name="map_columns")
        self.legend, self.status = words("legend"), words("status")
        self.cell_words, self.numbers = words("cell_words"), words("numbers", numbers_html([]))
        self.map.plot.js_on_event(MouseMove, CustomJS(args={"columns": self.columns}, code=READOUT))
        self.map.plot.js_on_event(MouseLeave, CustomJS(code=HIDE_READOUT))

    @property
    def roots(self) -> list[UIElement]:
        """The models that are embedded in the template, by their names."""
        return [self.map.plot, *self.cell.plots, self.legend, self.status, self.cell_words, self.numbers]

    def show_map(self, shown: Picture) -> None:
        """Draw a picture, with its legend and the numbers under the pointer."""
        self.map.show(shown)
        self.columns.data, self.columns.tags = columns_data(shown), [meta_of(shown)]
        self.legend.text = legend_html(shown)

    def show_cell(
        self, current: CellMotions | None, pinned: Mapping[str, CellMotions], text: str, units: Mapping[str, Unit]
    ) -> None:
        """Draw the motions of the clicked cell and of the pinned ones, and say their numbers, in units by variable."""
        self.cell.show(current, pinned)
        self.cell_words.text = text
        self.numbers.text = numbers_html(columns_of(current, pinned), units)


def columns_data(shown: Picture) -> dict[str, Any]:
    """The numbers of all pixels as columns of a source."""
    return {column.name: column.values.ravel() for column in shown.columns}


def columns_of(current: CellMotions | None, pinned: Mapping[str, CellMotions]) -> list[tuple[str, str, Motion]]:
    """The motions whose numbers stand side by side: names of their lines, headings, and they themselves."""
    return [
        (line, line if line in pinned else motion.label, motion)
        for line, motion in motions_by_line(current, pinned).items()
    ]


def words(name: str, text: str = "") -> Div:
    """A place for words. What stands between dollars in them is no formula: MathJax would make links of `\\href`."""
    return Div(text=text, name=name, disable_math=True, sizing_mode="stretch_width", stylesheets=[_WORDS])


def fill(document: Document, page: Page, roots: Sequence[UIElement], notes: Sequence[str]) -> None:
    """Give a document its roots, and what the template around them (`page.html`) has to know."""
    with document.models.freeze():  # each root would have all models counted again
        for root in roots:
            document.add_root(root)
    source = page.source
    document.template = files("stickslip.explore").joinpath("page.html").read_text(encoding="utf-8")
    document.title = f"{source.config.title} - stickslip"
    document.template_variables.update(
        heading=source.config.title or "Stick-slip explorer", source=source.name, notes="; ".join(notes),
        names=[str(root.name) for root in roots],
    )  # fmt: skip
