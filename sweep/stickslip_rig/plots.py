"""Plots of a rig: records over time, and a test matrix as a heat map."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, log, prod
from textwrap import fill, shorten
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stickslip.dataset import display as axis
from stickslip.dataset.display import si_unit
from stickslip.errors import PlotError
from stickslip.plots import palette
from stickslip.plots.layout import Figure, show_verbatim
from stickslip.plots.painting import hatch_cells
from stickslip.plots.palette import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION
from stickslip.vocabulary.display_units import number
from stickslip_rig.labels import Dimension, dimensions, unit_for
from stickslip_rig.quantities import EXACT, FEATURES, SIGNALS
from stickslip_rig.records import force_of
from stickslip_rig.risk import BANDS, RPN_NAME, UNDEFINED, rpn_text
from stickslip_rig.signals import Flags, Floats, gaps_of

SERIES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)  # of records, in this order
LIGHTS = {"unknown": GREY, "green": GREEN, "yellow": ORANGE, "red": VERMILLION}  # in the order of codes
MEANINGS = {  # the article's, page 4
    "green": "low noise, no stick-slip",
    "yellow": "noise and stick-slip can occur",
    "red": "bad noise and stick-slip",
}
RPN, BAND = "model_rpn", "model_rpn_band"
_PIXELS = 3000  # across; more samples than that are plotted as the range of each pixel
_LEGEND = 130  # characters across the figure
_ROOM = 2.2  # times its range: the right axis, so that the acceleration leaves the force readable
_IN_A_ROW = 4  # records beside each other
_CELL = (0.46, 0.29)  # inches: width and height of a cell where there is room
_LARGEST = (10.0, 10.5)  # inches: of all cells together
_ASPECT = 0.8  # width over height of all cells that fits a page
_NARROWEST = 3.8  # inches: of a line of the title
_POINTS = 72  # per inch
_FONT, _SMALLEST_NUMBER = 8.5, 4.0  # points
_DIGIT = 0.64  # width of a digit, in sizes of its letters
_LONGEST_LABEL = 30  # letters
_GAP, _MARGIN = 7.0, 9.0  # points
_HATCH = "////"  # of red cells, whose colour is as dark as green


def plot_records(
    records: Mapping[str, xr.Dataset],
    *,
    beside: bool = False,
    numbers: Mapping[str, float] | None = None,
    heading: str = "",
    window: tuple[float, float] | None = None,
) -> Figure:
    """Plot force and acceleration of records over time.

    One record is drawn as in the article: force in colour, acceleration black. Of several, the acceleration has the
    colour of the force, thin. Gaps are left blank.

    Parameters
    ----------
    records
        By name.
    beside
        Each in a panel of its own, instead of over each other.
    numbers
        The model RPN of each, "?" for NaN.
    heading
        Of the figure.
    window
        Part of each record to draw, s since its start.
    """
    parts = [_part(record, window) for record in records.values()]
    labels = [f"{name}: {rpn_text(numbers[name])}" if numbers and name in numbers else name for name in records]
    columns = min(_IN_A_ROW, len(parts)) if beside else 1
    rows = -(-len(parts) // columns) if beside else 1
    figure = Figure(figsize=(10.0, 1.2 + 3.6 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False).ravel().tolist()
    twins = [panel.twinx() for panel in panels]
    handles = []
    for i, (name, part) in enumerate(zip(labels, parts, strict=True)):
        name = f" {name}" if name.startswith("_") else name  # which would hide it from the legend
        name += " (shaded: no samples)" * bool(gaps_of(part["time"].values).size)
        force, acceleration = panels[i * beside], twins[i * beside]
        colour = SERIES[i % len(SERIES)]
        _draw(force, part, force_of(part), color=colour, linewidth=1.3)
        thin = {"color": BLACK, "linewidth": 0.7} if len(parts) == 1 else {"color": colour, "linewidth": 0.5}
        if "acceleration" in part:
            _draw(acceleration, part, part["acceleration"].values, alpha=0.55, **thin)
        if beside:
            force.set_title(name, fontsize="medium")
        handles.append(Line2D([], [], color=colour, label=name))
    for panel in panels[len(parts) :]:
        panel.set_axis_off()
    shown = next((part["acceleration"] for part in parts if "acceleration" in part), None)
    _name_axes(panels, twins, parts[0], shown, columns)
    if shown is not None:
        _share_zero(panels[0], twins)
    if numbers and beside:
        figure.supxlabel(f"in titles: {RPN_NAME}", fontsize="small")
    if not beside:
        longest_name = max(len(str(handle.get_label())) for handle in handles)
        in_a_row = max(1, min(4, len(handles), _LEGEND // (longest_name + 8)))
        legend = figure.legend(handles=handles, loc="outside lower center", ncols=in_a_row, frameon=False)
        legend.set_title(RPN_NAME if numbers else "")
    if heading:
        figure.suptitle(heading, fontsize="large")
    return figure


def _part(record: xr.Dataset, window: tuple[float, float] | None) -> xr.Dataset:
    """The samples to draw; the attribute `start` is when the record starts."""
    record = record.assign_attrs(start=float(record["time"][0]))
    if window is None:
        return record
    since = (record["time"] - record.attrs["start"]).values
    inside = (since >= window[0]) & (since <= window[1])
    return record.isel(time=inside) if inside.sum() > 1 else record


def _draw(ax: Axes, record: xr.Dataset, values: Floats, **style: Any) -> None:
    """A line since the start, broken at gaps; of more samples than pixels, the smallest and largest of each pixel."""
    time = record["time"].values - record.attrs["start"]
    gaps = gaps_of(time)
    for piece in np.split(np.arange(time.size), gaps + 1):
        x, y, block = time[piece], values[piece], time.size // _PIXELS
        if block > 2:
            whole = max(1, x.size // block)
            edges = np.linspace(0, x.size, whole, endpoint=False).astype(np.intp)
            x = np.repeat(x[edges], 2)
            y = np.stack([np.minimum.reduceat(y, edges), np.maximum.reduceat(y, edges)], axis=1).ravel()
        ax.plot(x, y, **style)
    for gap in gaps.tolist():
        ax.axvspan(time[gap], time[gap + 1], color=style["color"], alpha=0.12, linewidth=0)


def _name_axes(
    panels: Sequence[Axes], twins: Sequence[Axes], record: xr.Dataset, acceleration: xr.DataArray | None, columns: int
) -> None:
    """The names and ticks of the axes: force at the left of a row, acceleration, if recorded, at its right."""
    name = "spring_force" if "spring_force" in record else "friction_force"
    label = axis.title(record[name], si_unit(record[name]))
    force = f"force as the rig measures it ({SIGNALS[name].units})" if name == "spring_force" else label
    for i, (panel, twin) in enumerate(zip(panels, twins, strict=True)):
        panel.set_zorder(twin.get_zorder() + 1)  # forces are drawn over accelerations
        panel.patch.set_visible(False)
        panel.set_xlabel("time since the start (s)")
        panel.margins(x=0.01)
        if i % columns == 0:
            panel.set_ylabel(force)
        last = i % columns == columns - 1
        twin.tick_params(labelright=last)
        twin.set_visible(acceleration is not None)
        if last and acceleration is not None:
            twin.set_ylabel(axis.title(acceleration, si_unit(acceleration)))


def _share_zero(force_axis: Axes, acceleration_axes: Sequence[Axes]) -> None:
    """Zero at the same height on all axes, as much room above as the force takes, and room around the acceleration."""
    low, high = force_axis.get_ylim()
    largest = max(abs(end) for axis in acceleration_axes for end in axis.get_ylim()) or 1.0
    height = max(-low, high, 1e-30)
    low, high = min(low, -height / _ROOM), max(high, height / _ROOM)  # the acceleration swings to both sides
    scale = _ROOM * largest / height
    force_axis.set_ylim(low, high)
    for other in acceleration_axes:
        other.set_ylim(low * scale, high * scale)


# --- matrices ---------------------------------------------------------------------------------------------------------


def plot_matrix(ds: xr.Dataset, variable: str = RPN) -> Figure:
    """Plot one number of every test of a matrix as a heat map, like the table of a printed test report.

    Leading dimensions run down the rows, the others along the columns, the last of each fastest; an outer point is
    named in the middle of its rows or columns. The model RPN, and its band, in the colours of the traffic light, red
    hatched, "?" where it is not known; how the integration ended in the colours of maps; everything else from dark to
    light with a colour bar. Numbers are left out where cells are too small for them.

    Parameters
    ----------
    ds
        As of `run_matrix`, of any number of dimensions.
    variable
        A feature, what the integration gives, or the model RPN.

    Raises
    ------
    PlotError
        For a variable that is not one number a test, and for no tests.
    """
    array = _checked(ds, variable)
    rows, columns = _split(dimensions(ds, array.dims))
    shape = (_size(rows), _size(columns))
    look = _lights(ds, shape) if variable in (RPN, BAND) else _numbers(array, shape)
    width, height = min(_CELL[0], _LARGEST[0] / shape[1]), min(_CELL[1], _LARGEST[1] / shape[0])
    figure = Figure(figsize=(width * shape[1], height * shape[0]))
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    line = min(1.0, 0.04 * _POINTS * min(width, height))
    mesh = ax.pcolormesh(look.values, cmap=look.colours, norm=look.norm, edgecolors="white", linewidth=line)
    if look.is_hatched is not None:
        edges = (np.arange(length + 1.0) for length in reversed(shape))
        hatch_cells(ax, look.is_hatched, _HATCH, LIGHTS["red"], *edges)
    for dims, draw in ((columns, ax.axvline), (rows, ax.axhline)):
        for end in range(_size(dims[-1:]), _size(dims), _size(dims[-1:])):
            draw(end, color="white", linewidth=3.5 * line)
    is_written = _write_numbers(ax, look, mesh.to_rgba(look.values), _POINTS * width, _POINTS * height)
    ax.set(xlim=(0, shape[1]), ylim=(shape[0], 0))
    ax.spines[:].set_visible(False)
    ax.tick_params(length=0, labelsize=_FONT)
    ax.xaxis.tick_top()
    ax.xaxis.set_label_position("top")
    _name_points(ax.yaxis, rows, _POINTS * height, "    ", va="center")
    letters = max((len(point) for dim in columns for point in dim.points), default=0)
    if _DIGIT * _FONT * letters > _POINTS * width:
        _name_points(ax.xaxis, columns, _POINTS * width, "    ", rotation=90, va="bottom")
    else:
        _name_points(ax.xaxis, columns, _POINTS * width, "\n", va="bottom")
    heading = look.heading if is_written else f"{look.heading}; the cells are too small for numbers"
    _explain(figure, ax, look, heading)
    title = str(ds.attrs.get("title", ""))
    ax.set_title(fill(title, int(9 * max(width * shape[1], _NARROWEST))), fontsize=11, weight="bold", pad=_GAP)
    return _grown(figure, ax)


def _grown(figure: Figure, ax: Axes) -> Figure:
    """The figure of cells, made as large as all that stands around them needs."""
    show_verbatim(figure)
    box, (width, height), margin = figure.get_tightbbox(), figure.get_size_inches(), _MARGIN / _POINTS
    across, down = box.width + 2 * margin, box.height + 2 * margin
    figure.set_size_inches(across, down)
    ax.set_position(((margin - box.x0) / across, (margin - box.y0) / down, width / across, height / down))
    return figure


def _checked(ds: xr.Dataset, variable: str) -> xr.DataArray:
    known = [name for name in (*FEATURES, *EXACT, RPN, "model_rpn_level", BAND) if name in ds]
    if variable not in known:
        raise PlotError(f"no variable {variable!r} of a test matrix; there are {', '.join(known)}")
    if "peak" in ds[variable].dims:
        raise PlotError(f"{variable} has several values in each test\nhint: choose one, as ds.isel(peak=0)")
    if not ds[variable].size:
        raise PlotError("nothing to draw: the matrix has no tests")
    return ds[variable]


def _split(dims: Sequence[Dimension]) -> tuple[list[Dimension], list[Dimension]]:
    """Dimensions of the rows and of the columns: a page's shape, both of them used from two dimensions on."""
    if len(dims) < 2:
        return (list(dims), []) if dims and dims[0].is_text else ([], list(dims))

    def misfit(rows: int) -> float:
        width, height = _CELL[0] * _size(dims[rows:]), _CELL[1] * _size(dims[:rows])
        return abs(log(width / height / _ASPECT))

    best = min(range(1, len(dims)), key=misfit)
    return list(dims[:best]), list(dims[best:])


def _size(dims: Sequence[Dimension]) -> int:
    return prod(len(d.points) for d in dims)


@dataclass(frozen=True)
class _Look:
    """The cells: values that `colours` and `norm` paint, what is written in them, and how that is explained.

    legend : entries for what the colours mean; none: a colour bar. is_hatched : by cell, None for none.
    """

    heading: str
    values: NDArray[Any]
    colours: Colormap
    norm: Normalize
    texts: NDArray[np.str_]
    legend: Sequence[Patch] = ()
    is_hatched: Flags | None = None


def _lights(ds: xr.Dataset, shape: tuple[int, int]) -> _Look:
    """The model RPN in its traffic-light colours."""
    band = ds[BAND].values.reshape(shape)
    texts = np.array([rpn_text(n) for n in ds[RPN].values.ravel().tolist()]).reshape(shape)
    words = {name: f"{low}–{high}: {MEANINGS[name]}" for name, (low, high) in BANDS.items()}
    words |= {"unknown": "?: not known"} if (band == UNDEFINED).any() else {}
    legend = [Patch(facecolor=LIGHTS[name], edgecolor=palette.ink(LIGHTS[name]), linewidth=0.0, label=text,
                    hatch=_HATCH if name == "red" else None) for name, text in words.items()]  # fmt: skip
    norm, colours = BoundaryNorm(np.arange(len(LIGHTS) + 1) - 0.5, len(LIGHTS)), ListedColormap(list(LIGHTS.values()))
    return _Look(RPN_NAME, band, colours, norm, texts, legend, band == list(LIGHTS).index("red"))


def _numbers(array: xr.DataArray, shape: tuple[int, int]) -> _Look:
    """A feature, or how the integration ended."""
    name, heading, cells = str(array.name), str(array.attrs.get("long_name", array.name)), array.values.reshape(shape)
    if name in palette.FLAG_COLOURS:
        painted = palette.paint(name, cells)
        legend = [entry for entry in painted.handles() if isinstance(entry, Patch)]
        return _Look(heading, cells, painted.colours, painted.norm, np.full(shape, ""), legend)
    unit = unit_for(str(array.attrs.get("units", "1")), cells)
    values = unit.of(cells.astype(np.float64))
    painted = palette.paint(name, values)
    colours = painted.colours.with_extremes(bad=palette.UNDEFINED_COLOUR)
    heading += f" ({unit.printed})" if unit.printed else ""
    texts = np.array([number_text(value) for value in values.ravel().tolist()]).reshape(shape)
    return _Look(heading, np.ma.masked_invalid(values), colours, painted.norm, texts)


def number_text(value: float) -> str:
    """A value to three digits, without an exponent as long as it stays short; a dash where there is none."""
    if 1000 <= abs(value) < 1e6:
        return f"{value:.0f}"
    return number(value, 3).replace("e-0", "e-").replace("e+0", "e")


def _write_numbers(ax: Axes, look: _Look, colours: Floats, width: float, height: float) -> bool:
    """Every text in its cell, black or white, whichever is easier to read; False if they would be too small."""
    size = min(_FONT, 0.62 * height, 0.76 * width / (_DIGIT * max(1, *map(len, look.texts.ravel()))))
    if size < _SMALLEST_NUMBER:
        return not look.texts.any()
    linear = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
    is_light = linear[..., :3] @ (0.2126, 0.7152, 0.0722) > 0.18  # relative luminance; both inks have the same contrast
    for (i, j), text in np.ndenumerate(look.texts):
        ink, box = "black" if is_light[i, j] else "white", None
        if look.is_hatched is not None and look.is_hatched[i, j]:
            box = {"facecolor": colours[i, j], "edgecolor": "none", "boxstyle": "square,pad=0.1"}
        ax.text(j + 0.5, i + 0.5, text, ha="center", va="center", color=ink, fontsize=size, bbox=box)
    return True


def _name_points(axis: Axis, dims: Sequence[Dimension], room: float, between: str, **style: Any) -> None:
    """The ticks of an axis, each of which has some room (points), and the names of its dimensions.

    An outer point stands before the inner one, or above it, in the middle of its cells. Where not all have room, every
    few are named in full.
    """
    lengths, step = [len(dim.points) for dim in dims], max(1, ceil(1.15 * _FONT / room))
    texts = []
    for at in np.ndindex(*lengths):
        is_middle = [all(i == length // 2 for i, length in zip(at[k:], lengths[k:], strict=True))
                     for k in range(1, len(dims) + 1)]  # fmt: skip
        points = (dim.points[i] for dim, i in zip(dims, at, strict=True))
        shown = (p if middle or step > 1 else "" for p, middle in zip(points, is_middle, strict=True))
        texts.append(between.join(map(_short, shown)))
    axis.set_ticks(np.arange(len(texts))[::step] + 0.5, texts[::step] if dims else [""], **style)
    axis.set_label_text(", ".join(dim.title for dim in dims), fontsize=_FONT, weight="bold")


def _short(text: str) -> str:
    """A label of one line."""
    text = shorten(text, _LONGEST_LABEL, placeholder=" …") if " " in text else text
    return text if len(text) <= _LONGEST_LABEL else text[: _LONGEST_LABEL - 1] + "…"


def _explain(figure: Figure, ax: Axes, look: _Look, heading: str) -> None:
    """The legend or the colour bar, below the cells."""
    width, height = (_POINTS * inches for inches in figure.get_size_inches())
    if look.legend:
        ax.legend(handles=list(look.legend), title=heading, frameon=False, fontsize=_FONT, loc="upper center",
                  title_fontproperties={"size": _FONT, "weight": "bold"}, bbox_to_anchor=(0.5, -0.5 * _GAP / height),
                  borderaxespad=0)  # fmt: skip
        return
    long = min(max(width, _NARROWEST * _POINTS), 4.0 * _POINTS) / width
    place = ax.inset_axes((0.5 - 0.5 * long, -2.5 * _GAP / height, long, 9.0 / height))
    bar = figure.colorbar(ScalarMappable(look.norm, look.colours), cax=place, orientation="horizontal")
    bar.ax.tick_params(labelsize=_FONT - 1)
    bar.ax.xaxis.set_major_formatter("{x:g}")
    bar.ax.xaxis.set_minor_formatter("")
    bar.set_label(heading, fontsize=_FONT)
