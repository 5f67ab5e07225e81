"""`help`: the pages of the documentation in the terminal, and what a word means."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from stickslip.cli import screen
from stickslip.cli.exits import fail
from stickslip.vocabulary import results, units
from stickslip.vocabulary.flags import REGIME_MESSAGES, REGIMES, STATUS_MESSAGES

if TYPE_CHECKING:
    from stickslip.cli.manual import Page
    from stickslip.vocabulary.parameter import Parameter
    from stickslip.vocabulary.results import Variable

_WIDEST = 100  # characters of a line of prose
_ABOUT = "Also any quantity, result, regime or command:  stickslip help stiffness"


def _complete(_context: click.Context, _parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    from stickslip.cli.manual import pages

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
    from stickslip.cli.manual import about, closest, contents, page_about, pages
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


def _settings() -> dict[str, Parameter]:
    """What sections of configurations hold besides quantities of cells, by name."""
    from stickslip.vocabulary.settings import SETTINGS

    return {name: declared for section in SETTINGS.values() for name, declared in section.items()}


def _results() -> dict[str, Variable]:
    """What results of every kind hold, by name; of a name that several have, that of maps or of comparisons."""
    tables = (results.MARGIN_VARIABLES, results.CONTOUR_VARIABLES, results.BORDER_VARIABLES,
              results.ATTRACTOR_VARIABLES, results.UNCERTAIN_VARIABLES, results.TRACE_VARIABLES,
              results.LEVEL_VARIABLES, results.MATERIAL_VARIABLES, results.MAP_VARIABLES)  # fmt: skip
    return {name: declared for table in tables for name, declared in table.items()}


def _beyond_the_model(word: str, known: Mapping[str, Page]) -> str | None:
    """What the model does not have of what a word asks for, and the page about tools that have it."""
    from stickslip.vocabulary.beyond import PAGE, beyond_the_model

    sentence, page = beyond_the_model(word), known.get(PAGE)
    more = f" More to read: `stickslip help {PAGE}` ({page.title})." if page else ""
    return f"{sentence}.{more}" if sentence else None


def _declared(word: str) -> str | None:
    """What the tables of the program say of a name: a quantity, a result, a regime or a status."""
    from stickslip.vocabulary.quantities import QUANTITIES
    from stickslip.vocabulary.synonyms import synonym_of

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


def _show(markdown: str) -> None:
    """A text in Markdown: set for the terminal, by pages where it is long; as it is for a pipe or a file."""
    from stickslip.cli.manual import for_terminal

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
