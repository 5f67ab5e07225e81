"""Materials compared, in words: the table of ranks, the decision, the remarks; for screen, workbook and page."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from stickslip.dataset.export import Sheet
from stickslip.dataset.materials import speeds_of
from stickslip.materials.system import VARIED, critical_damping
from stickslip.vocabulary import units
from stickslip.vocabulary.flags import QUIET_STATES, REGIMES, VIBRATING, flag_label
from stickslip.vocabulary.models import BREAKAWAY, CURVE
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.suggest import listed

_SYSTEM = ("mass", "stiffness", "damping", "normal_load")
_VARIED = {"damping": ("damping", "{} N s/m"), "normal_load": ("load", "{} N"),
           "friction_scale": ("scale of friction", "x {}")}  # fmt: skip
# V. Adams, A. Askenazi, Building Better Products with Finite Element Analysis (1999), viscous damping ratios.
_TYPICAL_DAMPING = (
    "Metal in one piece has below 1 % of critical, structures of metal have 2 to 4 %, with joints 3 to 7 %, rubber 5 %"
)
_WORTH_SAYING = 0.01  # share of the curves drawn
_CERTAIN = 0.975  # probability from which the order of two neighbours is
_HARDLY = 0.9  # of the width of an interval: what leaves more of it is hardly worth the work
_BOUNDS = {  # of materials whose number is a bound: the sign before it, and why
    "quiet_throughout": ("< ", "no vibration lasts at any speed searched"),
    "vibrates_throughout": ("> ", "vibrates up to the fastest speed searched"),
    "unresolved": ("<= ", "cells without a verdict lie around the border: the speed is an upper bound"),
}
_ANSWERS = {  # of one material, of several; in place of {} "probably " or "perhaps ", in place of * "throughout"
    "quiet": ("is {}quiet*", "are {}quiet*"),
    "partly": ("is quiet in a part of it", "are quiet in a part of it"),
    "vibrates": ("{}vibrates*", "{}vibrate*"),
    "window": ("is {}quiet, but vibrates at higher speeds", "are {}quiet, but vibrate at higher speeds"),
    "unknown": ("is not determined", "are not determined"),
}


class RankColumn(NamedTuple):
    """A column of the table: its heading, its unit, whether it holds words, and the cells, best material first."""

    name: str
    unit: str
    is_text: bool
    cells: tuple[str, ...]


class RankTable:
    """A comparison (`stickslip.compare`) in words. unit : of speeds; None takes that of the measured points."""

    def __init__(self, ds: xr.Dataset, unit: str | None = None) -> None:
        self.ds = ds
        self.names = [str(name) for name in ds["material"].values]
        self.unit = unit or str(ds["quiet_above"].attrs.get("display_units", "m/s"))
        self.factor = 1.0 / units.si_value(f"1 {self.unit}", "m s-1")
        self.level = f"{100 * float(ds.attrs['confidence']):g} %"
        self.speeds = speeds_of(ds)
        self.varied = [name for name in VARIED if f"quiet_above_over_{name}" in ds]
        self._is_range = "speed_range_from" in ds.attrs
        self._states = [QUIET_STATES[int(code)] for code in ds["quiet_state"].values]

    def speed(self, value: float) -> str:
        """A speed (m/s) as a number in the unit of the table."""
        number = self.factor * value
        return f"{number:.3g}" if number < 1000 else f"{number:.0f}"

    def bound(self, value: float) -> str:
        """A border, 0 and inf being beyond the speeds searched, in the unit of the table."""
        least, most = (float(self.ds.attrs[name]) for name in ("searched_from", "searched_to"))
        if math.isnan(value):
            return "-"
        sign, end = ("< ", least) if value == 0 else ("> ", most) if value > most else ("", value)
        return sign + self.speed(end)

    def _of(self, i: int, *names: str) -> list[float]:
        return [float(self.ds[name].values[i]) for name in names]

    # --- the table ----------------------------------------------------------------------------------------------------

    def columns(self) -> Iterator[RankColumn]:
        """The table of ranks."""
        ds, count = self.ds, range(len(self.names))
        ranks = ("-" if math.isnan(rank) else str(int(rank)) for rank in ds["rank"].values)
        yield RankColumn("rank", "", False, tuple(ranks))
        yield RankColumn("material", "", True, tuple(self.names))
        yield RankColumn("quiet above", self.unit, False, tuple(map(self._quiet, count)))
        if "quiet_above_low" in ds:
            yield RankColumn(f"{self.level} interval", self.unit, True, tuple(map(self._interval, count)))
        if "belt_speed" in ds.dims:
            for j, speed in enumerate(self.speeds):
                yield from self._at_speed(ds.isel(belt_speed=j), f" at {self.speed(speed)} {self.unit}")
        elif "regime" in ds:
            yield from self._at_speed(ds, "")
        for name in ("tendency", BREAKAWAY):
            if ds[name].ndim == 1:
                cells = ("-" if math.isnan(value) else f"{float(value):.3f}" for value in ds[name].values)
                yield RankColumn(name, "", False, tuple(cells))
        yield RankColumn("fit", "", True, tuple(map(self._fit, count)))

    def _at_speed(self, ds: xr.Dataset, which: str) -> Iterator[RankColumn]:
        """Columns of a belt speed, one of several (which) or the only one, or of a range."""
        ends = " to ".join(map(self.speed, self.speeds))
        name = which.strip() or f"{'worst from' if self._is_range else 'at'} {ends} {self.unit}"
        regimes = tuple(flag_label(REGIMES[int(code)]) if code else "-" for code in ds["regime"].values)
        yield RankColumn(name, "", True, regimes)
        if not which:
            unit = "slowest speed over border" if self._is_range else "speed over border"
            yield RankColumn("margin", unit, False, tuple(map(self._margin, range(len(regimes)))))
        if "quiet_probability" in ds:
            yield RankColumn(f"P(quiet){which}", "", False, tuple(map(_share, ds["quiet_probability"].values)))

    def _quiet(self, i: int) -> str:
        state = self._states[i]
        sign = _BOUNDS.get(state, ("", ""))[0]
        return "-" if state == "not_determined" else sign + self.speed(*self._of(i, "quiet_above"))

    def _interval(self, i: int) -> str:
        low, high = self._of(i, "quiet_above_low", "quiet_above_high")
        if math.isnan(low):
            return "not determined"
        return self.bound(low) if low == high or low == math.inf else f"{self.bound(low)} to {self.bound(high)}"

    def _margin(self, i: int) -> str:
        (value,) = self._of(i, "margin")
        if math.isnan(value):
            return "-"
        sign = {"vibrates_throughout": "< ", "unresolved": ">= "}.get(self._states[i], "")
        bound = self.speeds[0] / float(self.ds.attrs["searched_from"])  # nothing vibrates down to there
        return f"{sign}x {value:.3g}" if math.isfinite(value) else f"> x {bound:.3g}"

    def _fit(self, i: int) -> str:
        if self._states[i] == "not_determined":
            return "not determined"
        if self.ds["fit_good"].values[i]:
            is_open = self.ds[CURVE.slope].values[i] > 0 and self.ds[f"{CURVE.slope}_low"].values[i] == 0
            return f"{CURVE.slope} open" if is_open else "good"
        if self.ds[CURVE.drop].values[i] == 0:
            return "no fall"
        names = [name for name in CURVE if math.isinf(self.ds[f"{name}_high"].values[i])]
        return f"{listed(names, 'and')} open" if names else "doubtful"

    def sheet(self) -> Sheet:
        """The table of ranks as a sheet of a workbook, conditions and remarks below it."""
        rank, material, *others = self.columns()
        columns = [material, rank, *others]  # the material stays in sight
        heading = [f"{column.name}\n({column.unit})" if column.unit else column.name for column in columns]
        rows = [list(map(_number_or_word, row)) for row in zip(*(column.cells for column in columns), strict=True)]
        remarks = [[text] for text in (*self.remarks(), *self.method())]
        return Sheet("ranks", heading, rows, [[], ["Conditions:"], *self.conditions(), [], ["Remarks:"], *remarks])

    def conditions(self) -> list[tuple[str, str]]:
        """The system, in the units in which it was given."""
        attributes, rows = self.ds.attrs, []
        for name in _SYSTEM:
            row, value = PARAMETERS[name], float(attributes[f"system_{name}"])
            text = str(attributes.get(f"written_{name}", f"{value:.6g} {units.spelled(row.units)}"))
            if name == "damping" and "damping_in_percent" in attributes:
                text = f"{value:.4g} N s/m, {100.0 * value / critical_damping(self.ds):.3g} % of critical"
            text += " (assumed)" if name == "damping" and "damping_assumed" in attributes else ""
            if name in self.varied:
                text += f" ({'least' if name == 'damping' else 'largest'} of several: ranks are those there)"
            rows.append((row.long_name, text))
        if "friction_scale" in attributes:
            rows.append(("scale of friction", f"{float(attributes['friction_scale']):g}"))
        if self.speeds:
            speeds = (" to " if self._is_range else ", ").join(map(self.speed, self.speeds))
            rows.append(("belt speed", f"{speeds} {self.unit}"))
        return rows

    def variations(self) -> Iterator[tuple[str, list[RankColumn], list[str]]]:
        """Each quantity of the system that varies, the table of borders, and where the order of materials changes."""
        for name in self.varied:
            (called, form), values = _VARIED[name], self.ds[name].values
            borders = self.ds[f"quiet_above_over_{name}"].values
            heads = [form.format(f"{value:.3g}") for value in values]
            if name == "damping" and "damping_in_percent" in self.ds.attrs:
                heads = [f"{100.0 * value / critical_damping(self.ds):.3g} %" for value in values]
            columns = [RankColumn(called, "", True, tuple(self.names))]
            columns += [RankColumn(head, self.unit, False, tuple(map(self.bound, borders[:, j])))
                        for j, head in enumerate(heads)]  # fmt: skip
            changes = [
                f"{self.names[i]} and {self.names[k]} change places between {heads[j]} and {heads[j + 1]}."
                for i, k in combinations(range(len(borders)), 2)
                for j in range(values.size - 1)
                if _sign(borders[i, j], borders[k, j]) * _sign(borders[i, j + 1], borders[k, j + 1]) < 0
            ]
            known = bool(np.count_nonzero(np.isfinite(borders).any(axis=1)) > 1)
            yield (called, columns, changes or ["The order is the same at all of these."] * known)

    # --- the decision -------------------------------------------------------------------------------------------------

    def answer(self) -> str:
        """The decision: what is quiet at the belt speeds of the request, else from which speed on the best is."""
        shown = [*map(self.speed, self.speeds)]
        if "belt_speed" in self.ds.dims:
            each = (self.ds.isel(belt_speed=j) for j in range(len(shown)))
            return " ".join(
                self._answer_at(ds, f"At {speed} {self.unit}") for ds, speed in zip(each, shown, strict=True)
            )
        if shown:
            return self._answer_at(self.ds, f"{'From' if self._is_range else 'At'} {' to '.join(shown)} {self.unit}")
        if math.isnan(self.ds["rank"].values[0]):
            return f"The points do not tell where the vibration of {listed(self.names, 'and')} ends."
        if len(self.names) == 1:
            return f"The border of {self.names[0]}: quiet above {self._quiet(0)} {self.unit}."
        return f"{self.names[0]} is quiet from the lowest belt speed on."

    def _answer_at(self, ds: xr.Dataset, head: str) -> str:
        """A sentence on a belt speed, or a range: which materials are quiet, and which are not."""
        groups: dict[tuple[str, str], list[str]] = {}
        for i, name in enumerate(self.names):
            chance = float(ds["quiet_probability"].values[i]) if "quiet_probability" in ds else math.nan
            kind = self._kind(ds, i)
            certainty = 1.0 - chance if kind == "vibrates" else chance
            notes = [] if math.isnan(chance) else [f"P(quiet) {_share(chance)}"]
            if kind == "partly":
                notes = [f"above {self._quiet(i)} {self.unit}"]
            elif certainty < _CERTAIN:
                notes.append(f"P(vibrates) {_share(1.0 - chance - float(ds['undecided_probability'].values[i]))}")
            adverb = "perhaps " if certainty < 0.5 else "probably " if certainty < _CERTAIN else ""
            groups.setdefault((kind, adverb), []).append(f"{name} ({', '.join(notes)})" if notes else name)
        throughout = " throughout" if self._is_range else ""
        parts = [f"{listed(names, 'and')} {forms[len(names) > 1].replace('*', throughout).format(adverb)}"
                 for kind, forms in _ANSWERS.items()
                 for (other, adverb), names in groups.items() if other == kind]  # fmt: skip
        return f"{head} {'; '.join(parts)}."

    def _kind(self, ds: xr.Dataset, i: int) -> str:
        """The behaviour of a material at a belt speed, a key of `_ANSWERS`; a window is quiet there and not above."""
        state, regime, beyond = self._states[i], REGIMES[int(ds["regime"].values[i])], ds["margin"].values[i] > 1
        vibrates = regime in VIBRATING
        if state == "not_determined" or (state == "unresolved" and not vibrates and not beyond):
            return "unknown"
        if vibrates:
            return "partly" if self._is_range and ds["vibrating_share"].values[i] < 1 else "vibrates"
        return "quiet" if beyond and state != "vibrates_throughout" else "window"

    def method(self) -> list[str]:
        """The meaning of quiet and of the intervals."""
        ds = self.ds
        low, high = (self.speed(float(ds.attrs[name])) for name in ("searched_from", "searched_to"))
        sentences = [
            "Quiet: what begins in stick ends in steady sliding; neither stick-slip nor another vibration lasts. Belt "
            f"speeds from {low} to {high} {self.unit} were searched; a vibration that begins and ends between two of "
            f"{int(ds.attrs['searched_points'])} places there is missed."
        ]
        if "quiet_above_low" not in ds:
            return sentences
        text = (
            f"The {self.level} intervals are quantiles of {int(ds.attrs['draws']):,} curves a material, drawn "
            "from what its fit leaves open: the scatter of the points, not of specimens, temperature or the system."
        )
        if bool((ds["rank"].notnull() & (ds["draws_used"] == 0)).any()):
            text += " Where too few points are to spare, or follow another curve, there is none."
        if "repeats" in ds:
            rows = zip(self.names, ds["repeats"].values, ds["repeat_names"].values, strict=True)
            repeated = [f"{name} ({str(names).replace('; ', ', ')})" for name, count, names in rows if count > 1]
            which = f"Of {listed(repeated, 'and')}, measured repeatedly,"
            text += f" {which} they hold what differs between the repeats as well."
        return [*sentences, text]

    # --- remarks ------------------------------------------------------------------------------------------------------

    def remarks(self) -> list[str]:
        """Sentences on what the table does not show by itself."""
        texts = [
            f"{listed(names, 'and')}: {reason}."
            for state, (_, reason) in _BOUNDS.items()
            if (names := [name for name, own in zip(self.names, self._states, strict=True) if own == state])
        ]
        if self.ds.attrs["system_damping"] == 0:
            texts += [
                f"{name}: nothing takes energy out at high speed: the curve never rises and the damping is 0. Give the "
                "damping of the system, or measure at higher speed."
                for name, state, slope in zip(self.names, self._states, self.ds[CURVE.slope].values, strict=True)
                if state == "vibrates_throughout" and slope == 0
            ]
        texts += self.limits()
        if {"normal_load", "friction_scale"} & {*self.varied, *self.ds.attrs}:
            texts.append(
                "Only friction times load counts: twice the load moves a border as twice the friction coefficient at "
                "every speed does."
            )
        return [*texts, *self._measurements()]

    def limits(self) -> list[str]:
        """Sentences on what keeps the table from being certain."""
        ds = self.ds

        def shares(variable: str) -> Iterator[tuple[str, float]]:
            values = ds[variable].values.reshape(len(self.names), -1).max(axis=1) if variable in ds else ()
            return zip(self.names, values, strict=False)

        texts = [f"{name}: {_share(share)} of the curves drawn have no verdict at the belt speed (step limit); they "
                 "are not in P(quiet), and need not vibrate."
                 for name, share in shares("undecided_probability") if share > 0]  # fmt: skip
        if "damping_assumed" in ds.attrs:
            texts.append(
                "Damping 0 N s/m was assumed for all materials; a damper lowers the borders: give --damping, in N s/m "
                f'or in percent of critical damping ("3 %"). {_TYPICAL_DAMPING}.'
            )
        columns = (ds[name].values for name in ("fit_good", "fit_quality", "rank"))
        texts += [f"{name}: {'not determined, and not ranked. ' if math.isnan(rank) else ''}{quality}"
                  for name, good, quality, rank in zip(self.names, *columns, strict=True)
                  if not good or math.isnan(rank)]  # fmt: skip
        texts += [*self._extrapolated(), *self._order()]
        texts += [f"{name}: {_share(share)} of the curves that the points allow fall for ever ({CURVE.slope} < 0), and "
                  "vibrate at any speed where no damper outweighs this. Measure at higher speed."
                  for name, share in shares("draws_falling") if share >= _WORTH_SAYING]  # fmt: skip
        return texts

    def _extrapolated(self) -> Iterator[str]:
        """A belt speed and borders outside of what was measured."""

        def beyond(speed: float, slow: float, fast: float) -> str:
            side, end = ("slowest", slow) if speed < slow else ("fastest", fast)
            return f"lies beyond the {side}, {self.speed(end)} {self.unit}, that was measured"

        ends = float(self.ds["slowest_point"].min()), float(self.ds["fastest_point"].max())
        for speed in self.speeds:
            if not ends[0] <= speed <= ends[1]:
                yield (
                    f"The belt speed, {self.speed(speed)} {self.unit}, {beyond(speed, *ends)} of any material: what is "
                    "told there follows from the fitted curves alone."
                )
        for i, name in enumerate(self.names):
            border, slow, fast = self._of(i, "quiet_above", "slowest_point", "fastest_point")
            if self._states[i] == "border" and not slow <= border <= fast:
                yield f"{name}: the border {beyond(border, slow, fast)}."

    def _order(self) -> Iterator[str]:
        chances = self.ds["better_than_next"].values[:-1] if "better_than_next" in self.ds else ()
        for i, chance in enumerate(chances):
            if not chance >= _CERTAIN and "not_determined" not in self._states[i : i + 2]:
                known = "cannot be told" if math.isnan(chance) else f"has a probability of {_share(chance)}"
                yield f"That {self.names[i]} is quiet from a lower speed on than {self.names[i + 1]} {known}."

    def _measurements(self) -> Iterator[str]:
        """The points to measure next: which would narrow the interval of each material most, and to what."""
        hardly, order = [], self._least_certain() if "next_speed_1" in self.ds else []
        for i in order:
            first, second, slowest = self._of(i, "next_speed_1", "next_speed_2", "slowest_point")
            ends = self._of(i, "quiet_above_low", "quiet_above_high", "next_low", "next_high")
            low, high, least, most = ends
            repeats = int(self.ds["repeats"].values[i]) if "repeats" in self.ds else 1
            which = " (the least certain)" if i == order[0] and len(order) > 1 else ""
            if math.isnan(first) and math.isnan(least):
                if which:
                    yield f"{self.names[i]}{which}: too few of the curves drawn have a border to tell what to measure."
                continue
            if most - least > _HARDLY * (high - low) and i != order[0]:
                hardly.append(f"{self.names[i]}: two more points would hardly narrow the interval.")
                continue
            places = [*map(self.speed, (first, second))]
            place = f"twice at {places[0]}" if places[0] == places[1] else f"at {' and '.join(places)}"
            action = (
                f"measure {place} {self.unit}" if repeats < 2 else f"measure another specimen, number {repeats + 1}"
            )
            action += " (slower than any point, since no fall was seen)" if first < slowest else ""
            shrunk = "the interval would shrink from {}..{} to about {}..{}".format(*map(self.bound, ends))
            effect = "its ends would stay open" if math.isnan(least) else shrunk
            yield f"{self.names[i]}{which}: {action}: {effect}."
        yield from hardly

    def _least_certain(self) -> list[int]:
        """Materials with an interval, the least certain first: by what the verdict at the belt speeds leaves open, then
        by the ratio of its ends."""
        low, high = self.ds["quiet_above_low"].values, self.ds["quiet_above_high"].values
        chance = np.ones((low.size, 1))
        if "quiet_probability" in self.ds:
            chance = self.ds["quiet_probability"].values.reshape(low.size, -1)
        doubt = np.round(np.minimum(chance, 1.0 - chance).max(axis=1), 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.nan_to_num(np.where(high > 0, high / low, 1.0), nan=1.0)
        return sorted(np.flatnonzero(~np.isnan(low)).tolist(), key=lambda i: (-doubt[i], -ratio[i]))


def _sign(one: float, other: float) -> int:
    return int(one > other) - int(one < other)


def _share(value: Any) -> str:
    if math.isnan(value):
        return "not known"
    return "> 99.9 %" if value > 0.999 else "< 0.1 %" if value < 0.001 else f"{100 * float(value):.3g} %"


def _number_or_word(cell: str) -> str | float:
    """A cell of a sheet: a number as one, so that it can be sorted."""
    try:
        return float(cell.removeprefix("x "))  # a margin
    except ValueError:
        return cell
