"""`help`: the pages of the documentation in the terminal.

A wheel carries the pages inside the package (``stickslip/pages_of_docs``); in a checkout they are its README and the
folder of its pages. One text serves the site, the repository and the terminal.
"""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli import screen
from stickslip.cli.exits import fail
from stickslip.vocabulary.suggest import or_meant

_PACKAGE = Path(__file__).resolve().parents[1]
_INSTALLED = _PACKAGE / "pages_of_docs"
_CHECKOUT = _PACKAGE.parents[1]
_WIDEST = 100  # characters of a line of prose


@click.command("help")
@click.argument("topic", required=False)
@click.pass_context
def help_command(context: click.Context, topic: str | None) -> None:
    """Read a page of the documentation here in the terminal.

    Without TOPIC it lists the pages. What a command does is said by `stickslip COMMAND --help`.
    """
    known = pages()
    if topic is None:
        width = max(map(len, known), default=0)
        screen.echo("Pages, shown by `stickslip help NAME`:\n")
        for name, page in known.items():
            screen.echo(f"  {name:{width}}  {title(page)}")
        return screen.echo(f"\nThe files are in {_folders()[0]}")
    name = Path(topic).name.removesuffix(".md")
    if name in known:
        return _show(known[name].read_text(encoding="utf-8").rstrip())
    parent = context.parent
    command = parent.command.get_command(parent, topic) if parent and isinstance(parent.command, click.Group) else None
    if command is None:
        fail(f"{topic!r} is no topic{or_meant(topic, known)}\nhint: `stickslip help` lists the topics")
    screen.echo(command.get_help(click.Context(command, info_name=topic, parent=parent)))


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
    """A text in Markdown: set for the terminal; as it is for a pipe or a file."""
    console = screen.terminal()
    if not console.is_terminal:
        return screen.echo(markdown)
    from rich.markdown import Markdown

    console.soft_wrap = False
    with console.pager(styles=True):
        console.print(Markdown(markdown), width=min(console.width, _WIDEST))
