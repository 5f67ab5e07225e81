"""The widgets beside the map (sides, variable, sliders) and below it (sound, what reproduces it)."""

import base64
from collections.abc import Callable
from functools import partial
from math import isnan
from typing import Any

from bokeh import models

from stickslip import extensions
from stickslip.vocabulary.display_units import spoken
from stickslip.vocabulary.parameter import NAN
from stickslip_explore.html import part
from stickslip_explore.page import WIDGETS, Page, calling, words
from stickslip_explore.view import SliderRange, Source, View, is_listed, labels_of, sides, sliders_of

_STEPS = 400  # of a slider
_ROUNDING = 1e-6  # of a step: what the browser makes of zero, adding up steps
_PACES = (
    ("0.01", "100 times faster (slow 0.01)"),
    ("0.1", "10 times faster (slow 0.1)"),
    ("1", "true pitch"),
    ("10", "10 times slower (slow 10)"),
    ("100", "100 times slower (slow 100)"),
)
_SECONDS = 2.0
_WIDE: dict[str, Any] = {"sizing_mode": "stretch_width", "stylesheets": [WIDGETS]}


class Controls:
    """The widgets beside the map, which are made anew where its sides change.

    Calls `changed` with a quantity and its value in SI (NaN: absent), `picked` with a listed axis and the text of a
    position, `sided` with both sides, `varied` with a variable, `reset`.
    """

    def __init__(
        self, source: Source, *, changed: Callable[[str, float], None], picked: Callable[[str, str], None],
        sided: Callable[[str, str], None], varied: Callable[[str], None], reset: Callable[[], None],
    ) -> None:  # fmt: skip
        self._source, self._changed, self._picked, self._sided = source, changed, picked, sided
        self.column = models.Column(name="controls", sizing_mode="stretch_width", spacing=2)
        self.variable = _select("colours show", [("regime", "regime of motion")], "regime", "variable", varied)
        self._reset = models.Button(label="Reset to the file", name="reset", **_WIDE)
        self._reset.on_click(reset)

    def show(self, view: View) -> None:
        """Make the widgets of a view."""
        source = self._source
        offered = [(name, spoken(name)) for name in sides(source)]
        y = _select("up", offered, view.y, "side_y", lambda new: self._sided(new, view.x))
        x = _select("to the right", offered, view.x, "side_x", lambda new: self._sided(view.y, new))
        pickers = [
            _select(spoken(name), [(str(i), label) for i, label in enumerate(labels_of(source, axis))],
                    str(view.points.get(name, 0)), f"pick_{name}", partial(self._picked, name))
            for name, axis in source.axes.items() if is_listed(axis) and name not in view.plane
        ]  # fmt: skip
        ranges = list(sliders_of(source, view.plane))
        common = [self._slider(limits, view) for limits in ranges if not limits.rare]
        rare = models.Column(children=[self._slider(limits, view) for limits in ranges if limits.rare], visible=False,
                      sizing_mode="stretch_width", spacing=2)  # fmt: skip
        more = models.Checkbox(label="ageing and start", name="more", stylesheets=[WIDGETS])
        more.on_change("active", lambda _a, _o, new: setattr(rare, "visible", new))
        beside = models.Row(children=[x, y], sizing_mode="stretch_width", spacing=6)
        self.column.children = [self.variable, beside, *pickers, *common, more, rare, self._reset]

    def _slider(self, limits: SliderRange, view: View) -> models.UIElement:
        """The slider of a quantity, with a box that switches it on where it may be absent."""
        name, label = limits.name, spoken(limits.name)
        value = view.values.get(name, limits.start)
        slider = _slider(limits, label, limits.otherwise if isnan(value) else value)
        if not limits.may_be_absent:
            slider.on_change("value", lambda _a, _o, new: self._changed(name, _si(limits, new)))
            return slider
        switch = models.Checkbox(active=not isnan(value), name=f"on_{name}", width=22, stylesheets=[WIDGETS])

        def show_switch() -> None:
            slider.disabled, slider.title = not switch.active, label if switch.active else f"{label} (off)"

        def switched(_attribute: str, _old: object, _new: object) -> None:
            show_switch()
            self._changed(name, _si(limits, float(slider.value)) if switch.active else NAN)

        show_switch()
        switch.on_change("active", switched)
        slider.on_change("value", lambda a, o, n: switched(a, o, n) if switch.active else None)
        return models.Row(children=[switch, slider], sizing_mode="stretch_width", spacing=0)


def _slider(limits: SliderRange, label: str, value: float) -> models.Slider:
    low, high, at = map(limits.place, (limits.low, limits.high, value))
    step = (high - low) / _STEPS
    words = models.CustomJSTickFormatter(
        code="return stickslip.place_label(tick, log, unit, least)",
        args={"log": limits.is_log, "unit": limits.unit.name, "least": _ROUNDING * step},  # what is less is zero
    )
    return models.Slider(start=low, end=high, value=min(max(at, low), high), step=step, title=label,
                  name=f"slider_{limits.name}", format=words, **_WIDE)  # fmt: skip


def _si(limits: SliderRange, place: float) -> float:
    span = limits.place(limits.high) - limits.place(limits.low)
    if not limits.is_log and abs(place) < _ROUNDING * span / _STEPS:
        return 0.0
    return limits.value(float(place))


def _select(title: str, options: Any, value: str, name: str, chosen: Callable[[str], None]) -> models.Select:
    select = models.Select(title=title, options=options, value=value, name=name, **_WIDE)
    select.on_change("value", lambda _attribute, _old, new: chosen(new))
    return select


# --- below the map ----------------------------------------------------------------------------------------------------


class Actions:
    """The widgets, and the places for words, below the map. Calls `hear`."""

    def __init__(self, page: Page, hear: Callable[[], None]) -> None:
        self._page = page
        self._wave = models.ColumnDataSource({"wav": []}, name="sound")
        self._wave.js_on_change("data", calling("play", wave=self._wave))
        self._pace = models.Select(options=list(_PACES), value="1", name="pace", width=200, stylesheets=[WIDGETS])
        self._heard = words("heard")
        self._heard.visible = False
        button = models.Button(label="▶ Hear the cell", name="hear", stylesheets=[WIDGETS])
        button.on_click(hear)
        copies = _row(self._copying("Copy the command", "command"), self._copying("Copy the YAML", "yaml"))
        sounds = [_row(button, self._pace), self._heard] if "sound" in extensions.brought("calls") else []
        rows = [*sounds, copies, page.reproduce]
        self.column = models.Column(children=rows, name="below", sizing_mode="stretch_width")
        self.column.tags = [self._wave]  # what no widget shows is a part of the document all the same

    @property
    def pace(self) -> float:
        """Factor by which sounds are slower than motions."""
        return float(self._pace.value)

    def play(self, name: str, heard: Any) -> None:
        """Have the browser play a sound, and say what to know of it."""
        self._wave.data = {"wav": [base64.b64encode(heard.wav()).decode("ascii")]}
        self._heard.visible = True
        self._heard.text = part("sound", name, heard.described())

    def _copying(self, label: str, which: str) -> models.Button:
        button = models.Button(label=label, name=f"copy_{which}", stylesheets=[WIDGETS])
        button.js_on_click(calling("copy", texts=self._page.texts, which=which, button=button, label=label))
        return button


def _row(*widgets: Any) -> models.Row:
    """Widgets side by side, in as many lines as they take."""
    return models.Row(children=list(widgets), styles={"flex-wrap": "wrap"}, spacing=4, sizing_mode="stretch_width")
