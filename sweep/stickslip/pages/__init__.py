"""Pages: self-contained HTML files, without network or scripts, to read, to send and to print.

frame   the page around its sections, and its file      parts   terms, tables, embedded figures, warnings
"""

from stickslip.pages.frame import Section, page, write_page
from stickslip.pages.parts import (
    Cell,
    Column,
    configuration,
    details,
    embedded,
    paragraph,
    provenance,
    side_by_side,
    table,
    terms,
    warning,
)

__all__ = [
    "Cell", "Column", "Section", "configuration", "details", "embedded", "page", "paragraph",
    "provenance", "side_by_side", "table", "terms", "warning", "write_page",
]  # fmt: skip
