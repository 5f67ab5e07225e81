"""Write again what comes out of commands and Python on pages. `make reference`."""

import sys
from pathlib import Path

from making.played import played_pages, rewrite


def main(folder: Path, *pages: str) -> None:
    """Run pages of a folder, all unless some are named; those that are as they should be are left alone."""
    for page in pages or played_pages(folder):
        rewrite(folder, page)


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
