"""Axes of made-up maps, what is in a figure, and what every plot does."""

import numpy as np
import pytest
from matplotlib.image import imread

import stickslip
from helpers.commands import call
from helpers.maps import axis
from stickslip import plots
from stickslip.errors import PlotError
from stickslip.files import writing
from stickslip.plots.layout import Figure

LUBRICANTS = ["dry", "grease", "bonded coating"]


def lubricants(labels=None):
    return (
        axis("a3", [0.1, 0.3, 0.6], "values", "lubricant", labels),
        axis("a4", [0.1, 0.05, 0.1], "values", "lubricant"),
    )


def speeds(n=6):
    return axis("belt_speed", np.linspace(0.05, 0.6, n))


def stiffnesses(n=5):
    return axis("stiffness", np.geomspace(0.1, 1000.0, n), "log")


def legend_of(figure) -> dict:
    return {
        text.get_text(): handle
        for text, handle in zip(figure.legends[0].texts, figure.legends[0].legend_handles, strict=True)
    }


def panels_of(figure):
    return [ax for ax in figure.axes if ax.axison and ax.get_label() != "<colorbar>"]


def notes_of(figure) -> list[str]:
    """Lines of small print below a plot."""
    texts = [text.get_text() for text in figure.texts] + [legend.get_title().get_text() for legend in figure.legends]
    return [line for text in texts for line in text.splitlines()]


def refuses_what_it_cannot_draw(draw, draws_cells=False):
    """A plot of datasets says what to give instead of one variable, of what is no dataset, and of one of cells."""
    cells = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1,
             "belt_speed": [0.5, 0.3, 0.4]}  # fmt: skip
    ds = stickslip.evaluate(cells)
    for given in (ds["period"], "map.nc", None, np.zeros((2, 2)), cells, [ds]):
        with pytest.raises(PlotError, match=f"of type {type(given).__name__}, expected a dataset"):
            draw(given)
    if not draws_cells:
        with pytest.raises(PlotError, match="not a|holds no"):
            draw(ds)


def draws_what_the_command_draws(ds, folder):
    """The accessor of a result, as it is opened again from its file; the kind of the plot."""
    writing.write(ds, folder / "result.nc")
    done = call("plot", folder / "result.nc", "-o", folder / "command.png")
    assert done.exit_code == 0, done.output
    figure = stickslip.open(folder / "result.nc").stickslip.plot()
    assert isinstance(figure, Figure)
    plots.save(figure, folder / "accessor.png")
    np.testing.assert_array_equal(*(imread(folder / f"{name}.png") for name in ("command", "accessor")))
    return plots.kind_of(ds)
