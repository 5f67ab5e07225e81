"""What stands below the map: pins, sound, files, and what reproduces what is seen."""

from __future__ import annotations

import base64
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from html import escape
from typing import Any

from bokeh.models import Button, Checkbox, Column, ColumnDataSource, CustomJS, Row, Select

from stickslip import sound
from stickslip.explore import scripts
from stickslip.explore.motions import CellMotions
from stickslip.explore.page import WIDGETS, button, words

_PACES = (
    ("0.01", "100 times faster (slow 0.01)"),
    ("0.1", "10 times faster (slow 0.1)"),
    ("1", "true pitch"),
    ("10", "10 times slower (slow 10)"),
    ("100", "100 times slower (slow 100)"),
)
_SECONDS = 2.0
_LOUDEST = 0.9  # of full scale, where a sound is made as loud as may be


class Below:
    """The widgets, and the places for words, below the map.

    Calls `pin` with "A" or "B", `unpin`, `hear` with "cell", "A" or "B"; `texts` gives the content of a file by name.
    """

    def __init__(
        self, *, pin: Callable[[str], None], unpin: Callable[[], None], hear: Callable[[str], None],
        texts: Callable[[str], str],
    ) -> None:  # fmt: skip
        self._texts, self._said = texts, {"command": "", "yaml": ""}
        self._kept = ColumnDataSource({}, name="texts")
        self._outbox = ColumnDataSource({"name": [], "text": []}, name="outbox")
        self._outbox.js_on_change("data", CustomJS(args={"box": self._outbox}, code=scripts.DOWNLOAD))
        self._wave = ColumnDataSource({"wav": []}, name="sound")
        self._wave.js_on_change("data", CustomJS(args={"wave": self._wave}, code=scripts.PLAY))
        self._pace = Select(options=list(_PACES), value="1", name="pace", width=200, stylesheets=[WIDGETS])
        self._loud = Checkbox(label="as loud as may be", name="loud", stylesheets=[WIDGETS], margin=(10, 5, 5, 5))
        self._heard, self._reproduce = words("heard"), words("reproduce")
        self._heard.visible = False
        pins = [self._calling(f"Pin as {name}", f"pin_{name}", partial(pin, name)) for name in ("A", "B")]
        heard = [
            self._calling(f"▶ {label}", f"hear_{name}", partial(hear, name))
            for label, name in (("Hear the cell", "cell"), ("A", "A"), ("B", "B"))
        ]
        files = [
            self._calling(label, f"file_{name}", partial(self._send, name))
            for label, name in (("Map as CSV", "map.csv"), ("Motions as CSV", "motions.csv"), ("YAML", "view.yaml"))
        ]
        copies = [self._copying("Copy the command", "command"), self._copying("Copy the YAML", "yaml")]
        rows = [
            _row(*pins, self._calling("Unpin", "unpin", unpin)),
            _row(*heard, self._pace, self._loud),
            self._heard, _row(*files, *copies), self._reproduce,
        ]  # fmt: skip
        self.column = Column(children=rows, name="below", sizing_mode="stretch_width")
        self.column.tags = [self._outbox, self._wave]  # what no widget shows is a part of the document all the same

    @property
    def pace(self) -> float:
        """How many times slower sounds are than motions."""
        return float(self._pace.value)

    @property
    def is_loud(self) -> bool:
        """Whether each sound is as loud as may be; else all are of one scale."""
        return bool(self._loud.active)

    def say_how(self, **texts: str) -> None:
        """Show the command or the YAML that reproduces what is seen."""
        self._said |= texts
        self._kept.tags = [dict(self._said)]
        command = f"<pre>{escape(self._said['command'])}</pre>" if self._said["command"] else ""
        yaml = f"<details><summary>the map as YAML</summary><pre>{escape(self._said['yaml'])}</pre></details>"
        self._reproduce.text = command + yaml

    @property
    def yaml(self) -> str:
        """The YAML that is shown."""
        return self._said["yaml"]

    def play(self, name: str, heard: sound.Sound) -> None:
        """Have the browser play a sound, and say what to know of it."""
        self._wave.data = {"wav": [base64.b64encode(heard.wav()).decode("ascii")]}
        said = [f"<b>{escape(name)}</b>: {escape(heard.told())}", *map(escape, heard.remarks())]
        self._heard.visible = True
        self._heard.text = f'<span class="note">{"<br>".join(said)}</span>'

    def _send(self, name: str) -> None:
        if text := self._texts(name):
            self._outbox.data = {"name": [name], "text": [text]}

    def _calling(self, label: str, name: str, call: Callable[[], None]) -> Button:
        found = button(label, name)
        found.on_click(call)
        return found

    def _copying(self, label: str, which: str) -> Button:
        found = button(label, f"copy_{which}")
        given = {"texts": self._kept, "which": which, "button": found, "label": label}
        found.js_on_click(CustomJS(args=given, code=scripts.COPY))
        return found


def sound_of(motions: CellMotions, pace: float, loud: bool) -> sound.Sound:
    """The sound of a cell, from its start. Raises NotReachedError."""
    heard = sound.of(motions.cell, _SECONDS, law=motions.law, slow=pace)
    if loud and heard.peak > 0.0:
        return replace(heard, full_scale=heard.peak / _LOUDEST)
    return heard


def _row(*widgets: Any) -> Row:
    """Widgets side by side, in as many lines as they take."""
    return Row(children=list(widgets), styles={"flex-wrap": "wrap"}, spacing=4, sizing_mode="stretch_width")
