"""Exceptions and warnings of stickslip, worded so that people can correct it.

ConfigError, QuantityError and PlotError are for people's input, StoreError and its kin for what the
system refuses. A `Problem` is one thing that is wrong with a file, with its position; a `ConfigError` carries all of
them at once. Everything else that is raised is a bug.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from traceback import format_exception
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import xarray as xr

Path = tuple[str | int, ...]
MOST_PROBLEMS = 200  # more are not read, and finding more in a file of nonsense takes minutes
_LONGEST_KEY, _LONGEST_MESSAGE = 60, 2000  # characters; cells of a file may hold 100,000
_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


class Place(NamedTuple):
    """A position in a text; line and column count from 1.

    option : of the command line (`--set system.mass=1 kg`) that gave a value in place of the text.
    """

    line: int
    column: int
    option: str = ""

    def text(self, source: str) -> str:
        """`FILE:4:16`, or `FILE: --set system.mass=1 kg`; `source` is the name of the file."""
        return f"{source}: {self.option}" if self.option else f"{source}:{self.line}:{self.column}"


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong.

    path : keys that lead to it, outermost first; empty for the text as a whole.
    message : what was found and what was expected.
    place : None if the input has no lines (plain data instead of a file).
    hint : the next step, where one helps.
    """

    path: Path
    message: str
    place: Place | None = None
    hint: str | None = None

    def text(self, source: str) -> str:
        """`FILE:LINE:COL: key.path: message`, with the hint on a line of its own.

        source : name of the file; empty for what came from Python.
        """
        where = source if self.place is None else self.place.text(source)
        message = self.message if len(self.message) <= _LONGEST_MESSAGE else f"{self.message[:_LONGEST_MESSAGE]}..."
        parts = [*([where] if where else []), *([dotted(self.path)] if self.path else []), message]
        return visible(": ".join(parts)) + (f"\n  hint: {visible(self.hint)}" if self.hint else "")


class _InInput:
    """An error in people's input, of which IPython shows the message alone; plain Python shows the traceback too."""

    def _render_traceback_(self) -> list[str]:  # which IPython calls
        return [f"{type(self).__name__}: {self}"]


class ConfigError(_InInput, ValueError):
    """A configuration that cannot be used; `problems` lists everything that is wrong with it, in the order of the file.

    `source` is the name of the file, or of the text in angle brackets.
    """

    def __init__(self, source: str, problems: Iterable[Problem]) -> None:
        self.source = source
        self.problems = tuple(sorted(problems, key=lambda p: p.place or (0, 0)))
        super().__init__(source, self.problems)  # these are what pickling calls __init__ with

    @classmethod
    def of(
        cls, source: object, message: str, hint: str | None = None, *, place: Place | None = None, path: Path = ()
    ) -> ConfigError:
        """The error of a single problem."""
        return cls(str(source), [Problem(path, message, place, hint)])

    @classmethod
    def of_files(cls, errors: Sequence[ConfigError]) -> ConfigError:
        """The errors of several files as one."""
        if len(errors) == 1:
            return errors[0]
        several = [(problem, error.source) for error in errors for problem in error.problems]
        return cls(
            "",
            [Problem((), replace(problem, hint=None).text(source), None, problem.hint) for problem, source in several],
        )

    def __str__(self) -> str:
        return "\n".join(problem.text(self.source) for problem in self.problems)


def dotted(path: Path) -> str:
    """A path as people write it: ``axes.mass.values[2]``; keys that are not plain words are quoted."""
    return "".join(f"[{key}]" if isinstance(key, int) else f".{_word(key)}" for key in path).removeprefix(".")


def _word(key: str) -> str:
    short = key if len(key) <= _LONGEST_KEY else f"{key[:_LONGEST_KEY]}..."
    return short if short.isprintable() else repr(short)


def visible(text: str) -> str:
    """The text with control characters written out, as are marks that turn its direction; lines and tabs stay."""
    return _CONTROLS.sub(lambda mark: mark[0].encode("unicode_escape").decode("ascii"), text)


# --- other input ------------------------------------------------------------------------------------------------------


class QuantityError(ValueError):
    """Something that is not the quantity asked for.

    expected : what would be right, in words. hint : the next step, or None. kind : of quantity it is instead, or None.
    """

    def __init__(self, expected: str, hint: str | None = None, kind: str | None = None) -> None:
        self.expected, self.hint, self.kind = expected, hint, kind
        super().__init__(expected, hint, kind)

    def __str__(self) -> str:
        return f"expected {self.expected}" + (f"; {self.hint}" if self.hint else "")


class ArgumentError(_InInput, ValueError):
    """An argument, or the key of that name in a configuration, is not what is possible; `what` says why."""

    def __init__(self, key: str, what: str) -> None:
        super().__init__(f"{key}: {what}")
        self.key, self.what = key, what


class ContradictionError(_InInput, ValueError):
    """Nothing explains some observations; the message names the one that contradicts, `dataset` is the result."""

    def __init__(self, message: str, dataset: xr.Dataset) -> None:
        super().__init__(message)
        self.dataset = dataset


class FitWarning(UserWarning):
    """A fitted curve is used that its points do not support; the message says what is wrong with it."""


class ExtrapolationWarning(UserWarning):
    """Slip reaches speeds at which nobody measured friction; the message names them."""


class UnitWarning(UserWarning):
    """Numbers without a unit that are implausible in SI; the message names them as they were understood."""


# --- files ------------------------------------------------------------------------------------------------------------


_IN_PYTHON = {"fresh": "fresh=True", "output": "output", "store": "store", "run": "stickslip.run"}
_ON_COMMAND_LINE = {"fresh": "--fresh", "output": "--output", "store": "--store", "run": "stickslip run"}


class StoreError(_InInput, OSError):
    """A dataset could not be written or read; the message names the path, the reason and, if there is one, a remedy.

    hint : the remedy, where it is an option, whose name {fresh}, {output}, {store} or {run} stands for: the message
        has it in the words of Python, `on_command_line` in those of the command line.
    """

    def __init__(self, *args: object, hint: str | None = None) -> None:
        super().__init__(*args)
        self.hint = hint

    def __str__(self) -> str:
        return self._text(_IN_PYTHON)

    @property
    def on_command_line(self) -> str:
        """The message for somebody who gave a command."""
        return self._text(_ON_COMMAND_LINE)

    def _text(self, words: dict[str, str]) -> str:
        return super().__str__() + (f"\nhint: {self.hint.format(**words)}" if self.hint else "")


def reason(error: BaseException) -> str:
    """The reason on one line and without the path, which the message names already."""
    if isinstance(error, OSError) and error.strerror:
        return str(error.strerror)
    lines = str(error).splitlines()
    return lines[0] if lines else type(error).__name__


# --- runs -------------------------------------------------------------------------------------------------------------


class IncompleteError(StoreError):
    """Not everything could be computed or written; what was is safe in the working store."""


class ClusterError(RuntimeError):
    """The machines that blocks were to be computed on cannot be used, or are gone."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run: `done` of `cells` cells are finished; or of what else is `counted`.

    kept : the working store they are safe in, from which the same call resumes; None for a run without output.
    dataset : they themselves, for a run without output; None for others. during : what was interrupted, where nothing
    was computed yet.
    """

    def __init__(
        self, done: int, cells: int, kept: str | None = None, dataset: xr.Dataset | None = None, counted: str = "cells",
        during: str | None = None,
    ):  # fmt: skip
        self.done, self.cells, self.kept, self.dataset, self.counted = done, cells, kept, dataset, counted
        super().__init__(
            f"interrupted while {during}; nothing was changed" if during else f"interrupted: {self.kept_cells}"
        )

    @property
    def kept_cells(self) -> str:
        """The cells that have been saved, in words."""
        place = "finished, not written to a file"
        if self.kept:
            place = f"safe in {self.kept}; the same command resumes from there"
        return f"{self.done:,} of {self.cells:,} {self.counted} are {place}"


class StoppedError(Exception):
    """The stop flag was raised while a block was computed."""


class BlockFailedError(Exception):
    """A block could not be computed, and the run is to stop at that; the failure is recorded in the store."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


class DamagedManifestError(ValueError):
    """The bytes are not those of a manifest; the message says why."""


class DamagedBlockError(ValueError):
    """The bytes are not those of a finished block; the message says why."""


class UnlikeWorkerError(Exception):
    """A worker runs other versions than the process whose blocks it is to compute."""


class UncomputedError(Exception):
    """An exception raised while computing: its type, message and traceback as text, since not all can travel."""

    def __init__(self, message: str, trace: str) -> None:
        super().__init__(message, trace)
        self.message, self.trace = message, trace

    @classmethod
    def of(cls, error: Exception) -> UncomputedError:
        """The message of an exception."""
        return cls(f"{type(error).__name__}: {error}", "".join(format_exception(error)))

    def __str__(self) -> str:
        return self.message


# --- results ----------------------------------------------------------------------------------------------------------


class NotReachedError(RuntimeError):
    """A trajectory could not be integrated to its end; the message says how far, and why."""


class PlotError(_InInput, ValueError):
    """This dataset cannot be drawn as asked; the message says what is possible."""
