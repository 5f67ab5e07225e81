"""Materials compared, in words: the table of ranks, the decision, the remarks; for screen, workbook and page."""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import combinations, pairwise
from types import SimpleNamespace
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
from stickslip.vocabulary.results import MATERIAL_VARIABLES
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
        several = [ds.isel(belt_speed=j) for j in range(ds.sizes.get("belt_speed", 0))]
        self._at = [_rows(at) for at in several or [ds]]  # materials at each belt speed
        self._rows = self._at[0]

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

    # --- the table ----------------------------------------------------------------------------------------------------

    def columns(self) -> Iterator[RankColumn]:
        """The table of ranks."""
        yield self._column("rank", "", lambda row: _number(row.rank, 0))
        yield self._column("material", None, lambda row: row.name)
        yield self._column("quiet above", self.unit, self._quiet)
        if "quiet_above_low" in self.ds:
            yield self._column(f"{self.level} interval", self.unit, self._interval)._replace(is_text=True)
        places = [f" at {self.speed(speed)} {self.unit}" for speed in self.speeds] if len(self._at) > 1 else [""]
        for rows, place in zip(self._at, places, strict=True) if self.speeds else ():
            ends = f"{' to '.join(map(self.speed, self.speeds))} {self.unit}"
            yield self._column(
                place.strip() or f"{'worst from' if self._is_range else 'at'} {ends}", None, _regime, rows
            )
            if not place:
                unit = "slowest speed over border" if self._is_range else "speed over border"
                yield self._column("margin", unit, self._margin)
            if "quiet_probability" in self.ds:
                yield self._column(f"P(quiet){place}", "", lambda row: _share(row.quiet_probability), rows)
        if len(self._at) == 1:
            yield self._column("tendency", "", lambda row: _number(row.tendency, 3))
        yield self._column(BREAKAWAY, "", lambda row: _number(getattr(row, BREAKAWAY), 3))
        yield self._column("fit", None, _fit)

    def _column(self, name: str, unit: str | None, cell: Callable[[Any], str], rows: Any = None) -> RankColumn:
        """A column of the table. unit : None for words. rows : the materials; those at the first belt speed if None."""
        return RankColumn(name, unit or "", unit is None, tuple(map(cell, rows or self._rows)))

    def _quiet(self, row: Any) -> str:
        sign = _BOUNDS.get(row.state, ("", ""))[0]
        return "-" if row.state == "not_determined" else sign + self.speed(row.quiet_above)

    def _interval(self, row: Any) -> str:
        low, high = row.quiet_above_low, row.quiet_above_high
        if math.isnan(low):
            return "not determined"
        return self.bound(low) if low == high or low == math.inf else f"{self.bound(low)} to {self.bound(high)}"

    def _margin(self, row: Any) -> str:
        if math.isnan(row.margin):
            return "-"
        sign = {"vibrates_throughout": "< ", "unresolved": ">= "}.get(row.state, "")
        bound = self.speeds[0] / float(self.ds.attrs["searched_from"])  # nothing vibrates down to there
        return f"{sign}x {row.margin:.3g}" if math.isfinite(row.margin) else f"> x {bound:.3g}"

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
        shown = [f"{self.speed(speed)} {self.unit}" for speed in self.speeds]
        if self._is_range:
            return self._answer_at(self._rows, f"From {' to '.join(map(self.speed, self.speeds))} {self.unit}")
        if shown:
            return " ".join(self._answer_at(rows, f"At {at}") for rows, at in zip(self._at, shown, strict=True))
        if math.isnan(self._rows[0].rank):
            return f"The points do not tell where the vibration of {listed(self.names, 'and')} ends."
        if len(self.names) == 1:
            return f"The border of {self.names[0]}: quiet above {self._quiet(self._rows[0])} {self.unit}."
        return f"{self.names[0]} is quiet from the lowest belt speed on."

    def _answer_at(self, rows: Sequence[Any], head: str) -> str:
        """A sentence on a belt speed, or a range: which materials are quiet, and which are not."""
        groups: dict[tuple[str, str], list[str]] = {}
        for row in rows:
            chance, kind = row.quiet_probability, self._kind(row)
            certainty = 1.0 - chance if kind == "vibrates" else chance
            notes = [] if math.isnan(chance) else [f"P(quiet) {_share(chance)}"]
            if kind == "partly":
                notes = [f"above {self._quiet(row)} {self.unit}"]
            elif certainty < _CERTAIN:
                notes.append(f"P(vibrates) {_share(1.0 - chance - row.undecided_probability)}")
            adverb = "perhaps " if certainty < 0.5 else "probably " if certainty < _CERTAIN else ""
            groups.setdefault((kind, adverb), []).append(f"{row.name} ({', '.join(notes)})" if notes else row.name)
        throughout = " throughout" if self._is_range else ""
        parts = [f"{listed(names, 'and')} {forms[len(names) > 1].replace('*', throughout).format(adverb)}"
                 for kind, forms in _ANSWERS.items()
                 for (other, adverb), names in groups.items() if other == kind]  # fmt: skip
        return f"{head} {'; '.join(parts)}."

    def _kind(self, row: Any) -> str:
        """The behaviour of a material at a belt speed, a key of `_ANSWERS`; a window is quiet there and not above."""
        vibrates, beyond = REGIMES[int(row.regime)] in VIBRATING, row.margin > 1
        if row.state == "not_determined" or (row.state == "unresolved" and not vibrates and not beyond):
            return "unknown"
        if vibrates:
            return "partly" if self._is_range and row.vibrating_share < 1 else "vibrates"
        return "quiet" if beyond and row.state != "vibrates_throughout" else "window"

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
            if (names := [row.name for row in self._rows if row.state == state])
        ]
        texts += [
            f"{row.name}: nothing takes energy out at high speed: the curve never rises and the damping is 0. Give the "
            "damping of the system, or measure at higher speed."
            for row in self._rows if self.ds.attrs["system_damping"] == 0
            and row.state == "vibrates_throughout" and getattr(row, CURVE.slope) == 0
        ]  # fmt: skip
        texts += self.limits()
        if {"normal_load", "friction_scale"} & {*self.varied, *self.ds.attrs}:
            texts.append(
                "Only friction times load counts: twice the load moves a border as twice the friction coefficient at "
                "every speed does."
            )
        return [*texts, *self.measurements()]

    def limits(self) -> list[str]:
        """Sentences on what keeps the table from being certain."""
        undecided = [
            (rows[0].name, max(row.undecided_probability for row in rows)) for rows in zip(*self._at, strict=True)
        ]
        texts = [f"{name}: {_share(share)} of the curves drawn have no verdict at the belt speed (step limit); they "
                 "are not in P(quiet), and need not vibrate."
                 for name, share in undecided if share > 0]  # fmt: skip
        if "damping_assumed" in self.ds.attrs:
            texts.append(
                "Damping 0 N s/m was assumed for all materials; a damper lowers the borders: give --damping, in N s/m "
                f'or in percent of critical damping ("3 %"). {_TYPICAL_DAMPING}.'
            )
        texts += [f"{row.name}: {'not determined, and not ranked. ' if math.isnan(row.rank) else ''}{row.fit_quality}"
                  for row in self._rows if not row.fit_good or math.isnan(row.rank)]  # fmt: skip
        texts += [*self._extrapolated(), *self._order()]
        texts += [f"{row.name}: {_share(row.draws_falling)} of the curves that the points allow fall for ever "
                  f"({CURVE.slope} < 0), and vibrate at any speed where no damper outweighs this. Measure at higher "
                  "speed."
                  for row in self._rows if row.draws_falling >= _WORTH_SAYING]  # fmt: skip
        return texts

    def _extrapolated(self) -> Iterator[str]:
        """A belt speed and borders outside of what was measured."""

        def beyond(speed: float, slow: float, fast: float) -> str:
            side, end = ("slowest", slow) if speed < slow else ("fastest", fast)
            return f"lies beyond the {side}, {self.speed(end)} {self.unit}, that was measured"

        ends = min(row.slowest_point for row in self._rows), max(row.fastest_point for row in self._rows)
        for speed in self.speeds:
            if not ends[0] <= speed <= ends[1]:
                yield (
                    f"The belt speed, {self.speed(speed)} {self.unit}, {beyond(speed, *ends)} of any material: what is "
                    "told there follows from the fitted curves alone."
                )
        for row in self._rows:
            if row.state == "border" and not row.slowest_point <= row.quiet_above <= row.fastest_point:
                yield f"{row.name}: the border {beyond(row.quiet_above, row.slowest_point, row.fastest_point)}."

    def _order(self) -> Iterator[str]:
        for row, following in pairwise(self._rows if "better_than_next" in self.ds else ()):
            chance = row.better_than_next
            if not chance >= _CERTAIN and "not_determined" not in (row.state, following.state):
                known = "cannot be told" if math.isnan(chance) else f"has a probability of {_share(chance)}"
                yield f"That {row.name} is quiet from a lower speed on than {following.name} {known}."

    def measurements(self) -> Iterator[str]:
        """The points to measure next: which would narrow the interval of each material most, and to what."""
        hardly, order = [], self._least_certain() if "next_speed_1" in self.ds else []
        for row in order:
            which = " (the least certain)" if row is order[0] and len(order) > 1 else ""
            if math.isnan(row.next_speed_1) and math.isnan(row.next_low):
                if which:
                    yield f"{row.name}{which}: too few of the curves drawn have a border to tell what to measure."
                continue
            width = row.quiet_above_high - row.quiet_above_low
            if row.next_high - row.next_low > _HARDLY * width and row is not order[0]:
                hardly.append(f"{row.name}: two more points would hardly narrow the interval.")
                continue
            first, second = map(self.speed, (row.next_speed_1, row.next_speed_2))
            action = f"measure {f'twice at {first}' if first == second else f'at {first} and {second}'} {self.unit}"
            if row.repeats > 1:
                action = f"measure another specimen, number {int(row.repeats) + 1}"
            action += " (slower than any point, since no fall was seen)" if row.next_speed_1 < row.slowest_point else ""
            ends = map(self.bound, (row.quiet_above_low, row.quiet_above_high, row.next_low, row.next_high))
            shrunk = "the interval would shrink from {}..{} to about {}..{}".format(*ends)
            effect = "its ends would stay open" if math.isnan(row.next_low) else shrunk
            yield f"{row.name}{which}: {action}: {effect}."
        yield from hardly

    def _least_certain(self) -> list[Any]:
        """Materials with an interval: by what verdicts at the belt speeds leave open, then by the ratio of its ends."""

        def certainty(rows: Sequence[Any]) -> tuple[float, float]:
            low, high = rows[0].quiet_above_low, rows[0].quiet_above_high
            chances = [row.quiet_probability for row in rows]
            doubt = 0.0 if any(map(math.isnan, chances)) else max(min(chance, 1.0 - chance) for chance in chances)
            ratio = 1.0 if not high > 0 else math.inf if low == 0 else 1.0 if math.isinf(low) else high / low
            return -round(doubt, 2), -ratio

        known = [rows for rows in zip(*self._at, strict=True) if not math.isnan(rows[0].quiet_above_low)]
        return [rows[0] for rows in sorted(known, key=certainty)]


def _rows(ds: xr.Dataset) -> list[Any]:
    """Materials, each with its numbers and words by name, NaN for those that the comparison lacks, and its state."""
    count = ds.sizes["material"]
    columns: dict[str, list[Any]] = {**dict.fromkeys(MATERIAL_VARIABLES, [math.nan] * count), "repeats": [1] * count}
    columns |= {str(name): v.values.tolist() for name, v in ds.variables.items() if v.dims == ("material",)}
    columns |= {"name": columns["material"], "state": [QUIET_STATES[code] for code in columns["quiet_state"]]}
    return [SimpleNamespace(**dict(zip(columns, row, strict=True))) for row in zip(*columns.values(), strict=True)]


def _regime(row: Any) -> str:
    return flag_label(REGIMES[row.regime]) if row.regime else "-"


def _fit(row: Any) -> str:
    if row.state == "not_determined":
        return "not determined"
    if row.fit_good:
        is_open = getattr(row, CURVE.slope) > 0 and getattr(row, f"{CURVE.slope}_low") == 0
        return f"{CURVE.slope} open" if is_open else "good"
    if getattr(row, CURVE.drop) == 0:
        return "no fall"
    names = [name for name in CURVE if math.isinf(getattr(row, f"{name}_high"))]
    return f"{listed(names, 'and')} open" if names else "doubtful"


def _number(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


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
