"""`help`: the pages of the documentation in the terminal, and the meaning of a word.

A wheel carries the pages inside the package (``stickslip/pages_of_docs``); in a checkout they are its README and the
folder of its pages. One text serves the site, the repository and the terminal.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from stickslip.cli import screen
from stickslip.cli.exits import fail
from stickslip.vocabulary import results, units
from stickslip.vocabulary.flags import REGIME_MESSAGES, REGIMES, STATUS_MESSAGES
from stickslip.vocabulary.studies import STUDIES

if TYPE_CHECKING:
    from stickslip.vocabulary.parameter import Parameter, Variable

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
_WIDEST = 100  # characters of a line of prose
_ABOUT = "Also any quantity, result, regime or command:  stickslip help stiffness"


def _complete(_context: click.Context, _parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    return [CompletionItem(name, help=page.title) for name, page in pages().items() if name.startswith(incomplete)]


@click.command(
    "help",
    epilog="""\b
Examples:
  stickslip help
  stickslip help units
  stickslip help "stick phase"
  stickslip help mu_stop""",
)
@click.argument("topic", nargs=-1, shell_complete=_complete)
@click.pass_context
def help_command(context: click.Context, topic: tuple[str, ...]) -> None:
    """Read about a topic here in the terminal.

    Without TOPIC it lists the pages. A word that is no page is looked up in the glossary, among the headings of all
    pages, and among the names of configurations and results.
    """
    from stickslip.vocabulary.quantities import QUANTITIES

    known, word = pages(), " ".join(topic)
    word = word.rpartition("/")[2] if word.endswith(".md") else word
    if not word:
        return _list(list(contents(known)))
    assert context.parent is not None
    commands = context.parent.command.commands  # type: ignore[attr-defined]
    if word in commands:
        command = commands[word]
        screen.echo(command.get_help(click.Context(command, info_name=word, parent=context.parent)))
        if word in known:
            screen.echo(f"\nThe page of that name: `stickslip help {word}.md` ({known[word].title})")
        elif page := page_about(word, known):
            screen.echo(f"\nMore to read: `stickslip help {page}` ({known[page].title})")
        return None
    if (name := word.removesuffix(".md")) in commands and name != word and name in known:
        screen.echo(f"The page; the command of that name: `stickslip {name} --help`\n")
    parts = [text for text in (_beyond_the_model(word, known), _declared(word), about(word, known)) if text]
    if not parts:
        near = closest(word, known, [*commands, *QUANTITIES, *_settings(), *_results(), *REGIMES])
        question = f"; did you mean `stickslip help {near}`?" if near else ""
        fail(f"{word!r} is no topic{question}\nhint: `stickslip help` lists the pages")
    return _show("\n\n".join(parts))


def _list(chapters: list[tuple[str, list[tuple[str, str]]]]) -> None:
    """Print the pages with what they are about, in the order of the site."""
    width = max((len(name) for _, rows in chapters for name, _ in rows), default=0)
    screen.echo("Pages, shown by `stickslip help NAME`:")
    for heading, rows in chapters:
        screen.echo(f"\n{heading}:")
        for name, title in rows:
            screen.echo(f"  {name:{width}}  {title}")
    screen.echo(f"\n{_ABOUT}")


# --- pages ------------------------------------------------------------------------------------------------------------


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
        """Rows of a table of words: the first two cells, and the whole row as a sentence."""
        for line in self.text.splitlines():
            cells = [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            if len(cells) == 3 and not set(cells[0]) <= set("-: ") and cells[0] != "here":
                also = f" (in the field: {cells[1]})" if cells[1] else ""
                yield f"{cells[0]}, {cells[1]}", f"**{cells[0]}**{also}: {cells[2]}"


def _folders() -> tuple[Path, Path]:
    """The folder of the pages, and that of README."""
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
    """Text about a word: a page, else the rows of the glossary and the sections named after it."""
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
    from stickslip.vocabulary.suggest import nearest

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
    """A pattern for a word in any of its forms; a short one by itself only."""
    stem = word[:-1] if len(word) > 4 and word.endswith("s") and not word.endswith("ss") else word
    end = r"(?![A-Za-z_])" if len(word) < _SHORT else ""
    return re.compile(rf"(?<![A-Za-z_]){re.escape(stem)}{end}", re.IGNORECASE)


# --- names of configurations and results ------------------------------------------------------------------------------


def _settings() -> dict[str, Parameter]:
    """Keys of configurations besides quantities of cells, by name."""
    from stickslip.config.studies import section_class
    from stickslip.vocabulary.settings import SETTINGS

    sections = [*SETTINGS.values(), *(section_class(key).rows for key in STUDIES)]
    return {name: declared for section in sections for name, declared in section.items()}


def _results() -> dict[str, Variable]:
    """Variables of results of every kind, by name; of a name that several have, that of maps or of comparisons."""
    from stickslip.config.studies import study_class

    tables = (*(study_class(key).variables for key in STUDIES), results.TRACE_VARIABLES, results.LEVEL_VARIABLES,
              results.MATERIAL_VARIABLES, results.MAP_VARIABLES)  # fmt: skip
    return {name: declared for table in tables for name, declared in table.items()}


def _beyond_the_model(word: str, known: Mapping[str, Page]) -> str | None:
    """A sentence on a word for which the model has nothing, and the page about tools that have it."""
    from stickslip.vocabulary.beyond import PAGE, beyond_the_model

    sentence, page = beyond_the_model(word), known.get(PAGE)
    more = f" More to read: `stickslip help {PAGE}` ({page.title})." if page else ""
    return f"{sentence}.{more}" if sentence else None


def _declared(word: str) -> str | None:
    """Declarations of a name in the tables of the program: a quantity, a result, a regime or a status."""
    from stickslip.vocabulary.quantities import QUANTITIES
    from stickslip.vocabulary.suggest import synonym_of

    name, variables = word.replace(" ", "_").replace("-", "_"), _results()
    known = (*QUANTITIES, *_settings(), *variables, *REGIME_MESSAGES, *STATUS_MESSAGES)
    name = name if name in known else synonym_of(word, QUANTITIES) or name
    if name not in known:  # the room of the rig takes a second to load
        from stickslip.rig.quantities import EXACT, FEATURES

        variables = FEATURES | EXACT
    return "\n\n".join(_declarations(name, variables)) or None


def _declarations(name: str, variables: Mapping[str, Variable]) -> Iterator[str]:
    from stickslip.vocabulary.quantities import QUANTITIES

    if quantity := QUANTITIES.get(name):
        written = quantity.written(quantity.default) if quantity.default is not None else None
        default = "it must be given" if written is None else f"{written} unless given"
        yield f"**{name}** in `{quantity.section}` or `axes`: {quantity.long_name}; {quantity.expected}; {default}."
    elif setting := _settings().get(name):
        yield f"**{name}** in the section `{setting.section}`: {setting.long_name}; {setting.expected}."
    if variable := variables.get(name):
        unit = "" if variable.units in ("parameter", "flag") else units.spelled(variable.units)
        yield f"**{name}** in results: {variable.long_name}{f', {unit}' if unit else ''}. {variable.comment}".strip()
    for kind, messages in (("regime", REGIME_MESSAGES), ("status", STATUS_MESSAGES)):
        if name in messages:
            yield f"**{name}**, a {kind}: {messages[name]}."


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


def _show(markdown: str) -> None:
    """A text in Markdown: set for the terminal, by pages where it is long; as it is for a pipe or a file."""
    text = for_terminal(markdown)
    console = screen.terminal()
    if not console.is_terminal:
        return screen.echo(text)
    from rich.markdown import Markdown
    from rich.theme import Theme

    page = Markdown(text, code_theme="bw" if console.no_color else "ansi_dark")
    console.push_theme(Theme({"markdown.code": "cyan", "markdown.code_block": "cyan"}))
    console.soft_wrap = False
    width = min(console.width, _WIDEST)
    with console.capture() as captured:
        console.print(page, width=width)
    if captured.get().count("\n") > console.height and sys.stdin.isatty():
        return click.echo_via_pager(captured.get())
    click.echo(captured.get(), nl=False)  # with the colours of a terminal
