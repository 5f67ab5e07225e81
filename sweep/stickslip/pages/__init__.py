"""Pages: self-contained HTML files, without network or scripts, to read, to send and to print."""

from stickslip.pages.html import (
    Cell,
    Column,
    Section,
    configuration,
    details,
    embedded,
    legend,
    page,
    paragraph,
    provenance,
    side_by_side,
    table,
    terms,
    warning,
    write_page,
)

__all__ = [
    "Cell", "Column", "Section", "configuration", "details", "embedded", "legend", "page", "paragraph",
    "provenance", "side_by_side", "table", "terms", "warning", "write_page",
]  # fmt: skip
