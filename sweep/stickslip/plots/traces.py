"""Trajectories over time and their phase portraits; sounds and their spectrograms."""

import math
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.ticker import ScalarFormatter
from numpy.typing import NDArray

from stickslip.dataset.display import title as array_title
from stickslip.dataset.display import unit_of
from stickslip.dataset.selection import check_dataset
from stickslip.errors import PlotError
from stickslip.plots.axes import shade
from stickslip.plots.layout import Figure, entitle, labelled, legend
from stickslip.plots.palette import BLACK, BLUE, GREY, VERMILLION
from stickslip.vocabulary.display_units import quantity, spoken
from stickslip.vocabulary.flags import MODES
from stickslip.vocabulary.quantities import PARAMETERS

Floats = NDArray[np.float64]
_ALWAYS = ("mass", "stiffness", "normal_load", "belt_speed")  # of the parameters that a title names
_NAMED = (*_ALWAYS, "damping")  # the others where they are not 0
_WINDOW = 0.09  # s: tones 20 Hz apart are told from each other
_OVERLAP = 0.875  # of a window, with the next one
_REFERENCE = 1e-6  # m/s2, ISO 1683
_SHOWN = 60.0, 140.0  # dB, the same in all pictures, so that they can be compared; more where a sound has more
_LEAST_SHOWN = 40.0  # dB below the largest line, of faint sounds
_LOWEST, _HIGHEST = 20.0, 20e3  # Hz that are heard


def plot_trace(ds: xr.Dataset, *, title: str | None = None) -> Figure:
    """A trajectory: displacement and velocity over time with the stick phases shaded, and the phase portrait.

    The line of the belt speed appears in the phase portrait only while that speed is constant. Raises PlotError.
    """
    check_dataset(ds)
    if missing := {"displacement", "velocity", "relative_speed", "mode"} - set(ds.data_vars):
        raise PlotError(f"not a trajectory: no {', '.join(sorted(missing))}")
    names = "time", "displacement", "velocity"
    units = {name: unit_of(ds[name]) for name in names}
    time, displacement, velocity = (units[name].of(ds[name].values) for name in names)
    belt = units["velocity"].of(ds["relative_speed"].values) + velocity
    sticks = ds["mode"].values == MODES.index("stick")
    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    places = figure.add_gridspec(2, 2, width_ratios=[3, 2])
    upper = figure.add_subplot(places[0, 0])
    lower = figure.add_subplot(places[1, 0], sharex=upper)
    phase = figure.add_subplot(places[:, 1])
    upper.tick_params(labelbottom=False)
    mass_line: dict[str, Any] = {"color": BLUE, "linewidth": 1.2, "label": "mass"}
    belt_line: dict[str, Any] = {"color": VERMILLION, "linewidth": 1.0, "linestyle": "dashed", "label": "belt"}
    stuck: dict[str, Any] = {"facecolor": GREY, "alpha": 0.45, "linewidth": 0, "label": "sticking"}

    upper.plot(time, displacement, **mass_line)
    lower.plot(time, velocity, **mass_line)
    lower.plot(time, belt, **belt_line)
    for ax in (upper, lower):
        shade(ax, np.append(time, time[-1]), sticks, stuck)
        ax.margins(x=0)
    phase.plot(displacement, velocity, **mass_line)
    phase.plot(displacement[:1], velocity[:1], color=BLACK, marker="o", markersize=4, linestyle="none", label="start")
    if np.ptp(belt) <= 1e-9 * np.abs(belt).max():
        phase.axhline(belt[0], zorder=0, **belt_line)

    named = {name: array_title(ds[name], unit) for name, unit in units.items()}
    upper.set_ylabel(named["displacement"])
    lower.set(xlabel=named["time"], ylabel=named["velocity"])
    phase.set(xlabel=named["displacement"], ylabel=named["velocity"])
    for ax in (upper, lower, phase):
        ax.ticklabel_format(style="sci", scilimits=(-3, 4), useMathText=True)
    legend(figure, labelled(lower, phase), at_right=False)
    entitle(figure, upper, _title(ds) if title is None else title, above_all=True)
    return figure


def _title(ds: xr.Dataset) -> str:
    """The title of the dataset, and below it the parameters of the cell."""
    parameters = {name: float(ds[name]) for name in _NAMED if name in ds.coords and ds[name].ndim == 0}
    words = [
        f"{spoken(name)} {quantity(value, PARAMETERS[name].units)}"
        for name, value in parameters.items() if value or name in _ALWAYS
    ]  # fmt: skip
    return "\n".join(filter(None, [str(ds.attrs.get("title", "")), ", ".join(words)]))


def plot_sound(acceleration: Floats, rate: float, *, title: str = "", slow: float = 1.0) -> Figure:
    """The acceleration (m/s2, `rate` samples a second) over time, and below it the level of its tones over time.

    slow : how many times slower than the motion it is; time and frequencies are as heard. Raises PlotError.
    """
    length = round(_WINDOW * rate)
    if acceleration.size < 2 * length:
        raise PlotError(f"a spectrogram needs {2 * _WINDOW:g} s of sound, got {acceleration.size / rate:.2g} s")
    times, frequencies, level = _levels(acceleration, rate, length)
    figure = Figure(figsize=(9.0, 5.4), layout="constrained")
    seconds = acceleration.size / rate
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1, 2])
    upper.plot(np.arange(acceleration.size) / rate, acceleration, color=BLUE, linewidth=0.6, rasterized=True)
    upper.set_ylabel("acceleration (m/s²)")
    upper.margins(x=0)
    if not np.isfinite(level).any():
        lower.text(0.5, 0.5, "silence", transform=lower.transAxes, ha="center", va="center")
    else:
        loudest = float(np.nanmax(level))
        low, high = min(_SHOWN[0], _in_tens(loudest - _LEAST_SHOWN)), max(_SHOWN[1], _in_tens(loudest + 10.0))
        image = lower.pcolormesh(
            times, frequencies, level, cmap="viridis", vmin=low, vmax=high, shading="nearest", rasterized=True
        )
        figure.colorbar(image, ax=lower, label="level of a tone (dB re 1e-6 m/s²)", extend="min")
    as_heard = "" if slow == 1.0 else f", {slow:g} times slower than the motion"
    lower.set(yscale="log", ylim=(_LOWEST, min(_HIGHEST, 0.5 * rate)), ylabel="frequency (Hz)")
    lower.yaxis.set_major_formatter(ScalarFormatter())
    lower.set(xlim=(0.0, seconds), xlabel=f"time (s){as_heard}")
    entitle(figure, upper, title, above_all=True)
    return figure


def _in_tens(level: float) -> float:
    return 10.0 * math.floor(level / 10.0)


def _levels(acceleration: Floats, rate: float, length: int) -> tuple[Floats, Floats, Floats]:
    """Times (s), frequencies (Hz) and levels (dB, NaN for none), shape (frequencies, times).

    A tone has the level of its mean square, whatever the window.
    """
    from scipy import signal  # type: ignore[import-untyped]

    step = length - int(_OVERLAP * length)
    around = np.pad(acceleration, length // 2)  # so that a window is centred on either end
    frequencies, times, squares = signal.spectrogram(
        around, rate, "hann", nperseg=length, noverlap=length - step, scaling="spectrum", detrend=False
    )
    with np.errstate(divide="ignore"):
        level = 10.0 * np.log10(squares / _REFERENCE**2)
    heard = (frequencies >= _LOWEST) & (frequencies <= _HIGHEST)
    return times - (length // 2) / rate, frequencies[heard], np.where(np.isfinite(level), level, np.nan)[heard]
