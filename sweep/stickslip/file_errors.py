"""What goes wrong with result files, said so that people can put it right."""

from __future__ import annotations

import os


class StoreError(OSError):
    """A dataset could not be written or read; the message names the path, the reason and, if there is one, a remedy."""


def reason(error: BaseException) -> str:
    """What went wrong, on one line and without the path, which the message names already."""
    if isinstance(error, OSError) and error.strerror:
        return str(error.strerror)
    lines = str(error).splitlines()
    return lines[0] if lines else type(error).__name__


def require_zarr(path: str | os.PathLike[str]) -> None:
    """Zarr is an optional extra: say so before xarray says something longer."""
    try:
        import zarr  # noqa: F401
    except ModuleNotFoundError as error:
        raise StoreError(
            f"{path}: Zarr stores need the optional package zarr\n"
            "hint: pip install 'stickslip[zarr]', or give the file a name that ends in .nc"
        ) from error
