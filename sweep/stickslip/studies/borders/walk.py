"""Walking along borders in a plane: which grid cells hold one, without looking at the others.

Grid points and grid cells are numbered by (panel, row, column), flat; cell (p, i, j) has the points (p, i, j) to
(p, i + 1, j + 1) as corners. Rows run along y, columns along x. Labels are small integers, 0 is "not looked at".
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from stickslip.studies.borders.search import Integers, Labels

LabelsOfPoints = Callable[[Integers, Integers, Integers], Labels]
Grid = tuple[int, int, int]  # panels, rows, columns
_CORNERS = ((0, 0), (0, 1), (1, 1), (1, 0))  # row and column, counter-clockwise from the lower left
_NEIGHBOURS = ((-1, 0), (0, 1), (1, 0), (0, -1))  # beyond the sides that begin at these corners


@dataclass
class Points:
    """The labels of grid points, computed when first asked for.

    grid : panels, rows and columns of points. labels_at : labels (1 and above) of panels, rows and columns.
    """

    grid: Grid
    labels_at: LabelsOfPoints
    known: Labels = field(init=False)

    def __post_init__(self) -> None:
        self.known = np.zeros(self.grid, np.int8)

    def __call__(self, panel: Integers, row: Integers, column: Integers) -> Labels:
        """Labels of some points; those not known yet are computed together."""
        new = self.known[panel, row, column] == 0
        if new.any():
            numbers = np.unique(np.ravel_multi_index((panel[new], row[new], column[new]), self.grid))
            p, r, c = np.unravel_index(numbers, self.grid)
            self.known[p, r, c] = self.labels_at(p, r, c)
        return self.known[panel, row, column]

    @property
    def looked_at(self) -> int:
        """Return how many points have been computed."""
        return int(np.count_nonzero(self.known))


def border_cells(points: Points, scan: tuple[int, int]) -> Integers:
    """The grid cells whose corners differ, as rows (panel, row, column), as far as a coarse scan leads to them.

    scan : how many rows and columns of points are looked at first. Borders that cross no side between neighbours of the
    scan twice are found; a loop between them is missed.
    """
    ahead, seen = _seeds(points, scan), np.zeros(np.subtract(points.grid, (0, 1, 1)), np.bool_)
    found = []
    while ahead.size:
        ahead = _inside(np.unique(ahead, axis=0), seen.shape)
        ahead = ahead[~seen[tuple(ahead.T)]]
        seen[tuple(ahead.T)] = True
        labels = corner_labels(points, ahead)
        differs = labels != np.roll(labels, -1, axis=1)
        found.append(ahead[differs.any(axis=1)])
        ahead = np.concatenate([ahead[differs[:, i]] + (0, *step) for i, step in enumerate(_NEIGHBOURS)])
    return np.concatenate(found) if found else np.zeros((0, 3), np.int64)


def corner_labels(points: Points, cells: Integers) -> Labels:
    """Labels of the corners of cells (n, 3), counter-clockwise from the lower left: (n, 4)."""
    if not len(cells):
        return np.zeros((0, 4), np.int8)
    panel, row, column = (np.repeat(part, 4).reshape(-1, 4) for part in cells.T)
    offsets = np.array(_CORNERS)
    return points(panel, row + offsets[:, 0], column + offsets[:, 1])


def scanned(points: int, scan: int) -> Integers:
    """Which of the points along a side are looked at first."""
    return np.unique(np.linspace(0, points - 1, min(points, scan)).round().astype(np.int64))


def _seeds(points: Points, scan: tuple[int, int]) -> Integers:
    """Cells beside one side with different ends for every pair of neighbours of the scan that differ."""
    panels, rows, columns = points.grid
    coarse = [scanned(n, k) for n, k in zip((rows, columns), scan, strict=True)]
    panel, row, column = (axis.ravel() for axis in np.meshgrid(np.arange(panels), *coarse, indexing="ij"))
    shape = (panels, coarse[0].size, coarse[1].size)
    labels = points(panel, row, column).reshape(shape)
    found = []
    for axis in (1, 2):
        first = np.take(labels, range(shape[axis] - 1), axis)
        where = np.argwhere(first != np.take(labels, range(1, shape[axis]), axis))
        here = np.stack([where[:, 0], coarse[0][where[:, 1]], coarse[1][where[:, 2]]], axis=1)
        there = here.copy()
        there[:, axis] = coarse[axis - 1][where[:, axis] + 1]
        side = _side_between(points, here, there, axis)
        across = np.zeros(3, np.int64)
        across[3 - axis] = 1
        found += [side, side - across]
    return np.concatenate(found)


def _side_between(points: Points, low: Integers, high: Integers, axis: int) -> Integers:
    """The lower of two neighbouring points with different labels between each of `low` and of `high`."""
    low, high = low.copy(), high.copy()
    home = points(*low.T) if len(low) else np.zeros(0, np.int8)
    while True:
        apart = np.flatnonzero(high[:, axis] - low[:, axis] > 1)
        if not apart.size:
            return low
        middle = low[apart]
        middle[:, axis] = (low[apart, axis] + high[apart, axis]) // 2
        same = points(*middle.T) == home[apart]
        low[apart[same]] = middle[same]
        high[apart[~same]] = middle[~same]


def _inside(cells: Integers, shape: tuple[int, ...]) -> Integers:
    """Those cells that the grid has."""
    return cells[np.flatnonzero(((cells >= 0) & (cells < np.array(shape))).all(axis=1))]
