"""The server of the page, on this machine alone, for nobody who does not know its token; and its tabs: their events,
the work they ask for beside the loop of the server, and what comes of it."""

import asyncio
import logging
import secrets
import socket
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import prod
from time import perf_counter
from typing import Any, Generic, TypeVar

import xarray as xr
from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.events import Tap
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.settings import settings
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop

from stickslip import extensions
from stickslip.engine import StopFlag, stop_flag
from stickslip.errors import ConfigError, NotReachedError, StoreError
from stickslip_explore import maps
from stickslip_explore.controls import Actions, Controls
from stickslip_explore.html import cell_html, part, place_words, simulate_command
from stickslip_explore.maps import MapPicture
from stickslip_explore.motions import CellMotions, motions_of
from stickslip_explore.page import Page
from stickslip_explore.view import COARSE, FULL, At, Source, View, cell_of_view, config_of, first_view, with_plane

Job = TypeVar("Job")


class LatestOnly(Generic[Job]):
    """A thread that works on the job asked for last; one that is overtaken before it began is never begun.

    work : called with a job and a stop flag, which is raised once another job waits or all is closed.
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
HOST = "127.0.0.1"
_UNUSED = 15_000  # ms after which a tab that was closed is forgotten, unless it comes back


@dataclass(frozen=True, eq=False)
class SelectedCell:
    """A cell that was computed: where it lies, in words too, what it does, and the line that reproduces it."""

    at: At
    words: str
    motions: CellMotions
    command: str


class Session:
    """A document with everything that happens in it; only the loop of the server touches what it remembers.

    view : what is seen, or will be once it is computed.
    """

    def __init__(self, document: Document, source: Source) -> None:
        self._document, self._source, self.view = document, source, first_view(source)
        self._shown: MapPicture | None = None
        self._cell: SelectedCell | None = None
        self.page = Page(source)
        self.controls = Controls(
            source,
            sided=lambda y, x: self._see_other_sides(with_plane(self.view, y, x)),
            reset=lambda: self._see_other_sides(replace(first_view(source), variable=self.view.variable)),
            changed=lambda name, value: self._see(values={**self.view.values, name: value}),
            picked=lambda name, point: self._see(points={**self.view.points, name: int(point)}),
            varied=lambda variable: self._see(variable=variable),
        )  # fmt: skip
        self.actions = Actions(self.page, self._hear)
        self.page.map.plot.on_event(Tap, self._clicked)
        self._maps: LatestOnly[View] = LatestOnly(self._compute_map, "map")
        self._cells: LatestOnly[tuple[View, At, MapPicture]] = LatestOnly(self._compute_cell, "cell")
        self._sounds: LatestOnly[tuple[SelectedCell, float]] = LatestOnly(self._compute_sound, "sound")
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
        """Have a view drawn on whose map the cell that was seen has no place."""
        self._cell = None
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

    def _hear(self) -> None:
        if self._cell is not None:
            self._sounds.ask((self._cell, self.actions.pace))

    # --- work beside the loop -----------------------------------------------------------------------------------------

    def _compute_map(self, view: View, stop: StopFlag) -> None:
        """Coarse, then full; each shown when it is there."""
        with self._reporting_errors(stop):
            began = perf_counter()
            for what, dataset in self._datasets(view, stop):
                if dataset is None:
                    return
                text = f"{what} in {1e3 * (perf_counter() - began):.0f} ms"
                shown = maps.picture(dataset, view)
                self._schedule(stop, self._show_map, shown, maps.variables(dataset), text)
                began = perf_counter()
            yaml = config_of(self._source, view, FULL).to_yaml()
            self._schedule(stop, lambda: self.page.show_texts(yaml=yaml))

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

    def _compute_sound(self, job: tuple[SelectedCell, float], stop: StopFlag) -> None:
        cell, pace = job
        with self._reporting_errors(stop):
            sound = extensions.call("sound", "stickslip").of(cell.motions.cell, law=cell.motions.law, slow=pace)
            self._schedule(stop, self.actions.play, cell.words, sound)

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

    def _show_map(self, shown: MapPicture, variables: list[tuple[str, str]], text: str) -> None:
        self._shown = shown
        self.page.show_map(shown)
        self.controls.variable.options = variables
        self._mark()
        self.page.status.text = part("note", text)

    def _show_selected(self, cell: SelectedCell) -> None:
        self._cell = cell
        self._show_cell()
        self.page.show_texts(command=cell.command)

    def _show_cell(self) -> None:
        cell, units = self._cell, {} if self._shown is None else self._shown.units
        text = "" if cell is None else cell_html(cell.motions, cell.words, cell.at)
        self.page.show_cell(None if cell is None else cell.motions, text, units)
        self._mark()

    def _mark(self) -> None:
        shown, cell = self._shown, self._cell
        if shown is not None:
            has_place = cell is not None and set(cell.at) == {shown.x.name, shown.y.name}
            self.page.map.mark.data = {
                which: [float(side.place(cell.at[side.name]))] if cell is not None and has_place else []
                for which, side in (("x", shown.x), ("y", shown.y))
            }

    def show_error(self, text: str) -> None:
        """Say what went wrong where everybody looks."""
        self.page.status.text = part("error", text)


class Explorer:
    """A server that holds its port once it is made (0: any that is free), and answers while `run` runs.

    Everything it has, the scripts and the websocket included, lies under a path that nobody can guess: all other paths
    are not found. It listens on 127.0.0.1, and takes websockets from its own pages only. Raises OSError for a port that
    is not free.
    """

    def __init__(self, source: Source, port: int = 0) -> None:
        self._source = source
        self._socket = socket.create_server((HOST, port), backlog=128)
        self._socket.setblocking(False)
        self.port = int(self._socket.getsockname()[1])
        self.token = secrets.token_urlsafe(24)
        self._sessions: list[Session] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stopping: asyncio.Event | None = None

    @property
    def address(self) -> str:
        """The address of the page, token included."""
        return f"http://{HOST}:{self.port}/{self.token}/"

    def run(self, started: Callable[[], None] | None = None) -> None:
        """Answer until `stop`, or Ctrl-C, which comes out as KeyboardInterrupt. started : called once it answers."""
        asyncio.run(self._serve(started))

    def close(self) -> None:
        """Give the port back, where `run` was never called."""
        self._socket.close()

    def stop(self) -> None:
        """End `run`; from any thread."""
        if self._loop is not None and self._stopping is not None:
            self._loop.call_soon_threadsafe(self._stopping.set)

    async def _serve(self, started: Callable[[], None] | None) -> None:
        self._loop, self._stopping = asyncio.get_running_loop(), asyncio.Event()
        settings.resources = "server"  # whatever the environment says: the page works without a network
        settings.allowed_ws_origin = []  # only the page's own
        pages = BokehTornado(
            {"/": Application(FunctionHandler(self._open_tab))}, prefix=self.token, ico_path="none",
            extra_websocket_origins=[f"{HOST}:{self.port}"], absolute_url=f"http://{HOST}:{self.port}",
            unused_session_lifetime_milliseconds=_UNUSED,
        )  # fmt: skip
        http = HTTPServer(pages)
        http.add_socket(self._socket)
        server = BaseServer(IOLoop.current(), pages, http)
        server.start()
        try:
            if started is not None:
                started()
            await self._stopping.wait()
        finally:
            for session in self._sessions:
                session.close()
            http.stop()
            server.stop()
            await http.close_all_connections()

    def _open_tab(self, document: Document) -> None:
        session = Session(document, self._source)
        self._sessions.append(session)

        def forget(_context: Any) -> None:
            session.close()
            self._sessions.remove(session)

        document.on_session_destroyed(forget)
