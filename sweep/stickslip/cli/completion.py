"""What shells propose after an option: names of quantities, variables, regimes and configurations."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import click
from click.shell_completion import CompletionItem

Words = Callable[[], Iterable[str]]


def _variables() -> Iterable[str]:
    from stickslip.vocabulary.results import MAP_VARIABLES

    return MAP_VARIABLES


def _searchable() -> Iterable[str]:
    from stickslip.vocabulary.quantities import SEARCHABLE

    return SEARCHABLE


def _settings() -> Iterable[str]:
    from stickslip.vocabulary.quantities import PARAMETERS

    return (f"{name}=" for name in PARAMETERS)


def _regimes() -> Iterable[str]:
    from stickslip.vocabulary.flags import REGIMES

    return REGIMES


def _statuses() -> Iterable[str]:
    from stickslip.vocabulary.flags import STATUSES

    return STATUSES


def _configurations() -> Iterable[str]:
    from stickslip.config.examples import config_names

    return config_names()


_BY_OPTION: dict[str, Words] = {  # by the name of the option, in whatever command it is
    "--variable": _variables, "--along": _searchable, "--at": _settings, "--select": _settings, "--mark": _settings,
    "--regime": _regimes, "--status": _statuses,
}  # fmt: skip
_OF_COMMAND: dict[tuple[str, str], Words] = {("init", "--from"): _configurations}


def complete_names(command: click.Command) -> None:
    """Let the shell complete the names that options of a command, and of the commands in it, take."""
    for parameter in command.params:
        if not isinstance(parameter, click.Option) or parameter.metavar == "TIME":
            continue
        for option in parameter.opts:
            words = _OF_COMMAND.get((str(command.name), option)) or _BY_OPTION.get(option)
            if words is not None:
                setattr(parameter, "shell_complete", _proposing(words))  # noqa: B010 - a method of click's, replaced
    for inner in command.commands.values() if isinstance(command, click.Group) else ():
        complete_names(inner)


def _proposing(words: Words) -> Callable[[click.Context, str], list[CompletionItem]]:
    """What click asks an option for: the words that begin with what was typed so far."""
    return lambda _context, incomplete: [CompletionItem(word) for word in words() if word.startswith(incomplete)]
