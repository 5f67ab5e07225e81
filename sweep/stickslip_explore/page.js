// What runs in the browser. Bokeh calls these functions with the models that Python gives them by name, and the event.
"use strict"
const stickslip = (() => {
  const digits = (value) => String(Number(value.toPrecision(4)))
  const ends = (data) => [Math.min(data.start, data.end), Math.max(data.start, data.end)]

  // --- axes, whose places are logarithms to base 10 --------------------------------------------------------------------

  // Decades; with fewer of them in sight multiples; then even steps of the value.
  function log_ticks(data) {
    const [low, high] = ends(data), span = high - low, ticks = []
    if (span < 0.5) {
      const [a, b] = [10**low, 10**high]
      const raw = (b - a)/6, unit = 10**Math.floor(Math.log10(raw))
      const step = unit*[1, 2, 5, 10].find((k) => unit*k >= raw)
      for (let v = Math.ceil(a/step)*step; v <= b; v += step) ticks.push(Math.log10(v))
      return ticks
    }
    const every = Math.max(1, Math.ceil(span/9))
    const factors = span > 3 ? [1] : span > 1.2 ? [1, 2, 5] : [1, 2, 3, 4, 5, 7]
    for (let k = Math.floor(low); k <= Math.ceil(high); k++) {
      if (k % every == 0) for (const f of factors) ticks.push(k + Math.log10(f))
    }
    return ticks.filter((t) => t >= low - 1e-9 && t <= high + 1e-9)
  }

  function log_minor_ticks(data) {
    const [low, high] = ends(data), ticks = []
    if (high - low > 6 || high - low < 0.5) return ticks
    for (let k = Math.floor(low); k <= Math.ceil(high); k++) for (let f = 1; f < 10; f++) ticks.push(k + Math.log10(f))
    return ticks.filter((t) => t >= low && t <= high)
  }

  function log_label(tick) {
    const value = Number((10**tick).toPrecision(4))
    return value >= 1e6 || value < 1e-4 ? value.toExponential().replace("e+", "e") : value.toString()
  }

  // A place on a slider as a value in its unit; what is smaller than `least` came of rounding.
  function place_label(tick, log, unit, least) {
    return `${digits(log ? 10**tick : Math.abs(tick) < least ? 0 : tick)} ${unit}`.trim()
  }

  // --- under the pointer: the cell in words ----------------------------------------------------------------------------

  // `columns` has the numbers of all pixels, its tag says what they are.
  function read_out({columns}, event) {
    const box = document.getElementById("readout")
    const meta = columns.tags[0]
    if (box == null || meta == null) return
    const pixel = (side, place) => {
      const i = Math.floor((place - side.low)/(side.high - side.low)*side.n)
      return i >= 0 && i < side.n ? i : null
    }
    const words = (side, i) => {
      if (side.labels.length > 0) return side.labels[i]
      const place = side.low + (i + 0.5)*(side.high - side.low)/side.n
      return `${digits(side.log ? 10**place : place)} ${side.unit}`
    }
    const [i, j] = [pixel(meta.x, event.x), pixel(meta.y, event.y)]
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
    const right = event.sx + 18 + box.offsetWidth < room.width
    box.style.left = `${right ? event.sx + 18 : Math.max(0, event.sx - 12 - box.offsetWidth)}px`
    box.style.top = `${Math.max(0, Math.min(event.sy + 12, room.height - box.offsetHeight))}px`
  }

  function hide_readout() {
    const box = document.getElementById("readout")
    if (box != null) box.style.display = "none"
  }

  // --- buttons ---------------------------------------------------------------------------------------------------------

  // One sound at a time.
  function play({wave}) {
    const [wav] = wave.data.wav
    if (wav == null) return
    window.stickslip_sound?.pause()
    window.stickslip_sound = new Audio(`data:audio/wav;base64,${wav}`)
    window.stickslip_sound.play().catch((error) => console.warn(`no sound: ${error}`))
  }

  function copy({texts, which, button, label}) {
    navigator.clipboard.writeText(texts.tags[0]?.[which] ?? "").then(
      () => { button.label = "copied"; setTimeout(() => { button.label = label }, 1200) },
      () => { button.label = "not allowed by the browser"; setTimeout(() => { button.label = label }, 2000) },
    )
  }

  // --- a page without a server: what its Python would show -------------------------------------------------------------

  const sheet_of = ({sheets, point}) => sheets.tags[Number(point.value)]

  function paint(page) {
    const picture = sheet_of(page).pictures[page.variable.value]
    page.mapper.palette = picture.palette
    page.cells.data = {...page.cells.data, image: [picture.shades]}
    page.regions.data = picture.regions
    page.legend.text = picture.legend
  }

  function draw_nearest(page, at) {
    const {x, y} = page.columns.tags[0], wide = x.high - x.low, high = y.high - y.low
    let nearest = null, least = Infinity
    for (const cell of sheet_of(page).cells) {
      const away = ((cell.x - at.x)/wide)**2 + ((cell.y - at.y)/high)**2
      if (away < least) { least = away; nearest = cell }
    }
    for (const [name, source] of Object.entries(page.sources)) source.data = nearest.data[name]
    page.mark.data = {x: [nearest.x], y: [nearest.y]}
    for (const [plot, [below, left]] of Object.entries(nearest.titles)) {
      page.plots[plot].below[0].axis_label = below
      page.plots[plot].left[0].axis_label = left
    }
    for (const line of page.belt) { line.location = nearest.belt; line.visible = true }
    page.cell_words.text = nearest.words
    page.numbers.text = nearest.numbers
  }

  function click(page, event) {
    const {x, y} = page.columns.tags[0]
    if (event.x < x.low || event.x > x.high || event.y < y.low || event.y > y.high) return
    draw_nearest(page, event)
  }

  function turn(page) {
    paint(page)
    const {columns, meta} = sheet_of(page), {x, y} = page.mark.data
    page.columns.data = columns
    page.columns.tags = [meta]
    if (x.length > 0) draw_nearest(page, {x: x[0], y: y[0]})
  }

  return {
    log_ticks, log_minor_ticks, log_label, place_label, read_out, hide_readout, play, copy, paint, click, turn,
  }
})()
