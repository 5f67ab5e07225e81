"""The little that runs in the browser: what a cell says under the pointer, copies, downloads."""

from __future__ import annotations

from typing import Any

from stickslip.dataset.axis import spoken

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
    """What `READOUT` has to know of a picture."""
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
