"""What pages say without Sphinx, for Sphinx: they are plain Markdown, to be read where there is no site as well.

The table of contents of the site is index.md: each of its sections a caption, each link to a page an entry. A link that
shows the name of a page shows its title. A link to a folder of the checkout becomes plain text; one to a file, a
download.
"""

from __future__ import annotations

import re
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the tests read pages without it
    from sphinx.application import Sphinx


_PAGE = re.compile(r"\]\(([a-z0-9_-]+)\.md\)")
_NAMED = re.compile(r"\[[a-z0-9_-]+\.md\](?=\([a-z0-9_-]+\.md[)#])")
_OUTSIDE = re.compile(r"\[([^\]]*)\]\((\.\./[^)#]*)\)")


def sections(index: str) -> dict[str, list[str]]:
    """The pages that index.md links to, by the heading they stand under, without suffix and once each."""
    found: dict[str, list[str]] = {}
    for section in re.split(r"^## ", index, flags=re.MULTILINE)[1:]:
        heading, _, text = section.partition("\n")
        known = set(chain.from_iterable(found.values()))
        found[heading] = [page for page in dict.fromkeys(_PAGE.findall(text)) if page not in known]
    return {heading: pages for heading, pages in found.items() if pages}


def _adapt(app: Sphinx, name: str, source: list[str]) -> None:
    """Make links what they are to be, and append the hidden table of contents to the index."""

    def linked(link: re.Match[str]) -> str:
        if Path(app.srcdir, link[2]).is_dir():
            return link[1]
        return f"[{link[1]}](path:{link[2]})" if link[2].endswith(".md") else link[0]

    source[0] = _NAMED.sub("[]", _OUTSIDE.sub(linked, source[0]))
    if name == app.config.root_doc:
        for heading, pages in sections(source[0]).items():
            source[0] += "\n```{toctree}\n:hidden:\n:caption: " + "\n".join([heading, "", *pages]) + "\n```\n"
        source[0] += "\n```{toctree}\n:hidden:\n:caption: Tables\n:glob:\n\nreference/*\n```\n"


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("source-read", _adapt)
    return {"parallel_read_safe": True}
