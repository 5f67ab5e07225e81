"""The server of the page: on this machine alone, and for nobody who does not know its token."""

import asyncio
import secrets
import socket
from collections.abc import Callable
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.settings import settings
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop

from stickslip_explore.session import Session
from stickslip_explore.source import Source

HOST = "127.0.0.1"
_TOKEN_BYTES = 24
_UNUSED = 15_000  # ms after which a tab that was closed is forgotten, unless it comes back


class Explorer:
    """A server that holds its port once it is made, and answers while `run` runs.

    Everything it has, the scripts and the websocket included, lies under a path that nobody can guess: all other paths
    are not found. It listens on 127.0.0.1, and takes websockets from its own pages only.

    source : what every tab shows, each by itself. port : 0 for any that is free. token : of the path; None for a new
    one. Raises OSError for a port that is not free.
    """

    def __init__(self, source: Source, port: int = 0, token: str | None = None) -> None:
        self._source = source
        self._socket = socket.create_server((HOST, port), backlog=128)
        self._socket.setblocking(False)
        self.port = int(self._socket.getsockname()[1])
        self.token = token or secrets.token_urlsafe(_TOKEN_BYTES)
        self._sessions: list[Session] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stopping: asyncio.Event | None = None

    @property
    def address(self) -> str:
        """The address of the page, token included."""
        return f"http://{HOST}:{self.port}/{self.token}/"

    def run(self, started: Callable[[], None] | None = None) -> None:
        """Answer until `stop`, or Ctrl-C, which ends all and comes out as KeyboardInterrupt.

        started : called once the page is there.
        """
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
