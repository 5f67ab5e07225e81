"""Write again what follows from the code: the reference, and what comes out of commands on pages. `make reference`."""

import sys
from pathlib import Path

from making import calls, commands, configuration, variables
from making.played import played_pages, rewrite

PAGES = {"api.md": calls, "commands.md": commands, "configuration.md": configuration, "variables.md": variables}


def main(folder: Path, *pages: str) -> None:
    """Write pages of a folder, all unless some are named; those that are as they should be are left alone."""
    written = {folder / name: made for name, made in PAGES.items()}
    for path, made in written.items():
        text = made.page()
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
            print(f"written: {path}")
    for page in pages or played_pages(folder):
        rewrite(folder, page)


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
