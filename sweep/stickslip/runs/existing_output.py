"""An existing result where a run will write: finished, to be extended, or not to be touched."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import prod

import numpy as np
import xarray as xr

from stickslip._version import __version__
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.reader import parse_config
from stickslip.dataset.provenance import INCOMPLETE
from stickslip.errors import ConfigError, StoreError
from stickslip.files import reading
from stickslip.files.locations import Location
from stickslip.runs.known_cells import KnownCells, as_before, points_of
from stickslip.runs.work import MapStudy, study_of
from stickslip.runs.workdir.block_store import START_OVER, refuse, same_major
from stickslip.runs.workdir.manifest import differences
from stickslip.vocabulary.cells import Cells

_ANEW = "{fresh} computes it anew and replaces it; "
_OTHER_FILE = "{output} names another file"


@dataclass(frozen=True)
class ExistingOutput:
    """A result that this run resumes from.

    complete : there is nothing left to do. grid : of a map, with the values of the result where only rounding tells
    them apart.
    """

    cells: int
    complete: bool
    known: KnownCells | None
    grid: Cells | None = None


@contextmanager
def opened(
    output: Location | None, config: Config, fresh: bool, remedy: str = START_OVER
) -> Iterator[ExistingOutput | None]:
    """The result at `output`, open; None if there is none or it does not matter.

    remedy : as for `refuse`; other than the usual one from who cannot begin anew.

    Raises StoreError for what this run would destroy: results of another configuration or major version, results whose
    cells are not all part of the new map, and what stickslip has not written.
    """
    if output is None or fresh or not output.exists():
        yield None
        return
    hint = _ANEW * (remedy == START_OVER) + _OTHER_FILE
    try:
        dataset = reading.look_into(output)
    except StoreError as error:
        raise StoreError(str(error), hint=hint) from error
    with dataset:
        yield _compared(output, dataset, config, remedy, hint)


def _compared(output: Location, dataset: xr.Dataset, config: Config, remedy: str, hint: str) -> ExistingOutput:
    version = str(dataset.attrs["source"]).split()[1].rstrip(",")
    if not same_major(version):
        raise StoreError(f"{output}: made by stickslip {version}, and this is {__version__}", hint=hint)
    study = study_of(config)
    if isinstance(study, MapStudy) and "regime" not in dataset:
        raise StoreError(f"{output}: exists and is not a map", hint=hint)
    try:
        there = parse_config(str(dataset.attrs["configuration"]), str(output))
    except (ConfigError, KeyError):
        raise StoreError(f"{output}: exists, and its configuration cannot be read", hint=hint) from None
    differing = differences(there, config)
    if not isinstance(study, MapStudy):
        if differing:
            refuse(str(output), there, config, remedy)
        whole = there.title == config.title and INCOMPLETE not in dataset.attrs
        return ExistingOutput(prod(study.shape), whole, None)
    if any(not name.startswith("axes.") for name in differing):
        refuse(str(output), there, config, remedy)
    old, new = build_grid(there), build_grid(config)
    axes, new_axes = ([(c.name, grid.dims.index(c.dim)) for c in grid.coords] for grid in (old, new))
    if axes != new_axes:
        refuse(str(output), there, config, remedy)
    before = {c.name: dataset[c.name].values for c in old.coords}
    old, new = as_before(old, before), as_before(new, before)
    points = points_of(old, new)
    if lost := old.size - prod(np.unique(place[place >= 0]).size for place in points):
        if lost == old.size:
            refuse(str(output), there, config, remedy)
        raise StoreError(
            f"{output}: holds {lost:,} cells that are not part of the new map and would be lost", hint=hint
        )
    whole = not differing and there.title == config.title and not (dataset["regime"] == 0).any()
    return ExistingOutput(new.size, whole, None if whole else KnownCells(dataset, new.shape, points), new)
