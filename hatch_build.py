"""What a wheel carries besides the two packages and the configurations: the pages that `stickslip help` shows."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_FOLDER = "stickslip/pages_of_docs"


class PagesOfDocs(BuildHookInterface):  # type: ignore[misc]
    """README and the pages of docs/, without pictures and without what builds the site."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Name the files; in an editable installation they are read where they are."""
        if version == "editable":
            return
        root = Path(self.root)
        for page in (root / "README.md", *sorted((root / "docs").glob("*.md"))):
            build_data["force_include"][str(page)] = f"{_FOLDER}/{page.name}"
