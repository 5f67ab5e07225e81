"""The pages of the documentation as an installed package has them, and what there is to read about a word.

A wheel carries them inside the package (``stickslip/pages_of_docs``); in a checkout they are its README and the folder
of its pages. One text serves the site, the repository and the terminal.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from stickslip.vocabulary.words import nearest

_PACKAGE = Path(__file__).resolve().parents[1]
_INSTALLED = _PACKAGE / "pages_of_docs"
_CHECKOUT = _PACKAGE.parents[1]
_NO_TOPICS = {"index", "readme"}  # the front of the site, and that of the repository, which has another name here
_NAMES = {"README": "overview"}
_RECORDS = ("speed", "gallery")  # what was measured and drawn; their sections explain no words
_SHORT = 4  # characters
_ALSO = {  # other words for a page
    "cluster": "dask", "resume": "runs", "shard": "runs", "slurm": "dask", "zarr": "runs", "netcdf": "variables",
    "yaml": "configuration", "config": "configuration", "axes": "configuration", "files": "variables",
    "readme": "overview", "python": "api", "equation": "model", "friction": "model", "hysteresis": "model",
    "ageing": "model", "aging": "model", "completion": "shell", "colours": "shell", "si": "units",
    "excel": "materials", "xlsx": "materials", "csv": "materials", "export": "materials",
    "spreadsheet": "materials", "lubricant": "materials", "grease": "materials",
}  # fmt: skip
_FIRST = {  # the section to read first, by page and heading
    "json": ("runs", "Scripts"),
    "slurm": ("runs", "Shards"),
    "cluster": ("runs", "Shards"),
}


@dataclass(frozen=True)
class Page:
    """One page: its name, and its text in Markdown."""

    name: str
    text: str

    @property
    def title(self) -> str:
        """Its first heading."""
        return next((line[2:].strip() for line in self.text.splitlines() if line.startswith("# ")), self.name)

    def sections(self) -> Iterator[tuple[str, str]]:
        """Headings and the text under them with their subsections, without the page's own."""
        prose = re.sub(r"^```.*?^```", lambda m: re.sub(r"[^\n]", " ", m[0]), self.text, flags=re.MULTILINE | re.DOTALL)
        marks = [(m.start(), len(m[1]), m[2]) for m in re.finditer(r"^(#{2,3}) (.+)$", prose, re.MULTILINE)]
        for i, (begin, level, heading) in enumerate(marks):
            end = next((start for start, other, _ in marks[i + 1 :] if other <= level), None)
            yield heading, self.text[begin:end].strip()

    def terms(self) -> Iterator[tuple[str, str]]:
        """What a table of words says: the first two cells of a row, and the whole row as a sentence."""
        for line in self.text.splitlines():
            cells = [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            if len(cells) == 3 and not set(cells[0]) <= set("-: ") and cells[0] != "here":
                also = f" (in the field: {cells[1]})" if cells[1] else ""
                yield f"{cells[0]}, {cells[1]}", f"**{cells[0]}**{also}: {cells[2]}"


def _folders() -> tuple[Path, Path]:
    """Where the pages are, and where README is."""
    return (_INSTALLED, _INSTALLED) if _INSTALLED.is_dir() else (_CHECKOUT / "docs", _CHECKOUT)


def pages() -> dict[str, Page]:
    """All pages by name, those of the repository's root among them; sorted."""
    folder, root = _folders()
    files = {path for path in folder.glob("*.md") if path.stem.lower() not in _NO_TOPICS} | {root / "README.md"}
    texts = {_NAMES.get(path.stem, path.stem): path.read_text(encoding="utf-8") for path in files if path.is_file()}
    return {name: Page(name, texts[name]) for name in sorted(texts)}


def contents(known: dict[str, Page]) -> Iterator[tuple[str, list[tuple[str, str]]]]:
    """The pages under the headings of the site's first page, each with what it is about; those it lacks at the end."""
    front = _folders()[0] / "index.md"
    left = {name: page.title for name, page in known.items()}
    heading, rows = "", list[tuple[str, str]]()
    for line in front.read_text(encoding="utf-8").splitlines() if front.is_file() else ():
        if line.startswith("## "):
            if rows:
                yield heading, rows
            heading, rows = line[3:].strip(), []
        elif (entry := re.match(r"- \[([^]]+)\]\(([\w-]+)\.md\)(.*)", line)) and left.pop(entry[2], None):
            rows.append((entry[2], entry[1] + entry[3]))
    yield heading or "Pages", [*rows, *left.items()]


def about(topic: str, known: dict[str, Page]) -> str | None:
    """What there is to read about a word: a page, else what the glossary says of it and the sections named after it."""
    word = topic.strip().lower().removesuffix(".md")
    if word in known:
        return known[word].text
    sections = list(_sections(word, known))
    sections.sort(key=lambda section: section[:2] != _FIRST.get(word))
    parts = [] if any(page == "glossary" for page, _, _ in sections) else _terms(word, known)
    page = page_about(word, known)
    if not parts and not sections:
        return None if page is None else known[page].text
    more = [(name, heading) for name, heading, _ in sections[2:]] + ([(page, known[page].title)] if page else [])
    parts += [text for _, _, text in sections[:2]]
    if more:
        parts.append("More to read: " + "; ".join(f"`stickslip help {name}` ({title})" for name, title in more))
    return "\n\n".join(parts)


def page_about(topic: str, known: dict[str, Page]) -> str | None:
    """The page on which a word is explained, other than the page of its own."""
    page = _ALSO.get(topic.strip().lower())
    return page if page in known else None


def closest(topic: str, known: dict[str, Page], others: list[str]) -> str | None:
    """The topic that was probably meant."""
    return nearest(topic, [*known, *_ALSO, *others])


def _terms(word: str, known: dict[str, Page]) -> list[str]:
    """The rows of the glossary in which a word is explained."""
    glossary = known.get("glossary")
    return [] if glossary is None else [f"- {text}" for names, text in glossary.terms() if _pattern(word).search(names)]


def _sections(word: str, known: dict[str, Page]) -> Iterator[tuple[str, str, str]]:
    """Page, heading and text of the sections that are named after a word, and of the one to read first."""
    for page in known.values():
        for heading, text in page.sections() if page.name not in _RECORDS else ():
            if _pattern(word).search(heading) or (page.name, heading) == _FIRST.get(word):
                yield page.name, heading, text


def _pattern(word: str) -> re.Pattern[str]:
    """Where a text names a word, in any of its forms; a short one by itself only."""
    stem = word[:-1] if len(word) > 4 and word.endswith("s") and not word.endswith("ss") else word
    end = r"(?![A-Za-z_])" if len(word) < _SHORT else ""
    return re.compile(rf"(?<![A-Za-z_]){re.escape(stem)}{end}", re.IGNORECASE)


# --- for the terminal -------------------------------------------------------------------------------------------------

_SIGNS = {
    "mu": "μ", "zeta": "ζ", "gamma": "γ", "tau": "τ", "xi": "ξ", "sigma": "σ", "beta": "β", "omega": "ω", "pi": "π",
    "delta": "δ", "Delta": "Δ", "lambda": "λ", "le": "≤", "ge": "≥", "leq": "≤", "geq": "≥", "approx": "≈", "cdot": "·",
    "times": "×", "to": "→", "infty": "∞", "in": "∈", "pm": "±", "ll": "≪", "gg": "≫", "ne": "≠", "partial": "∂",
    "quad": "   ", "qquad": "      ", "ldots": "...", "dots": "...", "int": "∫", "sum": "Σ",
}  # fmt: skip
# A fenced block, and indented lines behind an empty one.
_CODE = re.compile(
    r"^(?P<fence>```|~~~).*?^(?P=fence)[^\n]*$|(?<=\n\n)(?:(?: {4}|\t)[^\n]*(?:\n|\Z)|\n(?= {4}))+",
    re.MULTILINE | re.DOTALL,
)
_INNER = r"\{([^{}]*(?:\{[^{}]*\}[^{}]*)*)\}"
_FRACTION = re.compile(rf"\\[dt]?frac{_INNER}{_INNER}")


def for_terminal(text: str) -> str:
    """A page without what only a site shows: pictures, directives, formulas as TeX, links between pages."""
    text = re.sub(r"^```\{.*?^```\n?", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^\([\w-]+\)=\n|^:::.*\n|^%.*\n|^<!--.*?-->\n?", "", text, flags=re.MULTILINE | re.DOTALL)
    shown, begin = "", 0
    for code in _CODE.finditer(text):
        shown += _prose(text[begin : code.start()]) + code[0]
        begin = code.end()
    return shown + _prose(text[begin:])


def _prose(text: str) -> str:
    """The same for a piece without code."""
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)\n?", "", text)
    text = re.sub(r"^\$\$\n(.*?)^\$\$", lambda m: f"    {plain_formula(m[1])}", text, flags=re.MULTILINE | re.DOTALL)
    in_line = r"(`+)[^\n]*?\1|(?<![\\$])\$([^$\n`]+)\$"  # code, or a formula
    text = re.sub(in_line, lambda m: m[0] if m[1] else plain_formula(m[2]), text)
    text = re.sub(r"\[([^\]]+)\]\((?:[\w.]+/)*([\w-]+)\.md(?:#[\w-]*)?\)", _link, text)
    return re.sub(r"\[([^\]]+)\]\((?!https?:)[^)\s]*\)", r"\1", text)


def plain_formula(tex: str) -> str:
    """A formula in TeX as one line of characters."""
    tex = " ".join(tex.split())
    for _ in range(3):  # fractions in fractions
        tex = _FRACTION.sub(lambda m: f"{_in_brackets(m[1])}/{_in_brackets(m[2])}", tex)
    for pattern, plain in (
        (r"\\sqrt\{([^{}]*)\}", r"sqrt(\1)"),
        (r"\\(?:mathrm|operatorname|text|mathit)\{([^{}]*)\}", r"\1"),
        (r"\\hat\{?\s*([a-z])\}?", "\\1\u0302"),
        (r"\\(?:left|right|[bB]igg?[lr]?)(?![A-Za-z])", ""),
    ):
        tex = re.sub(pattern, plain, tex)
    tex = re.sub(r"\\([A-Za-z]+)", lambda m: _SIGNS.get(m[1], m[1]), tex)
    tex = re.sub(r"\\[,;:! ]", " ", tex).replace("\\", "")
    tex = re.sub(r"([_^])\{([^{}]*)\}", lambda m: m[1] + (m[2] if len(m[2]) == 1 else f"({m[2]})"), tex)
    return re.sub(r" +", " ", tex.replace("{", "").replace("}", "")).strip()


def _in_brackets(tex: str) -> str:
    """Part of a fraction: a single symbol as it is."""
    return tex if re.fullmatch(r"\\?\w+", tex) else f"({tex})"


def _link(match: re.Match[str]) -> str:
    """A link to another page as the command that shows it."""
    text, page = match[1], match[2].lower()
    return f"`stickslip help {page}`" if text.endswith(".md") else f"{text} (`stickslip help {page}`)"
