"""`help`: the pages of the documentation in the terminal.

A wheel carries the pages inside the package (``stickslip/pages_of_docs``); in a checkout they are its README and the
folder of its pages. One text serves the site, the repository and the terminal.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import click
from click.shell_completion import CompletionItem

from stickslip.cli import screen
from stickslip.cli.exits import fail
from stickslip.vocabulary import beyond
from stickslip.vocabulary.suggest import or_meant

_PACKAGE = Path(__file__).resolve().parents[1]
_INSTALLED = _PACKAGE / "pages_of_docs"
_CHECKOUT = _PACKAGE.parents[1]
_WIDEST = 100  # characters of a line of prose


def _complete(_context: click.Context, _parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    return [CompletionItem(name, help=title(page)) for name, page in pages().items() if name.startswith(incomplete)]


@click.command(
    "help",
    epilog="""\b
Examples:
  stickslip help
  stickslip help units""",
)
@click.argument("topic", nargs=-1, shell_complete=_complete)
@click.pass_context
def help_command(context: click.Context, topic: tuple[str, ...]) -> None:
    """Read a page of the documentation here in the terminal.

    Without TOPIC it lists the pages.
    """
    known, word = pages(), " ".join(topic)
    if not word:
        return _list_pages(known)
    group = context.parent.command.commands  # type: ignore[union-attr]
    name = Path(word).name.removesuffix(".md")
    if name in known:
        also = f"\n\nThe command: `stickslip {name} --help`" if name in group else ""
        _show(known[name].read_text(encoding="utf-8").rstrip() + also)
    elif command := group.get(name):
        screen.echo(command.get_help(click.Context(command, info_name=name, parent=context.parent)))
    elif sentence := beyond.hint(word):
        screen.echo(sentence)
    else:
        fail(f"{word!r} is no topic{or_meant(word, [*known, *group])}\n"
             "hint: `stickslip help` lists the topics; `stickslip help glossary` explains the words")  # fmt: skip


def _list_pages(known: dict[str, Path]) -> None:
    """Print the pages with what they are about, under the headings and in the order of the site's first page."""
    left, width = dict(known), max(map(len, known), default=0)
    screen.echo("Pages, shown by `stickslip help NAME`:")
    front = _folders()[0] / "index.md"
    for line in front.read_text(encoding="utf-8").splitlines() if front.is_file() else ():
        if line.startswith("## "):
            screen.echo(f"\n{line[3:].strip()}:")
        elif (entry := re.match(r"- \[([^]]+)\]\(([\w-]+)\.md\)(.*)", line)) and left.pop(entry[2], None):
            screen.echo(f"  {entry[2]:{width}}  {entry[1]}{entry[3]}")
    for name, page in left.items():
        screen.echo(f"  {name:{width}}  {title(page)}")
    screen.echo(f"\nThe files are in {_folders()[0]}")


def _folders() -> tuple[Path, Path]:
    """The folder of the pages, and that of README."""
    return (_INSTALLED, _INSTALLED) if _INSTALLED.is_dir() else (_CHECKOUT / "docs", _CHECKOUT)


def pages() -> dict[str, Path]:
    """All pages by name, README among them as `overview`; sorted. The front of the site is none."""
    folder, root = _folders()
    files = {path.stem: path for path in folder.glob("*.md") if path.stem.lower() not in ("index", "readme")}
    files["overview"] = root / "README.md"
    return {name: path for name, path in sorted(files.items()) if path.is_file()}


def title(page: Path) -> str:
    """The first heading of a page."""
    lines = page.read_text(encoding="utf-8").splitlines()
    return next((line[2:].strip() for line in lines if line.startswith("# ")), page.stem)


def _show(markdown: str) -> None:
    """A text in Markdown: set for the terminal, by pages where it is long; as it is for a pipe or a file."""
    console = screen.terminal()
    if not console.is_terminal:
        return screen.echo(markdown)
    from rich.markdown import Markdown

    page = Markdown(markdown, code_theme="bw" if console.no_color else "ansi_dark")
    console.soft_wrap = False
    with console.capture() as captured:
        console.print(page, width=min(console.width, _WIDEST))
    if captured.get().count("\n") > console.height and sys.stdin.isatty():
        return click.echo_via_pager(captured.get())
    click.echo(captured.get(), nl=False)  # with the colours of a terminal
