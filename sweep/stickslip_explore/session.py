"""One tab of the browser: its events, the work they ask for beside the loop of the server, and what comes of it."""

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from math import prod
from time import perf_counter
from typing import Any, Generic, TypeVar

import xarray as xr
from bokeh.document import Document
from bokeh.events import Tap

from stickslip.config.model import Config
from stickslip.engine import StopFlag, stop_flag
from stickslip.errors import ConfigError, NotReachedError, StoreError
from stickslip_explore import maps
from stickslip_explore.controls import Actions, Controls, sound_of
from stickslip_explore.html import cell_html, part, place_words, simulate_command
from stickslip_explore.maps import Line, MapPicture, border_lines
from stickslip_explore.motions import CellMotions, motions_of
from stickslip_explore.page import Page
from stickslip_explore.source import Source
from stickslip_explore.view import COARSE, FULL, At, View, cell_of_view, config_of, first_view, with_plane

Job = TypeVar("Job")


class LatestOnly(Generic[Job]):
    """A thread that works on the job asked for last.

    work : called with a job and a stop flag, which is raised once another job waits or all is closed; errors are its
    own business. A job that is overtaken before it began is never begun.
    """

    def __init__(self, work: Callable[[Job, StopFlag], None], name: str) -> None:
        self._work, self._thread = work, ThreadPoolExecutor(1, name)
        self._last, self._stop = Future[None](), stop_flag()

    def ask(self, job: Job) -> None:
        """Have this done, and nothing else any more."""
        self._last.cancel()
        self._stop[0], self._stop = 1, stop_flag()
        self._last = self._thread.submit(self._work, job, self._stop)

    def close(self) -> None:
        """End the thread, which leaves within milliseconds."""
        self._stop[0] = 1
        self._thread.shutdown(cancel_futures=True)


_LOG = logging.getLogger(__name__)
_COMING = "exact borders ..."


@dataclass(frozen=True, eq=False)
class SelectedCell:
    """A cell that was computed: where it lies, in words too, what it does, and the line that reproduces it."""

    at: At
    words: str
    motions: CellMotions
    command: str


@dataclass(eq=False)
class State:
    """The view, the cells and the pins of a tab; only the loop of the server touches it.

    bordered : the view whose borders are drawn, whatever its colours show.
    """

    view: View
    shown: MapPicture | None = None
    at: At | None = None
    cell: SelectedCell | None = None
    pins: dict[str, SelectedCell] = field(default_factory=dict)
    bordered: View | None = None
    timings: dict[str, str] = field(default_factory=dict)

    @property
    def motions(self) -> tuple[CellMotions | None, dict[str, CellMotions]]:
        """Those of the cell that was clicked, and of the pinned ones."""
        current = None if self.cell is None else self.cell.motions
        return current, {name: cell.motions for name, cell in self.pins.items()}


class Session:
    """A document with everything that happens in it."""

    def __init__(self, document: Document, source: Source) -> None:
        self._document, self._source = document, source
        self._state = State(first_view(source))
        self.page = Page(source)
        self.controls = Controls(
            source,
            sided=lambda y, x: self._see_other_sides(with_plane(self._state.view, y, x)),
            reset=lambda: self._see_other_sides(replace(first_view(source), variable=self._state.view.variable)),
            changed=lambda name, value: self._see(values={**self._state.view.values, name: value}),
            picked=lambda name, point: self._see(points={**self._state.view.points, name: int(point)}),
            varied=lambda variable: self._see(variable=variable),
        )  # fmt: skip
        self.actions = Actions(self.page, pin=self._pin, unpin=self._unpin, hear=self._hear)
        self.page.map.plot.on_event(Tap, self._clicked)
        self._maps: LatestOnly[View] = LatestOnly(self._compute_map, "map")
        self._cells: LatestOnly[tuple[View, At, MapPicture]] = LatestOnly(self._compute_cell, "cell")
        self._sounds: LatestOnly[tuple[str, SelectedCell, float]] = LatestOnly(self._compute_sound, "sound")
        self.controls.show(self._state.view)
        self.page.fill(document, [self.controls.column, *self.page.roots, self.actions.column], source.notes)
        self._maps.ask(self._state.view)

    def close(self) -> None:
        """End the threads."""
        for worker in (self._maps, self._cells, self._sounds):
            worker.close()

    # --- what people do -----------------------------------------------------------------------------------------------

    def _see(self, **changed: Any) -> None:
        """Have the view drawn that is so changed, and the cell that was clicked computed with its values."""
        state = self._state
        state.view = replace(state.view, **changed)
        self._maps.ask(state.view)
        if state.at is not None and state.shown is not None:
            self._cells.ask((state.view, state.at, state.shown))

    def _see_other_sides(self, view: View) -> None:
        """Have a view drawn on whose map the cells that were seen have no place; pinned motions stay."""
        self._state.at = self._state.cell = None
        self._draw_borders([], None)
        self._show_cell()
        self.page.show_texts(command="")
        self._see(**vars(view))
        self.controls.show(view)

    def _clicked(self, event: Tap) -> None:
        shown = self._state.shown
        if shown is None or event.x is None or event.y is None:
            return
        places = ((shown.y, event.y), (shown.x, event.x))
        if all(side.ends[0] <= place <= side.ends[1] for side, place in places):
            at = {side.name: side.at(side.nearest(place)) for side, place in places}
            self._cells.ask((self._state.view, at, shown))

    def _pin(self, name: str) -> None:
        if self._state.cell is not None:
            self._state.pins = dict(sorted({**self._state.pins, name: self._state.cell}.items()))
            self._show_cell()

    def _unpin(self) -> None:
        self._state.pins = {}
        self._show_cell()

    def _hear(self, name: str) -> None:
        cell = self._state.cell if name == "cell" else self._state.pins.get(name)
        if cell is not None:
            self._sounds.ask((name, cell, self.actions.pace))

    # --- work beside the loop -----------------------------------------------------------------------------------------

    def _compute_map(self, view: View, stop: StopFlag) -> None:
        """Coarse, then full, then its borders; each shown when it is there."""
        with self._reporting_errors(stop):
            as_opened = not view.values and {*view.plane} <= {*self._source.axes}
            if self._source.computed is not None and as_opened:
                shown = self._show_dataset(view, stop, lambda: maps.read(self._source, view), "read")
            else:
                small, full = config_of(self._source, view, COARSE), config_of(self._source, view, FULL)
                if _size(small) < _size(full):
                    self._show_dataset(view, stop, lambda: maps.computed(small, stop), f"{_size(small):,} cells")
                shown = self._show_dataset(view, stop, lambda: maps.computed(full, stop), f"{_size(full):,} cells")
            if shown is not None:
                config, began = config_of(self._source, view, FULL), perf_counter()
                lines = border_lines(config, shown, stop)
                if lines is not None:
                    text = f"exact borders in {_ms(began)}"
                    self._schedule(stop, self._show_borders, view, lines, text, config.to_yaml())

    def _show_dataset(
        self, view: View, stop: StopFlag, dataset_of: Callable[[], xr.Dataset | None], what: str
    ) -> MapPicture | None:  # fmt: skip
        """The picture of a dataset once it is there, which is shown; None if the flag was raised on the way."""
        began = perf_counter()
        dataset = dataset_of()
        if dataset is None:
            return None
        shown = maps.picture(dataset, view)
        self._schedule(stop, self._show_map, view, shown, maps.variables(dataset), f"{what} in {_ms(began)}")
        return shown

    def _compute_cell(self, job: tuple[View, At, MapPicture], stop: StopFlag) -> None:
        view, at, shown = job
        with self._reporting_errors(stop):
            motions = motions_of(cell_of_view(self._source, view, at), self._source.options)
            command = simulate_command(self._source, view, at, motions)
            self._schedule(stop, self._show_selected, SelectedCell(at, place_words(shown, at), motions, command))

    def _compute_sound(self, job: tuple[str, SelectedCell, float], stop: StopFlag) -> None:
        name, cell, pace = job
        with self._reporting_errors(stop):
            heading = cell.words if name == "cell" else name
            self._schedule(stop, self.actions.play, heading, sound_of(cell.motions, pace))

    @contextmanager
    def _reporting_errors(self, stop: StopFlag) -> Iterator[None]:
        """Whatever is raised inside is said on the page; what is a bug is logged as well."""
        try:
            yield
        except (ConfigError, NotReachedError, StoreError) as error:
            self._schedule(stop, self.show_error, str(error))
        except Exception as error:
            _LOG.exception("an error while computing")
            self._schedule(stop, self.show_error, f"{type(error).__name__}: {error}")

    def _schedule(self, stop: StopFlag, show: Callable[..., None], *given: Any) -> None:
        """Have the loop of the server show something, unless something newer was asked for by then."""

        def unless_overtaken() -> None:
            if not stop[0]:
                show(*given)

        self._document.add_next_tick_callback(unless_overtaken)

    # --- what is shown ------------------------------------------------------------------------------------------------

    def _show_map(self, view: View, shown: MapPicture, variables: list[tuple[str, str]], text: str) -> None:
        state = self._state
        if state.bordered is not None and state.bordered != replace(view, variable="regime"):
            self._draw_borders([], None)  # with the cells they belong to, not when their successors are there
        state.shown, state.timings = shown, {"map": text, "borders": _COMING}
        self.page.show_map(shown)
        self.controls.variable.options = variables
        self._mark()
        self._show_timings()

    def _draw_borders(self, lines: list[Line], view: View | None) -> None:
        self.page.map.draw_borders(lines)
        self._state.bordered = view and replace(view, variable="regime")  # colours have no part in where borders are

    def _show_borders(self, view: View, lines: list[Line], text: str, yaml: str) -> None:
        self._draw_borders(lines, view)
        self._state.timings["borders"] = text
        self._show_timings()
        self.page.show_texts(yaml=yaml)

    def _show_selected(self, cell: SelectedCell) -> None:
        self._state.at, self._state.cell = cell.at, cell
        self._show_cell()
        self.page.show_texts(command=cell.command)

    def _show_cell(self) -> None:
        state = self._state
        text = "" if state.cell is None else cell_html(state.cell.motions, state.cell.words, state.cell.at)
        text += part("pins", [(name, cell.words) for name, cell in state.pins.items()])
        self.page.show_cell(*state.motions, text, {} if state.shown is None else state.shown.units)
        self._mark()

    def _mark(self) -> None:
        shown = self._state.shown
        if shown is None:
            return
        cells = {"cell": self._state.at} | {name: cell.at for name, cell in self._state.pins.items()}
        on_map = {name: at for name, at in cells.items() if at is not None and set(at) == {shown.x.name, shown.y.name}}
        self.page.map.mark({
            name: (shown.x.place(at[shown.x.name]), shown.y.place(at[shown.y.name])) for name, at in on_map.items()
        })  # fmt: skip

    def _show_timings(self) -> None:
        self.page.status.text = part("note", " · ".join(self._state.timings.values()))

    def show_error(self, text: str) -> None:
        """Say what went wrong where everybody looks."""
        self.page.status.text = part("error", text)


def _size(config: Config) -> int:
    return prod(axis.size for axis in config.axes)


def _ms(began: float) -> str:
    return f"{1e3 * (perf_counter() - began):.0f} ms"
