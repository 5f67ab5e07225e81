"""The picture of a sound: its acceleration over time, and its spectrogram."""

import numpy as np
from matplotlib.ticker import ScalarFormatter
from numpy.typing import NDArray
from scipy import signal  # type: ignore[import-untyped]

from stickslip.errors import PlotError
from stickslip.plots.layout import Figure, entitle
from stickslip.plots.palette import BLUE
from stickslip_sound.loudness import REFERENCE, decibels

Floats = NDArray[np.float64]
_WINDOW = 0.09  # s: tones 20 Hz apart are told from each other
_OVERLAP = 0.875  # of a window, with the next one
_SHOWN = {"vmin": 60.0, "vmax": 140.0}  # dB, the same in all pictures, so that they can be compared
_LOWEST, _HIGHEST = 20.0, 20e3  # Hz that are heard


def plot_sound(acceleration: Floats, rate: float, *, title: str = "", slow: float = 1.0) -> Figure:
    """The acceleration (m/s2, `rate` samples a second) over time, and below it the level of its tones over time.

    slow : how many times slower than the motion it is; time and frequencies are as heard. Raises PlotError.
    """
    length = round(_WINDOW * rate)
    if acceleration.size < 2 * length:
        raise PlotError(f"a spectrogram needs {2 * _WINDOW:g} s of sound, got {acceleration.size / rate:.2g} s")
    around = np.pad(acceleration, length // 2)  # so that a window is centred on either end
    frequencies, times, squares = signal.spectrogram(  # a tone has the level of its mean square, whatever the window
        around, rate, "hann", nperseg=length, noverlap=int(_OVERLAP * length), scaling="spectrum", detrend=False
    )
    heard = (frequencies >= _LOWEST) & (frequencies <= _HIGHEST)
    level = decibels(np.sqrt(squares[heard]) / REFERENCE)
    figure = Figure(figsize=(9.0, 5.4), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1, 2])
    upper.plot(np.arange(acceleration.size) / rate, acceleration, color=BLUE, linewidth=0.6, rasterized=True)
    upper.set_ylabel("acceleration (m/s2)")
    upper.margins(x=0)
    image = lower.pcolormesh(
        times - (length // 2) / rate, frequencies[heard], level, **_SHOWN, shading="nearest", rasterized=True
    )
    figure.colorbar(image, ax=lower, label="level of a tone (dB re 1e-6 m/s2)", extend="both")
    as_heard = "" if slow == 1.0 else f", {slow:g} times slower than the motion"
    lower.set(yscale="log", ylim=(_LOWEST, min(_HIGHEST, 0.5 * rate)), ylabel="frequency (Hz)")
    lower.yaxis.set_major_formatter(ScalarFormatter())
    lower.set(xlim=(0.0, acceleration.size / rate), xlabel=f"time (s){as_heard}")
    entitle(figure, upper, title, above_all=True)
    return figure
