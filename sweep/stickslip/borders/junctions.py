"""Where three or more labels meet inside a grid cell, closed in upon in all such cells together."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stickslip.borders.search import Floats, Integers, Labels

LabelsInCells = Callable[[Integers, Floats, Floats], Labels]  # of (cell, share along x, share along y)
_SIDE = 5  # points along a side of the window that is looked at; half of it is the next
_HALF = _SIDE // 2 + 1


def meeting_points(cells: int, labels_at: LabelsInCells, rounds: int) -> tuple[Floats, Floats]:
    """Places (cells, 2), as shares of the cell along x and y, and the width of the last window around them.

    A window of 5 x 5 points becomes the one of 3 x 3 of them in which the third most frequent label is met most
    often. Where no three labels are met, the window stays as it is: half a cell wide or wider, it is the whole cell.
    """
    corner, width = np.zeros((cells, 2)), np.ones(cells)
    active = np.arange(cells)
    steps = np.linspace(0.0, 1.0, _SIDE)
    for _ in range(rounds):
        if not active.size:
            break
        x = corner[active, 0, np.newaxis, np.newaxis] + width[active, np.newaxis, np.newaxis] * steps
        y = corner[active, 1, np.newaxis, np.newaxis] + width[active, np.newaxis, np.newaxis] * steps[:, np.newaxis]
        x, y = np.broadcast_arrays(x, y)
        labels = labels_at(np.repeat(active, _SIDE * _SIDE), x.ravel(), y.ravel()).reshape(-1, _SIDE, _SIDE)
        windows = np.lib.stride_tricks.sliding_window_view(labels, (_HALF, _HALF), axis=(1, 2))
        thirds = _third_most(windows.reshape(len(active), _HALF * _HALF, -1))
        best = np.argmax(thirds, axis=1)
        row, column = np.divmod(best, _HALF)
        met = thirds[np.arange(len(active)), best] > 0
        step = width[active] / (_SIDE - 1)
        corner[active[met]] += (np.stack([column, row], axis=1) * step[:, np.newaxis])[met]
        width[active[met]] /= 2
        active = active[met]
    return corner + width[:, np.newaxis] / 2, width


def _third_most(labels: Labels) -> Integers:
    """How often the third most frequent of labels occurs, along the last axis."""
    counts = np.stack([(labels == one).sum(axis=-1) for one in range(int(labels.max(initial=0)) + 1)], axis=-1)
    if counts.shape[-1] < 3:
        return np.zeros(counts.shape[:-1], np.int64)
    return np.asarray(np.sort(counts, axis=-1)[..., -3], np.int64)
