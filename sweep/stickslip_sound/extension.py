"""What the engine is told of sounds: a command, Python calls, and a method of datasets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stickslip.extensions import Extension

if TYPE_CHECKING:
    import xarray as xr

    from stickslip_sound.sounds import Sound

EXTENSION = Extension(
    commands={"One cell, and what a designer asks": {"listen": "stickslip_sound.command"}},
    calls={"sound": "stickslip_sound.api", "plots.plot_sound": "stickslip_sound.plots:plot_sound"},
    subjects=("acceleration_level_a",),
    methods={"sound": "stickslip_sound.extension:sound_of_cell"},
)


def sound_of_cell(
    ds: xr.Dataset, seconds: float = 2.0, *, slow: float = 1.0, transient: bool = False, **at: Any
) -> Sound:
    """Return what one cell of a dataset sounds like; a notebook plays it.

    seconds, slow, transient : as for `sound.of`. at : which cell, as for `ds.stickslip.cell`. Sounds of cells can be
    compared.
    """
    from stickslip.config.grid import shared_by
    from stickslip_sound.making import of

    cell, how = ds.stickslip.cell(**at), shared_by(ds)
    how.pop("rtol", None)  # sounds have a tolerance of their own
    return of(cell, seconds, slow=slow, transient=transient, title=str(ds.attrs.get("title", "")), **how)
