"""Our files through `xr.open_dataset(file, engine="stickslip")`, and the accessor with whatever xarray opens.

An entry point of the package names this module to xarray, which imports it when it first opens something. So datasets
have `ds.stickslip` even where `stickslip` was imported before xarray, or not at all.
"""

import os
from collections.abc import Iterable
from typing import Any

import xarray as xr
from xarray.backends import BackendEntrypoint

from stickslip import accessor as accessor  # which gives datasets `ds.stickslip`


class StickslipBackend(BackendEntrypoint):
    """Results of stickslip, as `stickslip.open` reads them: damaged files are refused."""

    description = "Results of stickslip (netCDF, Zarr), with the checks of stickslip.open"
    open_dataset_parameters = ("filename_or_obj", "drop_variables")

    def open_dataset(
        self, filename_or_obj: Any, *, drop_variables: str | Iterable[str] | None = None, **_: Any
    ) -> xr.Dataset:
        """The result at a path or URL. Raises StoreError."""
        from stickslip.files.reading import look_into

        ds = look_into(os.fspath(filename_or_obj))
        return ds if drop_variables is None else ds.drop_vars(drop_variables)

    def guess_can_open(self, filename_or_obj: Any) -> bool:
        """Never: files are opened by xarray's own engines unless this one is named."""
        return False
