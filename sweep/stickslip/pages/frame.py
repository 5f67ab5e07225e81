"""The frame of a page: title, summary, warnings and sections in one HTML file, and how it is written."""

from __future__ import annotations

import os
from collections.abc import Sequence
from html import escape
from io import BytesIO
from pathlib import Path
from string import Template
from typing import NamedTuple

from stickslip.files.atomic import replaced
from stickslip.files.targets import check_target
from stickslip.plots.palette import VERMILLION


class Section(NamedTuple):
    """A part of a page: its heading, plain text, and what is in it, HTML as `parts` makes it."""

    heading: str
    html: str


def page(
    title: str, summary: str, sections: Sequence[Section | tuple[str, str]], *, warnings: Sequence[str] = (),
    style: str = "",
) -> str:  # fmt: skip
    """A page as text. title, summary : plain text. warnings : as `parts.warning` makes them. style : more CSS."""
    return Template(_PAGE).substitute(
        title=escape(title),
        summary=escape(summary),
        warnings="\n".join(warnings),
        sections="\n".join(f"<section>\n<h2>{escape(name)}</h2>\n{html}\n</section>" for name, html in sections),
        red=VERMILLION,
        style=style,
    )


def write_page(path: str | os.PathLike[str], text: str) -> Path:
    """Write a page, as PDF where the name ends so, replacing `path` only once it is whole. Raises StoreError."""
    check_target(path, "page")
    with replaced(path) as temporary:
        is_pdf = os.fspath(path).lower().endswith(".pdf")
        temporary.write_bytes(_printed(text) if is_pdf else text.encode(errors="backslashreplace"))
    return Path(path)


def _printed(text: str) -> bytes:
    """A page as PDF, on A4, as the rules for print have it, in the letters that matplotlib brings."""
    import plutoprint
    from matplotlib import get_data_path

    fonts = Path(get_data_path(), "fonts", "ttf")
    faces = "".join(
        f"@font-face {{ font-family: '{name}'; font-weight: {weight}; src: url('{(fonts / file).as_uri()}'); }}\n"
        for name, weight, file in (("page", 400, "DejaVuSans.ttf"), ("page", 700, "DejaVuSans-Bold.ttf"),
                                   ("page mono", 400, "DejaVuSansMono.ttf"))
    )  # fmt: skip
    book, out = plutoprint.Book(plutoprint.PAGE_SIZE_A4), BytesIO()
    book.load_html(
        text, user_style=faces + "* { font-family: 'page' !important } pre { font-family: 'page mono' !important }"
    )
    book.write_to_pdf_stream(out)
    return out.getvalue()


# Places to fill are `$name` (string.Template; a dollar itself is written twice).
_PAGE = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>$title</title>
<style>
:root { color-scheme: light dark; --ink: #1c1c1c; --paper: #fff; --faint: #666; --line: #ddd; --shade: #f5f5f5; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e4e4; --paper: #181818; --faint: #a0a0a0; --line: #3c3c3c; --shade: #242424; }
}
* { box-sizing: border-box; }
body { margin: 2rem auto; max-width: 70rem; padding: 0 1.2rem; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; overflow-wrap: break-word; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .7rem; padding-bottom: .2rem; border-bottom: 1px solid var(--line);
  break-after: avoid; }
p { margin: .5rem 0; max-width: 48rem; }
figure { margin: 1rem 0; break-inside: avoid; }
figcaption { margin: .3rem 0; max-width: 48rem; }
img { display: block; max-width: 100%; height: auto; background: #fff; border-radius: 4px; }
.maps { display: flex; flex-wrap: wrap; gap: 0 2rem; align-items: flex-start; }
.legend { max-width: none; }
.legend span { display: inline-block; padding: .1rem .6rem; margin: .15rem .3rem .15rem 0; border-radius: 3px; }
.warning { border-left: 4px solid $red; padding: .3rem .8rem; background: var(--shade); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .8rem; font-variant-numeric: tabular-nums; }
th, td { padding: .15rem .5rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
thead th { vertical-align: bottom; border-bottom: 2px solid var(--faint); font-weight: 600; line-height: 1.25;
  white-space: normal; }
thead small, tbody th { color: var(--faint); font-weight: 400; }
th.text, td.text { text-align: left; }
td.text { white-space: normal; min-width: 7rem; }
tr { break-inside: avoid; }
dl { margin: .5rem 0; }
dl div { display: flex; gap: 1rem; padding: .1rem 0; }
dt { flex: 0 0 17rem; color: var(--faint); }
dd { margin: 0; flex: 1; min-width: 0; }
dl.short dt { flex-basis: 7rem; }
dl.two { columns: 2 24rem; column-gap: 2.5rem; }
dl.two div { break-inside: avoid; }
pre { font: .78rem/1.4 ui-monospace, Consolas, Menlo, monospace; background: var(--shade); padding: .8rem 1rem;
  border-radius: 4px; white-space: pre-wrap; overflow-wrap: anywhere; }
.details { font-size: .8rem; }
.details h2 { font-size: .95rem; margin-top: 1.4rem; }
@page { size: A4; margin: 14mm 15mm; @bottom-right { content: counter(page) " / " counter(pages); font-size: 7pt; } }
@media print {
  :root { color-scheme: light; --ink: #000; --paper: #fff; --faint: #333; --line: #bbb; --shade: #fff; }
  body { margin: 0; padding: 0; max-width: none; font-size: 9.5pt; line-height: 1.35; }
  h1 { font-size: 15pt; }
  h2 { font-size: 11pt; margin: 4mm 0 1.5mm; }
  p, figcaption { max-width: none; margin: 1mm 0; }
  figure { margin: 2mm 0; }
  img { max-height: 205mm; object-fit: contain; }
  pre { font-size: 6.5pt; padding: 0; }
  dl div { break-inside: avoid; }
  .details { break-before: page; font-size: 7pt; line-height: 1.25; }
  .details h2 { font-size: 9pt; margin: 2.5mm 0 .5mm; }
  .details dl dt { flex-basis: 28mm; }
  .details dl.names dt { flex-basis: 64mm; }
  dl.two { columns: auto; }
  .details table { font-size: 6.5pt; }
  .details pre { font-size: 5.5pt; }
  table { font-size: 7.5pt; }
  th, td { padding: .1rem .35rem; }
  td.text { min-width: 0; }
  .wide { overflow: visible; }
  .maps { display: block; }
}
$style</style>
</head>
<body>
<header>
<h1>$title</h1>
<p>$summary</p>
</header>
$warnings
<main>
$sections
</main>
</body>
</html>
"""
