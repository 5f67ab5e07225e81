"""One tab of the browser: its events, the work they ask for beside the loop of the server, and what comes of it."""

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import prod
from time import perf_counter
from typing import Any, Generic, TypeVar

import xarray as xr
from bokeh.document import Document
from bokeh.events import Tap

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


class Session:
    """A document with everything that happens in it; only the loop of the server touches what it remembers.

    view : what is seen, or will be once it is computed. yaml and figures are in `page`.
    """

    def __init__(self, document: Document, source: Source) -> None:
        self._document, self._source, self.view = document, source, first_view(source)
        self._shown: MapPicture | None = None
        self._cell: SelectedCell | None = None
        self._pins: dict[str, SelectedCell] = {}
        self._bordered: View | None = None  # whose borders are drawn, whatever its colours show
        self._timings: dict[str, str] = {}
        self.page = Page(source)
        self.controls = Controls(
            source,
            sided=lambda y, x: self._see_other_sides(with_plane(self.view, y, x)),
            reset=lambda: self._see_other_sides(replace(first_view(source), variable=self.view.variable)),
            changed=lambda name, value: self._see(values={**self.view.values, name: value}),
            picked=lambda name, point: self._see(points={**self.view.points, name: int(point)}),
            varied=lambda variable: self._see(variable=variable),
        )  # fmt: skip
        self.actions = Actions(self.page, pin=self._pin, unpin=self._unpin, hear=self._hear)
        self.page.map.plot.on_event(Tap, self._clicked)
        self._maps: LatestOnly[View] = LatestOnly(self._compute_map, "map")
        self._cells: LatestOnly[tuple[View, At, MapPicture]] = LatestOnly(self._compute_cell, "cell")
        self._sounds: LatestOnly[tuple[str, SelectedCell, float]] = LatestOnly(self._compute_sound, "sound")
        self.controls.show(self.view)
        self.page.fill(document, [self.controls.column, *self.page.roots, self.actions.column], source.notes)
        self._maps.ask(self.view)

    def close(self) -> None:
        """End the threads."""
        for worker in (self._maps, self._cells, self._sounds):
            worker.close()

    # --- what people do -----------------------------------------------------------------------------------------------

    def _see(self, **changed: Any) -> None:
        """Have the view drawn that is so changed, and the cell that was clicked computed with its values."""
        self.view = replace(self.view, **changed)
        self._maps.ask(self.view)
        if self._cell is not None and self._shown is not None:
            self._cells.ask((self.view, self._cell.at, self._shown))

    def _see_other_sides(self, view: View) -> None:
        """Have a view drawn on whose map the cells that were seen have no place; pinned motions stay."""
        self._cell = None
        self._draw_borders([], None)
        self._show_cell()
        self.page.show_texts(command="")
        self._see(**vars(view))
        self.controls.show(view)

    def _clicked(self, event: Tap) -> None:
        shown = self._shown
        if shown is None or event.x is None or event.y is None:
            return
        places = ((shown.y, event.y), (shown.x, event.x))
        if all(side.ends[0] <= place <= side.ends[1] for side, place in places):
            at = {side.name: side.at(side.nearest(place)) for side, place in places}
            self._cells.ask((self.view, at, shown))

    def _pin(self, name: str) -> None:
        if self._cell is not None:
            self._pins = dict(sorted({**self._pins, name: self._cell}.items()))
            self._show_cell()

    def _unpin(self) -> None:
        self._pins = {}
        self._show_cell()

    def _hear(self, name: str) -> None:
        cell = self._cell if name == "cell" else self._pins.get(name)
        if cell is not None:
            self._sounds.ask((name, cell, self.actions.pace))

    # --- work beside the loop -----------------------------------------------------------------------------------------

    def _compute_map(self, view: View, stop: StopFlag) -> None:
        """Coarse, then full, then its borders; each shown when it is there."""
        with self._reporting_errors(stop):
            shown, began = None, perf_counter()
            for what, dataset in self._datasets(view, stop):
                if dataset is None:
                    return
                shown = maps.picture(dataset, view)
                text = f"{what} in {_ms(began)}"
                self._schedule(stop, self._show_map, view, shown, maps.variables(dataset), text)
                began = perf_counter()
            config = config_of(self._source, view, FULL)
            lines = border_lines(config, shown, stop) if shown else None
            if lines is not None:
                self._schedule(
                    stop, self._show_borders, view, lines, f"exact borders in {_ms(began)}", config.to_yaml()
                )

    def _datasets(self, view: View, stop: StopFlag) -> Iterator[tuple[str, xr.Dataset | None]]:
        """The map of a view, in one step or two, with how many cells were computed; None if the flag was raised."""
        source = self._source
        if source.computed is not None and not view.values and {*view.plane} <= {*source.axes}:
            yield "read", maps.read(source, view)
            return
        steps = {prod(axis.size for axis in config.axes): config
                 for config in (config_of(source, view, most) for most in (COARSE, FULL))}  # fmt: skip
        for size, config in steps.items():
            yield f"{size:,} cells", maps.computed(config, stop)

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
        if self._bordered is not None and self._bordered != replace(view, variable="regime"):
            self._draw_borders([], None)  # with the cells they belong to, not when their successors are there
        self._shown, self._timings = shown, {"map": text, "borders": _COMING}
        self.page.show_map(shown)
        self.controls.variable.options = variables
        self._mark()
        self._show_timings()

    def _draw_borders(self, lines: list[Line], view: View | None) -> None:
        self.page.map.draw_borders(lines)
        self._bordered = view and replace(view, variable="regime")  # colours have no part in where borders are

    def _show_borders(self, view: View, lines: list[Line], text: str, yaml: str) -> None:
        self._draw_borders(lines, view)
        self._timings["borders"] = text
        self._show_timings()
        self.page.show_texts(yaml=yaml)

    def _show_selected(self, cell: SelectedCell) -> None:
        self._cell = cell
        self._show_cell()
        self.page.show_texts(command=cell.command)

    def _show_cell(self) -> None:
        cell, pins = self._cell, {name: cell.motions for name, cell in self._pins.items()}
        text = "" if cell is None else cell_html(cell.motions, cell.words, cell.at)
        text += part("pins", [(name, cell.words) for name, cell in self._pins.items()])
        units = {} if self._shown is None else self._shown.units
        self.page.show_cell(None if cell is None else cell.motions, pins, text, units)
        self._mark()

    def _mark(self) -> None:
        if (shown := self._shown) is None:
            return
        cells = ({} if self._cell is None else {"cell": self._cell}) | self._pins
        self.page.map.mark({
            name: (shown.x.place(cell.at[shown.x.name]), shown.y.place(cell.at[shown.y.name]))
            for name, cell in cells.items() if set(cell.at) == {shown.x.name, shown.y.name}
        })  # fmt: skip

    def _show_timings(self) -> None:
        self.page.status.text = part("note", " · ".join(self._timings.values()))

    def show_error(self, text: str) -> None:
        """Say what went wrong where everybody looks."""
        self.page.status.text = part("error", text)


def _ms(began: float) -> str:
    return f"{1e3 * (perf_counter() - began):.0f} ms"
