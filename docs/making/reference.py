"""Pages that follow from the code, of every command, key, call and variable: written when the site is built."""

import re
from pathlib import Path

from making import calls, commands, configuration, variables

PAGES = {"commands.md": commands, "keys.md": configuration, "calls.md": calls, "variables.md": variables}


def write(folder: Path) -> None:
    """Write the pages into a folder, which is made, below that of the pages they link to."""
    folder.mkdir(exist_ok=True)
    for name, made in PAGES.items():
        text = re.sub(r"\]\((?=[a-z]+\.md)(?!variables)", "](../", made.page())
        (folder / name).write_text(text, encoding="utf-8")
