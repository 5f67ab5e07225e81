"""Where results are: a path of this machine, or a URL that fsspec opens."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

from stickslip.files.remote import RemoteFolder

ROOT = "zarr.json"  # what makes a place a Zarr store


@dataclass(frozen=True)
class Url(os.PathLike[str]):
    """A Zarr store behind a URL, with what is asked of a `Path` that is a result. text : without a slash at its end."""

    text: str

    def __str__(self) -> str:
        return self.text

    def __fspath__(self) -> str:
        return self.text

    @property
    def name(self) -> str:
        """What comes after the last slash."""
        return self.text.rpartition("/")[2]

    @property
    def suffix(self) -> str:
        """`.zarr`, for one."""
        return PurePosixPath(self.name).suffix

    def with_name(self, name: str) -> Url:
        """The same place but for its name."""
        return Url(f"{self.text.rpartition('/')[0]}/{name}")

    def with_suffix(self, suffix: str) -> Url:
        """The same place but for its suffix."""
        return self.with_name(self.stem + suffix)

    @property
    def stem(self) -> str:
        """The name without its suffix."""
        return self.name.removesuffix(self.suffix)

    def exists(self) -> bool:
        """Whether a store is there, and whole: what it says of itself is written last."""
        return self.folder().has(ROOT)

    def folder(self) -> RemoteFolder:
        """The place for reading and writing. Raises StoreError if it cannot be opened."""
        return RemoteFolder(self.text)


Location = Path | Url


def location(place: str | os.PathLike[str]) -> Location:
    """What a text names; `~` is the folder of its user."""
    if isinstance(place, Path | Url):
        return place
    text = os.fspath(place)
    if text.startswith("file://"):
        return Path(unquote(urlsplit(text).path))
    return Url(text.rstrip("/")) if "://" in text else Path(os.path.expanduser(text))
