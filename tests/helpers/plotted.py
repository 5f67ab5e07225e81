"""Axes of made-up maps, and what is in a figure."""

from __future__ import annotations

import numpy as np

from helpers.maps import axis

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
