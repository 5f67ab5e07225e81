"""One tab of the browser: its events, the work they ask for beside the loop of the server, and what comes of it."""

from __future__ import annotations

import logging
import shlex
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from html import escape
from math import prod
from time import perf_counter
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.events import Tap

from stickslip.config.model import Config
from stickslip.config.select import cell_of
from stickslip.engine import StopFlag
from stickslip.errors import ConfigError, NotReachedError, StoreError
from stickslip.explore import maps
from stickslip.explore.below import Below, sound_of
from stickslip.explore.borders import Line, border_lines
from stickslip.explore.controls import Controls
from stickslip.explore.live import Latest
from stickslip.explore.maps import Picture
from stickslip.explore.motions import CellMotions, motions_of
from stickslip.explore.page import Page, columns_of, template, template_variables
from stickslip.explore.subject import Subject
from stickslip.explore.told import cell_html, map_csv, motions_csv, place_words, simulate_command
from stickslip.explore.view import (
    COARSE,
    FULL,
    View,
    cell_config,
    config_of,
    first_view,
    is_as_opened,
    with_plane,
)

_LOG = logging.getLogger(__name__)
_BREATH = 0.05  # s, in which the browser draws the coarse map, and a slider that still moves asks for the next
_COMING = "exact borders ..."
At = Mapping[str, float | int]


@dataclass(frozen=True, eq=False)
class Seen:
    """A cell that was computed: where it lies, in words too, what it does, and the line that reproduces it."""

    at: At
    words: str
    motions: CellMotions
    command: str


@dataclass(eq=False)
class _Now:
    """What is seen at the moment; only the loop of the server touches it.

    bordered : the view whose borders are drawn, whatever its colours show.
    """

    view: View
    shown: Picture | None = None
    at: At | None = None
    cell: Seen | None = None
    pins: dict[str, Seen] = field(default_factory=dict)
    bordered: View | None = None
    timings: dict[str, str] = field(default_factory=dict)


class Session:
    """A document with everything that happens in it."""

    def __init__(self, document: Document, subject: Subject) -> None:
        self._document, self._subject = document, subject
        self._now = _Now(first_view(subject))
        self.page = Page(subject)
        self.controls = Controls(
            subject, changed=self._changed, picked=self._picked, sided=self._sided, varied=self._varied,
            reset=self._reset,
        )  # fmt: skip
        self.below = Below(pin=self._pin, unpin=self._unpin, hear=self._hear, texts=self._text)
        self.page.map.plot.on_event(Tap, self._clicked)
        self._maps: Latest[View] = Latest(self._compute_map, "map")
        self._cells: Latest[tuple[View, At, Picture]] = Latest(self._compute_cell, "cell")
        self._sounds: Latest[tuple[str, Seen, float, bool]] = Latest(self._compute_sound, "sound")
        self.controls.show(self._now.view)
        with document.models.freeze():  # each root would have all models counted again
            for root in [self.controls.column, *self.page.roots, self.below.column]:
                document.add_root(root)
        document.template = template()
        document.template_variables.update(template_variables(subject, [str(root.name) for root in document.roots]))
        document.title = f"{subject.config.title} - stickslip"
        self._maps.ask(self._now.view)

    def close(self) -> None:
        """End the threads."""
        for worker in (self._maps, self._cells, self._sounds):
            worker.close()

    # --- what people do -----------------------------------------------------------------------------------------------

    def _changed(self, name: str, value: float) -> None:
        self._see(replace(self._now.view, values={**self._now.view.values, name: value}))

    def _picked(self, name: str, point: int) -> None:
        self._see(replace(self._now.view, points={**self._now.view.points, name: point}))

    def _varied(self, variable: str) -> None:
        self._see(replace(self._now.view, variable=variable))

    def _sided(self, y: str, x: str) -> None:
        self._forget_places()
        self._see(with_plane(self._subject, self._now.view, y, x))
        self.controls.show(self._now.view)

    def _reset(self) -> None:
        self._forget_places()
        self._see(replace(first_view(self._subject), variable=self._now.view.variable))
        self.controls.show(self._now.view)

    def _see(self, view: View) -> None:
        """Have a view drawn, and the cell that was clicked computed with its values."""
        self._now.view = view
        self._maps.ask(view)
        if self._now.at is not None and self._now.shown is not None:
            self._cells.ask((view, self._now.at, self._now.shown))

    def _forget_places(self) -> None:
        """Cells of other sides have no place on the map; pinned motions stay."""
        self._now.at = self._now.cell = None
        self._draw_borders([], None)
        self._show_cell()
        self.below.say_how(command="")

    def _clicked(self, event: Tap) -> None:
        shown = self._now.shown
        if shown is None or event.x is None or event.y is None:
            return
        inside = all(side.ends[0] <= place <= side.ends[1] for side, place in ((shown.x, event.x), (shown.y, event.y)))
        if inside:
            at = {
                shown.y.name: shown.y.at(shown.y.nearest(event.y)),
                shown.x.name: shown.x.at(shown.x.nearest(event.x)),
            }
            self._cells.ask((self._now.view, at, shown))

    def _pin(self, name: str) -> None:
        if self._now.cell is not None:
            self._now.pins[name] = self._now.cell
            self._now.pins = {key: self._now.pins[key] for key in sorted(self._now.pins)}
            self._show_cell()

    def _unpin(self) -> None:
        self._now.pins = {}
        self._show_cell()

    # --- work beside the loop -----------------------------------------------------------------------------------------

    def _compute_map(self, view: View, stop: StopFlag) -> None:
        """Coarse, then full, then its borders; each shown when it is there."""
        with self._telling(stop):
            if self._subject.computed is not None and is_as_opened(self._subject, view):
                began = perf_counter()
                dataset = maps.read(self._subject, view)
                shown: Picture | None = maps.picture(dataset, view)
                self._then(stop, self._show_map, view, shown, maps.variables(dataset), f"read in {_ms(began)}")
            else:
                small, full = config_of(self._subject, view, COARSE), config_of(self._subject, view, FULL)
                if _size(small) < _size(full):
                    self._show_computed(small, view, stop)
                    self._maps.pause(_BREATH)
                shown = self._show_computed(full, view, stop)
            if shown is not None:
                config, began = config_of(self._subject, view, FULL), perf_counter()
                lines = border_lines(config, shown, stop)
                if lines is not None:
                    said = f"exact borders in {_ms(began)}"
                    self._then(stop, self._show_borders, view, lines, said, config.to_yaml())

    def _show_computed(self, config: Config, view: View, stop: StopFlag) -> Picture | None:
        began = perf_counter()
        dataset = maps.computed(config, stop)
        if dataset is None:
            return None
        shown = maps.picture(dataset, view)
        said = f"{_size(config):,} cells in {_ms(began)}"
        self._then(stop, self._show_map, view, shown, maps.variables(dataset), said)
        return shown

    def _compute_cell(self, job: tuple[View, At, Picture], stop: StopFlag) -> None:
        view, at, shown = job
        with self._telling(stop):
            motions = motions_of(cell_of(cell_config(self._subject, view, at)), self._subject.options)
            said = place_words(shown, at)
            command = simulate_command(self._subject, view, at, motions)
            self._then(stop, self._show_seen, Seen(at, said, motions, command))

    def _compute_sound(self, job: tuple[str, Seen, float, bool], stop: StopFlag) -> None:
        name, seen, pace, loud = job
        with self._telling(stop):
            words_of = seen.words if name == "cell" else name
            self._then(stop, self.below.play, words_of, sound_of(seen.motions, pace, loud))

    @contextmanager
    def _telling(self, stop: StopFlag) -> Iterator[None]:
        """Whatever is raised inside is said on the page; what is a bug is logged as well."""
        try:
            yield
        except (ConfigError, NotReachedError, StoreError) as error:
            self._then(stop, self.show_error, str(error))
        except Exception as error:
            _LOG.exception("an error while computing")
            self._then(stop, self.show_error, f"{type(error).__name__}: {error}")

    def _then(self, stop: StopFlag, show: Callable[..., None], *given: Any) -> None:
        """Have the loop of the server show something, unless something newer was asked for by then."""

        def unless_overtaken() -> None:
            if not stop[0]:
                show(*given)

        self._document.add_next_tick_callback(unless_overtaken)

    # --- what is shown ------------------------------------------------------------------------------------------------

    def _show_map(self, view: View, shown: Picture, variables: list[tuple[str, str]], said: str) -> None:
        now = self._now
        if now.bordered is not None and now.bordered != _whatever_drawn(view):
            self._draw_borders([], None)  # with the cells they belong to, not when their successors are there
        now.shown = shown
        now.timings = {"map": said, "borders": _COMING}
        self.page.show_map(shown)
        self.controls.offer(variables)
        self._mark()
        self._say()

    def _draw_borders(self, lines: list[Line], view: View | None) -> None:
        self.page.map.draw_borders(lines)
        self._now.bordered = view

    def _show_borders(self, view: View, lines: list[Line], said: str, yaml: str) -> None:
        self._draw_borders(lines, _whatever_drawn(view))
        self._now.timings["borders"] = said
        self._say()
        self.below.say_how(yaml=yaml)

    def _show_seen(self, seen: Seen) -> None:
        self._now.at, self._now.cell = seen.at, seen
        self._show_cell()
        self.below.say_how(command=seen.command)

    def _show_cell(self) -> None:
        now = self._now
        pinned = {name: seen.motions for name, seen in now.pins.items()}
        said = "" if now.cell is None else cell_html(now.cell.motions, now.cell.words, now.cell.at)
        said += "".join(f"<br><b>{name}</b>: {escape(seen.words)}" for name, seen in now.pins.items())
        units = {} if now.shown is None else now.shown.units
        self.page.show_cell(None if now.cell is None else now.cell.motions, pinned, said, units)
        self._mark()

    def _mark(self) -> None:
        shown = self._now.shown
        if shown is None:
            return
        seen = {"cell": self._now.at} | {name: one.at for name, one in self._now.pins.items()}
        places = {}
        for name, at in seen.items():
            if at is not None and set(at) == {shown.x.name, shown.y.name}:
                places[name] = _place(shown, at)
        self.page.map.mark(places)

    def _say(self) -> None:
        self.page.status.text = f'<span class="note">{escape(" · ".join(self._now.timings.values()))}</span>'

    def show_error(self, text: str) -> None:
        """Say what went wrong where everybody looks."""
        self.page.status.text = f'<div class="error">{escape(text)}</div>'

    # --- what stands below --------------------------------------------------------------------------------------------

    def _hear(self, name: str) -> None:
        seen = self._now.cell if name == "cell" else self._now.pins.get(name)
        if seen is not None:
            self._sounds.ask((name, seen, self.below.pace, self.below.is_loud))

    def _text(self, name: str) -> str:
        """The content of a file to download; nothing where there is none yet."""
        if name == "view.yaml":
            return self.below.yaml
        shown = self._now.shown
        if name == "map.csv" and shown is not None and shown.cells["regime"].size > prod(FULL):
            file = shlex.quote(self._subject.source)
            self.show_error(f"the map is too large for a browser; this writes it: stickslip export {file} -o map.csv")
            return ""
        if name == "map.csv":
            return "" if shown is None else map_csv(shown)
        current = None if self._now.cell is None else self._now.cell.motions
        pinned = {name: seen.motions for name, seen in self._now.pins.items()}
        columns = columns_of(current, pinned)
        return motions_csv([(head, motion) for _, head, motion in columns]) if columns else ""


def _whatever_drawn(view: View) -> View:
    """What decides where the borders are: all but the variable."""
    return replace(view, variable="regime")


def _size(config: Config) -> int:
    return prod(axis.size for axis in config.axes)


def _ms(began: float) -> str:
    return f"{1e3 * (perf_counter() - began):.0f} ms"


def _place(shown: Picture, at: At) -> tuple[float, float]:
    """Where a cell lies in a picture."""
    x, y = (float(side.places(np.array([at[side.name]], np.float64))[0]) for side in (shown.x, shown.y))
    return x, y
