"""Cells over named dimensions: what every study is asked about.

Cells are numbered with the last dimension running fastest. Those of a configuration (`config/grid.py`) may be more than
memory holds: their parameters are computed for the range that is asked for. Those that people list
(`dataset/build.py`) are arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.quantities import MEASURED, OF_EXTENSIONS, PARAMETERS

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Parameters = dict[str, Floats]  # of some cells, in SI, by names of `PARAMETERS`: arrays of one length
_NAMES = (*PARAMETERS, *OF_EXTENSIONS)


@dataclass(frozen=True, eq=False)
class Coordinate:
    """One quantity along one dimension.

    values : in SI, one per point; NaN where the quantity is absent. spacing : "linear", "log" or "values" (a list).
    labels : names of the points; with them the dimension is indexed by names, not by values.
    """

    name: str
    dim: str
    values: Floats
    units: str
    long_name: str
    spacing: str
    labels: tuple[str, ...] | None = None


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells over named dimensions; `cells[start:stop]` are the parameters of a range of them.

    dims, shape : names and lengths of the dimensions, outermost first. No dimensions: one cell.
    fixed : quantities that are equal in all cells, in SI, NaN for absent ones. along : those that vary along one
        dimension, with its number. listed : those that vary from cell to cell, flat.
    measured : of `MEASURED`, equal in all cells while others of the curve vary, so that its parameters follow cell by
    cell.
    coords : the axes of a configuration. written_in : by quantity, the unit in which results show it.
    labelled : makes the coordinates of cells that people list.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)
    along: Mapping[str, tuple[int, Floats]] = field(default_factory=dict)
    listed: Parameters = field(default_factory=dict)
    measured: Mapping[str, float] = field(default_factory=dict)
    coords: tuple[Coordinate, ...] = ()
    written_in: Mapping[str, str] = field(default_factory=dict)
    labelled: Callable[[], dict[str, xr.Variable]] | None = None

    @classmethod
    def of(cls, parameters: Parameters) -> Cells:
        """A list of cells along one dimension."""
        return cls(("cell",), (parameters["mass"].size,), listed=parameters)

    @property
    def size(self) -> int:
        """Number of cells."""
        return prod(self.shape)

    def __getitem__(self, part: slice) -> Parameters:
        """The parameters of a range of cells.

        Returns every name of `PARAMETERS`, and those of extensions that are given, in SI. Raises IndexError
        for cells that there are not.
        """
        start, stop = part.start or 0, self.size if part.stop is None else part.stop
        if not 0 <= start <= stop <= self.size:
            raise IndexError(f"cells {start} to {stop} of {self.size}")
        if self._is_list:
            whole = start == 0 and stop == self.size
            return dict(self.listed) if whole else {name: values[start:stop] for name, values in self.listed.items()}
        return self.take(np.arange(start, stop, dtype=np.int64))

    def take(self, numbers: NDArray[Any], **changed: Floats) -> Parameters:
        """The parameters of the cells of these numbers, in any order, some quantities being others."""
        points = np.unravel_index(numbers, self.shape) if self.along else ()
        known = {name: np.full(numbers.size, value) for name, value in (*self.fixed.items(), *self.measured.items())}
        known |= {name: values[points[dimension]] for name, (dimension, values) in self.along.items()}
        known |= {name: values[numbers] for name, values in self.listed.items()}
        return parameters_of(known | changed)

    def pick(self, numbers: NDArray[np.int64]) -> Cells:
        """The cells of these numbers, as a list."""
        points = np.unravel_index(numbers, self.shape) if self.along else ()
        listed = {name: values[points[dimension]] for name, (dimension, values) in self.along.items()}
        listed |= {name: values[numbers] for name, values in self.listed.items()}
        return Cells(("cell",), (numbers.size,), self.fixed, listed=listed, measured=self.measured)

    def without(self, *names: str) -> Cells:
        """The cells with these quantities left open; `take` is to be given them."""
        labelled = self.labelled
        return replace(
            self,
            fixed={name: value for name, value in self.fixed.items() if name not in names},
            listed={name: values for name, values in self.listed.items() if name not in names},
            labelled=labelled and (lambda: {name: v for name, v in labelled().items() if name not in names}),
        )

    @property
    def _is_list(self) -> bool:
        return not (self.fixed or self.along or self.measured or MEASURED.keys() & self.listed.keys())


def parameters_of(quantities: Mapping[str, Floats]) -> Parameters:
    """The parameters of cells whose quantities these are; of a curve they follow from what is measured of it."""
    known = dict(quantities)
    for model in MODELS:
        known = model.completed(known)
    return {name: known[name] for name in _NAMES if name in known}


def taken(cells: Parameters, which: NDArray[Any] | slice) -> Parameters:
    """The cells of these numbers, of this mask or in this range."""
    return {name: values[which] for name, values in cells.items()}
