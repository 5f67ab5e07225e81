"""The widgets beside the map: its sides, its variable, and a slider for every other quantity."""

from __future__ import annotations

from collections.abc import Callable
from math import isnan
from typing import Any

from bokeh.models import Button, Checkbox, Column, Row, Select, Slider, UIElement

from stickslip.dataset.axis import spoken
from stickslip.explore.axes import words_of
from stickslip.explore.knobs import Knob, is_listed, knobs_of, picker_of
from stickslip.explore.page import WIDGETS
from stickslip.explore.subject import Subject
from stickslip.explore.view import View, sides, start_value
from stickslip.vocabulary.parameter import NAN

_STEPS = 400  # of a slider
_ROUNDING = 1e-6  # of a step: what the browser makes of zero, adding up steps

Changed = Callable[[str, float], None]
Picked = Callable[[str, int], None]
Sided = Callable[[str, str], None]


class Controls:
    """The widgets, which are made anew where the sides of the map change.

    Calls `changed` with a quantity and its value in SI (NaN: absent), `picked` with a listed axis and a position,
    `sided` with both sides, `varied` with a variable, `reset` with nothing.
    """

    def __init__(
        self, subject: Subject, *, changed: Changed, picked: Picked, sided: Sided, varied: Callable[[str], None],
        reset: Callable[[], None],
    ) -> None:  # fmt: skip
        self._subject, self._changed, self._picked, self._sided = subject, changed, picked, sided
        self.column = Column(name="controls", sizing_mode="stretch_width", spacing=2)
        self.variable = _select("colours show", [("regime", "regime of motion")], "regime", "variable")
        self.variable.on_change("value", lambda _a, _o, new: varied(new))
        self._reset = Button(
            label="Reset to the file", name="reset", sizing_mode="stretch_width", stylesheets=[WIDGETS]
        )
        self._reset.on_click(reset)

    def show(self, view: View) -> None:
        """Make the widgets of a view."""
        subject = self._subject
        offered = [(name, spoken(name)) for name in sides(subject)]
        y = _select("up", offered, view.y, "side_y")
        x = _select("to the right", offered, view.x, "side_x")
        y.on_change("value", lambda _a, _o, new: self._sided(new, view.x))
        x.on_change("value", lambda _a, _o, new: self._sided(view.y, new))
        pickers: list[UIElement] = [
            self._picker(name, view)
            for name, axis in subject.axes.items()
            if is_listed(axis) and name not in view.plane
        ]
        knobs = list(knobs_of(subject, view.plane))
        common = [self._knob(knob, view) for knob in knobs if not knob.rare]
        rare = Column(children=[self._knob(knob, view) for knob in knobs if knob.rare], visible=False,
                      sizing_mode="stretch_width", spacing=2)  # fmt: skip
        more = Checkbox(label="ageing and start", name="more", stylesheets=[WIDGETS])
        more.on_change("active", lambda _a, _o, new: setattr(rare, "visible", new))
        beside = Row(children=[x, y], sizing_mode="stretch_width", spacing=6)
        self.column.children = [self.variable, beside, *pickers, *common, more, rare, self._reset]

    def offer(self, variables: list[tuple[str, str]]) -> None:
        """The variables that can be drawn."""
        if variables != self.variable.options:
            self.variable.options = variables

    def _picker(self, name: str, view: View) -> Select:
        axis: Any = self._subject.axes[name]
        labels = picker_of(axis).labels
        options = [(str(i), label) for i, label in enumerate(labels)]
        select = _select(spoken(name), options, str(view.points.get(name, 0)), f"pick_{name}")
        select.on_change("value", lambda _a, _o, new: self._picked(name, int(new)))
        return select

    def _knob(self, knob: Knob, view: View) -> UIElement:
        """The slider of a quantity, with a box that switches it on where it may be absent."""
        value = view.values.get(knob.name, start_value(self._subject, view, knob.name))
        slider = _slider(knob, knob.otherwise if isnan(value) else value)
        if not knob.may_be_absent:
            slider.on_change("value", lambda _a, _o, new: self._changed(knob.name, _si(knob, new)))
            return slider
        slider.disabled, slider.title = isnan(value), _title(knob, not isnan(value))
        switch = Checkbox(active=not isnan(value), name=f"on_{knob.name}", width=22, stylesheets=[WIDGETS])

        def tell(_attribute: str, _old: object, _new: object) -> None:
            slider.disabled, slider.title = not switch.active, _title(knob, switch.active)
            self._changed(knob.name, _si(knob, float(slider.value)) if switch.active else NAN)

        switch.on_change("active", tell)
        slider.on_change("value", lambda a, o, n: tell(a, o, n) if switch.active else None)
        return Row(children=[switch, slider], sizing_mode="stretch_width", spacing=0)


def _title(knob: Knob, on: bool) -> str:
    return spoken(knob.name) if on else f"{spoken(knob.name)} (off)"


def _slider(knob: Knob, value: float) -> Slider:
    """A slider over the places of a quantity in its unit."""
    unit = knob.unit
    low, high, at = (knob.place(one / unit.factor) for one in (knob.low, knob.high, value))
    step = (high - low) / _STEPS
    return Slider(
        start=low, end=high, value=min(max(at, low), high), step=step, title=spoken(knob.name),
        format=words_of(knob.is_log, unit.name, _ROUNDING * step), name=f"knob_{knob.name}",
        sizing_mode="stretch_width", stylesheets=[WIDGETS],
    )  # fmt: skip


def _si(knob: Knob, place: float) -> float:
    """The value of a place on the slider."""
    span = (knob.high - knob.low) / knob.unit.factor
    if not knob.is_log and abs(place) < _ROUNDING * span / _STEPS:
        return 0.0
    return knob.value(float(place)) * knob.unit.factor


def _select(title: str, options: list[tuple[str, str]], value: str, name: str) -> Select:
    return Select(title=title, options=options, value=value, name=name, sizing_mode="stretch_width",
                  stylesheets=[WIDGETS])  # fmt: skip
