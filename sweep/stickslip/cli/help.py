"""`help`: the pages of the documentation in the terminal, and the meaning of a word.

A wheel carries the pages inside the package (``stickslip/pages_of_docs``); in a checkout they are its README and the
folder of its pages. One text serves the site, the repository and the terminal.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from stickslip.cli import screen
from stickslip.cli.exits import fail
from stickslip.vocabulary import beyond, results, units
from stickslip.vocabulary.flags import REGIME_MESSAGES, REGIMES, STATUS_MESSAGES
from stickslip.vocabulary.studies import STUDIES

if TYPE_CHECKING:
    from stickslip.vocabulary.parameter import Parameter, Variable

_PACKAGE = Path(__file__).resolve().parents[1]
_INSTALLED = _PACKAGE / "pages_of_docs"
_CHECKOUT = _PACKAGE.parents[1]
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
    "json": ("runs", "Scripts"), "slurm": ("runs", "Shards"), "cluster": ("runs", "Shards"),
}  # fmt: skip
_WIDEST = 100  # characters of a line of prose


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
    from stickslip.vocabulary.suggest import nearest

    known, word = pages(), " ".join(topic)
    word = word.rpartition("/")[2] if word.endswith(".md") else word
    if not word:
        return _list_pages(known)
    assert context.parent is not None
    commands = context.parent.command.commands  # type: ignore[attr-defined]
    if word in commands:
        screen.echo(commands[word].get_help(click.Context(commands[word], info_name=word, parent=context.parent)))
        if word in known:
            screen.echo(f"\nThe page of that name: `stickslip help {word}.md` ({known[word].title})")
        elif page := _ALSO.get(word):
            screen.echo(f"\nMore to read: {_reference(known[page])}")
        return None
    if (name := word.removesuffix(".md")) in commands and name in known:
        screen.echo(f"The page; the command of that name: `stickslip {name} --help`\n")
    parts = [text for text in (beyond.hint(word), _declared(word), _explained(word, known)) if text]
    if not parts:
        near = nearest(word, [*known, *_ALSO, *commands, *QUANTITIES, *_settings(), *_results(), *REGIMES])
        question = f"; did you mean `stickslip help {near}`?" if near else ""
        fail(f"{word!r} is no topic{question}\nhint: `stickslip help` lists the pages")
    return _show("\n\n".join(parts))


def _list_pages(known: dict[str, Page]) -> None:
    """Print the pages with what they are about, under the headings and in the order of the site's first page."""
    left, width = dict(known), max(map(len, known), default=0)
    screen.echo("Pages, shown by `stickslip help NAME`:")
    front = _folders()[0] / "index.md"
    for line in front.read_text(encoding="utf-8").splitlines() if front.is_file() else ():
        if line.startswith("## "):
            screen.echo(f"\n{line[3:].strip()}:")
        elif (entry := re.match(r"- \[([^]]+)\]\(([\w-]+)\.md\)(.*)", line)) and left.pop(entry[2], None):
            screen.echo(f"  {entry[2]:{width}}  {entry[1]}{entry[3]}")
    for page in left.values():
        screen.echo(f"  {page.name:{width}}  {page.title}")
    screen.echo("\nAlso any quantity, result, regime or command:  stickslip help stiffness")


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
    """All pages by name, README among them as `overview`; sorted. The front of the site is none."""
    folder, root = _folders()
    files = {path.stem: path for path in folder.glob("*.md") if path.stem.lower() not in ("index", "readme")}
    files["overview"] = root / "README.md"
    return {
        name: Page(name, path.read_text(encoding="utf-8")) for name, path in sorted(files.items()) if path.is_file()
    }


def _reference(page: Page, heading: str = "") -> str:
    return f"`stickslip help {page.name}` ({heading or page.title})"


def _explained(topic: str, known: dict[str, Page]) -> str | None:
    """Text about a word: a page, else the rows of the glossary and the sections named after it."""
    word = topic.strip().lower().removesuffix(".md")
    if word in known:
        return known[word].text
    pattern, first, page = _pattern(word), _FIRST.get(word), known.get(_ALSO.get(word, ""))
    sections = [
        (about, heading, text)
        for about in known.values() if about.name not in _RECORDS
        for heading, text in about.sections() if pattern.search(heading) or (about.name, heading) == first
    ]  # fmt: skip
    sections.sort(key=lambda section: (section[0].name, section[1]) != first)
    parts = []
    if "glossary" in known and all(about.name != "glossary" for about, _, _ in sections):
        parts = [f"- {text}" for names, text in known["glossary"].terms() if pattern.search(names)]
    if not parts and not sections:
        return page.text if page else None
    parts += [text for _, _, text in sections[:2]]
    more = [_reference(about, heading) for about, heading, _ in sections[2:]] + ([_reference(page)] if page else [])
    return "\n\n".join([*parts, *([f"More to read: {'; '.join(more)}"] if more else [])])


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

    tables = (*(study_class(key).variables for key in STUDIES), results.TRACE_VARIABLES,
              results.MATERIAL_VARIABLES, results.MAP_VARIABLES)  # fmt: skip
    return {name: declared for table in tables for name, declared in table.items()}


def _declared(word: str) -> str:
    """Declarations of a name in the tables of the program: a quantity, a result, a regime or a status."""
    from stickslip.vocabulary.quantities import QUANTITIES
    from stickslip.vocabulary.suggest import synonym_of

    name, settings, variables = word.replace(" ", "_").replace("-", "_"), _settings(), _results()
    known = (*QUANTITIES, *settings, *variables, *REGIME_MESSAGES, *STATUS_MESSAGES)
    name = name if name in known else synonym_of(word, QUANTITIES) or name
    texts = []
    if quantity := QUANTITIES.get(name):
        default = (
            f"{quantity.written(quantity.default)} unless given"
            if quantity.default is not None
            else f"{quantity.absent} unless given"
            if quantity.absent
            else "it must be given"
        )
        texts.append(f" in `{quantity.section}` or `axes`: {quantity.long_name}; {quantity.expected}; {default}.")
    elif setting := settings.get(name):
        texts.append(f" in the section `{setting.section}`: {setting.long_name}; {setting.expected}.")
    if variable := variables.get(name):
        unit = "" if variable.units in ("parameter", "flag") else units.spelled(variable.units)
        texts.append(f" in results: {variable.long_name}{f', {unit}' if unit else ''}. {variable.comment}".rstrip())
    texts += [f", a regime: {REGIME_MESSAGES[name]}."] if name in REGIME_MESSAGES else []
    texts += [f", a status: {STATUS_MESSAGES[name]}."] if name in STATUS_MESSAGES else []
    return "\n\n".join(f"**{name}**{text}" for text in texts)


# --- for the terminal -------------------------------------------------------------------------------------------------

_PARTS = r"""(?msx)  # of a page: what stays as it is, what only a site shows, formulas, links
    (?P<only_site> ^```\{.*?^```\n? | !\[[^\]]*\]\([^)]*\)\n? | ^<!--.*?-->\n? )
  | (?P<code> ^```.*?^```[^\n]*$ | (?P<ticks>`+)[^\n]*?(?P=ticks)
            | (?<=\n\n)(?:(?:[ ]{4}|\t)[^\n]*(?:\n|\Z) | \n(?=[ ]{4}))+ )
  | ^\$\$\n(?P<formula>.*?)^\$\$
  | (?<![\\$])\$(?P<inline>[^$\n`]+)\$
  | \[(?P<text>[^\]]+)\]\((?:(?:[\w.]+/)*(?P<page>[\w-]+)\.md(?:\#[\w-]*)?|(?!https?:)[^)\s]*)\)
"""
# Of TeX, innermost braces first; signs are named as in HTML, but for these.
_TEX = (
    (r"([_^])\{(\w)\}", r"\1\2"),
    (r"([_^])\{([^{}]*)\}", r"\1(\2)"),
    (r"\\sqrt\{([^{}]*)\}", r"sqrt(\1)"),
    (r"\\(?:mathrm|operatorname|text|mathit)\{([^{}]*)\}", r"\1"),
    (
        r"\\[dt]?frac\{([^{}]*)\}\{([^{}]*)\}",
        lambda m: "/".join(x if re.fullmatch(r"\\?\w+", x) else f"({x})" for x in m.groups()),
    ),
)
_SIGNS = {"cdot": "·", "to": "→", "infty": "∞", "partial": "∂", "ldots": "...", "quad": "   ", "qquad": "      "}


def for_terminal(text: str) -> str:
    """A page without what only a site shows: pictures, directives, formulas as TeX, links between pages."""
    return re.sub(_PARTS, _part_for_terminal, text)


def _part_for_terminal(part: re.Match[str]) -> str:
    if part["only_site"] or part["code"]:
        return part["code"] or ""
    if tex := part["formula"]:
        return f"    {plain_formula(tex)}"
    if tex := part["inline"]:
        return plain_formula(tex)
    text, page = for_terminal(part["text"]), part["page"]
    if page is None:
        return text
    command = f"`stickslip help {page.lower()}`"
    return command if text.endswith(".md") else f"{text} ({command})"


def plain_formula(tex: str) -> str:
    """A formula in TeX as one line of characters."""
    from html.entities import html5

    tex, before = re.sub(r"\\(?:left|right|[bB]igg?[lr]?)(?![A-Za-z])", "", tex), ""
    while tex != before:
        before = tex
        for pattern, plain in _TEX:
            tex = re.sub(pattern, plain, tex)
    tex = re.sub(r"\\([A-Za-z]+)", lambda m: _SIGNS.get(m[1]) or html5.get(f"{m[1]};", m[1]), tex)
    return " ".join(re.sub(r"\\[,;:! ]", " ", tex).translate({ord(mark): None for mark in "\\{}"}).split())


def _show(markdown: str) -> None:
    """A text in Markdown: set for the terminal, by pages where it is long; as it is for a pipe or a file."""
    text, console = for_terminal(markdown), screen.terminal()
    if not console.is_terminal:
        return screen.echo(text)
    from rich.markdown import Markdown
    from rich.theme import Theme

    page = Markdown(text, code_theme="bw" if console.no_color else "ansi_dark")
    console.push_theme(Theme({"markdown.code": "cyan", "markdown.code_block": "cyan"}))
    console.soft_wrap = False
    with console.capture() as captured:
        console.print(page, width=min(console.width, _WIDEST))
    if captured.get().count("\n") > console.height and sys.stdin.isatty():
        return click.echo_via_pager(captured.get())
    click.echo(captured.get(), nl=False)  # with the colours of a terminal
