"""Walking along borders in a plane: which grid cells hold one, without looking at the others.

Grid points and grid cells are numbered by (row, column); cell (i, j) has the points (i, j) to (i + 1, j + 1) as
corners. Rows run along y, columns along x. Labels are small integers, 0 is "not looked at".
"""

from collections.abc import Callable

import numpy as np

from stickslip.studies.borders.search import Integers, Labels

_CORNERS = np.array([(0, 0), (0, 1), (1, 1), (1, 0)])  # counter-clockwise from the lower left
_NEIGHBOURS = ((-1, 0), (0, 1), (1, 0), (0, -1))  # beyond the sides that begin at these corners


class Points:
    """The labels of grid points, computed when first asked for.

    shape : rows and columns. labels_at : labels (1 and above) of rows and columns.
    """

    def __init__(self, shape: tuple[int, int], labels_at: Callable[[Integers, Integers], Labels]) -> None:
        self._labels_at = labels_at
        self.known = np.zeros(shape, np.int8)

    def __call__(self, row: Integers, column: Integers) -> Labels:
        """Labels of some points; those not known yet are computed together."""
        new = self.known[row, column] == 0
        if new.any():
            r, c = np.unique([row[new], column[new]], axis=1)
            self.known[r, c] = self._labels_at(r, c)
        return self.known[row, column]


def border_cells(points: Points, scan: int) -> Integers:
    """The grid cells whose corners differ, as rows (row, column), as far as a coarse scan leads to them.

    scan : how many rows and columns of points are looked at first. Borders that cross no side between neighbours of the
    scan twice are found; a loop between them is missed.
    """
    shape = np.array(points.known.shape) - 1
    ahead, seen = _seeds(points, scan), np.zeros(shape, np.bool_)
    cells = []
    while ahead.size:
        ahead = np.unique(ahead[((ahead >= 0) & (ahead < shape)).all(axis=1)], axis=0)
        ahead = ahead[~seen[tuple(ahead.T)]]
        seen[tuple(ahead.T)] = True
        labels = corner_labels(points, ahead)
        differs = labels != np.roll(labels, -1, axis=1)
        cells.append(ahead[differs.any(axis=1)])
        ahead = np.concatenate([ahead[differs[:, i]] + step for i, step in enumerate(_NEIGHBOURS)])
    return np.concatenate(cells) if cells else np.zeros((0, 2), np.int64)


def corner_labels(points: Points, cells: Integers) -> Labels:
    """Labels of the corners of cells (n, 2), counter-clockwise from the lower left: (n, 4)."""
    row, column = (cells[:, np.newaxis] + _CORNERS).transpose(2, 0, 1)
    return points(row, column)


def scanned(points: int, scan: int) -> Integers:
    """Which of the points along a side are looked at first."""
    return np.unique(np.linspace(0, points - 1, min(points, scan)).round().astype(np.int64))


def _seeds(points: Points, scan: int) -> Integers:
    """Cells beside one side with different ends for every pair of neighbours of the scan that differ."""
    coarse = [scanned(length, scan) for length in points.known.shape]
    grid = np.stack(np.meshgrid(*coarse, indexing="ij"), axis=-1)  # of (row, column)
    labels = points(grid[..., 0], grid[..., 1])
    seeds = []
    for axis in (0, 1):
        first, second = (np.take(grid, range(start, grid.shape[axis] - 1 + start), axis) for start in (0, 1))
        differ = np.diff(labels, axis=axis) != 0
        side = _side_between(points, first[differ], second[differ], axis)
        across = np.array([axis, 1 - axis])
        seeds += [side, side - across]
    return np.concatenate(seeds)


def _side_between(points: Points, low: Integers, high: Integers, axis: int) -> Integers:
    """The lower of two neighbouring points with different labels between each of `low` and of `high`."""
    low, high = low.copy(), high.copy()
    home = points(*low.T)
    while True:
        apart = np.flatnonzero(high[:, axis] - low[:, axis] > 1)
        if not apart.size:
            return low
        middle = low[apart]
        middle[:, axis] = (low[apart, axis] + high[apart, axis]) // 2
        same = points(*middle.T) == home[apart]
        low[apart[same]] = middle[same]
        high[apart[~same]] = middle[~same]
