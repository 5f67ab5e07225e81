"""Materials compared, in words: the table of ranks and the remarks below it, for the screen and for pages."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import xarray as xr

from stickslip.dataset.export import Sheet
from stickslip.dataset.materials import speeds_of
from stickslip.materials.next_measurements import measurements
from stickslip.materials.system import VARIED, critical_damping
from stickslip.vocabulary import units
from stickslip.vocabulary.flags import QUIET_STATES, REGIMES, VIBRATING, flag_label
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.suggest import listed

_SYSTEM = ("mass", "stiffness", "damping", "normal_load")
# V. Adams, A. Askenazi, Building Better Products with Finite Element Analysis (1999), viscous damping ratios.
_TYPICAL_DAMPING = (
    "Metal in one piece has below 1 % of critical, structures of metal have 2 to 4 %, with joints 3 to 7 %, rubber 5 %"
)
_WORTH_SAYING = 0.01  # share of the curves drawn
_CERTAIN = 0.975  # probability from which the order of two neighbours is


@dataclass(frozen=True)
class Shown:
    """A column of the table: its heading, its unit, whether it holds words, and the cells, best material first."""

    name: str
    unit: str
    is_text: bool
    cells: tuple[str, ...]


class Words:
    """What is said of a comparison (`stickslip.compare`). unit : of speeds; None takes that of the measured points."""

    def __init__(self, ds: xr.Dataset, unit: str | None = None) -> None:
        self.ds = ds
        self.unit = unit or str(ds["quiet_above"].attrs.get("display_units", "m/s"))
        self.factor = 1.0 / units.si_value(f"1 {self.unit}", "m s-1")
        self.level = f"{100 * float(ds.attrs['confidence']):g} %"
        self.speeds = speeds_of(ds)
        self.varied = [name for name in VARIED if f"quiet_above_over_{name}" in ds]
        self._is_range = "speed_range_from" in ds.attrs

    @property
    def names(self) -> list[str]:
        """The materials, best first."""
        return [str(name) for name in self.ds["material"].values]

    def speed(self, value: float) -> str:
        """A speed (m/s) as a number in the unit of the table."""
        number = self.factor * value
        return f"{number:.3g}" if number < 1000 else f"{number:.0f}"

    def bound(self, value: float) -> str:
        """A border, 0 and inf being beyond the speeds searched, in the unit of the table."""
        least, most = (float(self.ds.attrs[name]) for name in ("searched_from", "searched_to"))
        if math.isnan(value):
            return "-"
        return (
            f"< {self.speed(least)}" if value == 0 else f"> {self.speed(most)}" if value > most else self.speed(value)
        )

    def columns(self) -> Iterator[Shown]:
        """The table of ranks."""
        ds, count = self.ds, range(self.ds.sizes["material"])
        yield Shown("rank", "", False, tuple("-" if math.isnan(rank) else str(int(rank)) for rank in ds["rank"].values))
        yield Shown("material", "", True, tuple(self.names))
        yield Shown("quiet above", self.unit, False, tuple(map(self._quiet, count)))
        if "quiet_above_low" in ds:
            yield Shown(f"{self.level} interval", self.unit, True, tuple(map(self._interval, count)))
        if "belt_speed" in ds.dims:
            for j, speed in enumerate(self.speeds):
                yield from self._at_speed(ds.isel(belt_speed=j), f" at {self.speed(speed)} {self.unit}")
        elif "regime" in ds:
            yield from self._at_speed(ds, "")
        if ds["tendency"].ndim == 1:
            yield Shown("tendency", "", False, tuple(map(_three, ds["tendency"].values)))
        yield Shown("mu_start", "", False, tuple(map(_three, ds["mu_start"].values)))
        yield Shown("fit", "", True, tuple(map(self._fit, count)))

    def _at_speed(self, ds: xr.Dataset, which: str) -> Iterator[Shown]:
        """Columns of a belt speed, one of several (which) or the only one, or of a range."""
        regimes = tuple(flag_label(REGIMES[int(code)]) if code else "-" for code in ds["regime"].values)
        yield Shown((which or f" {self._at()}").strip(), "", True, regimes)
        if not which:
            unit = "slowest speed over border" if self._is_range else "speed over border"
            yield Shown("margin", unit, False, tuple(map(self._margin, range(len(regimes)))))
        if "quiet_probability" in ds:
            yield Shown(f"P(quiet){which}", "", False, tuple(map(_share, ds["quiet_probability"].values)))

    def _at(self) -> str:
        """The belt speed that is asked about, or the range."""
        ends = " to ".join(map(self.speed, self.speeds))
        return f"{'worst from' if self._is_range else 'at'} {ends} {self.unit}"

    def remarks(self) -> list[str]:
        """What the table does not say by itself."""
        return [
            *self._bounds(),
            *self.limits(),
            *self._only_the_product(),
            *measurements(self.ds, self.unit, self.speed, self.bound),
        ]

    def limits(self) -> list[str]:
        """What keeps the table from being certain."""
        told = (self._undecided, self._damping, self._fits, self._extrapolated, self._order, self._falling)
        return [text for one in told for text in one()]

    def answer(self) -> str:
        """The decision: what is quiet at the belt speeds that were asked for, else from which speed on the best is."""
        if self.speeds:
            pieces = (
                [self.ds.isel(belt_speed=j) for j in range(len(self.speeds))]
                if "belt_speed" in self.ds.dims
                else [self.ds]
            )
            heads = [f"At {self.speed(speed)} {self.unit}" for speed in self.speeds]
            if self._is_range:
                heads = [f"From {self.speed(self.speeds[0])} to {self.speed(self.speeds[1])} {self.unit}"]
            return " ".join(map(self._answer_at, pieces, heads))
        if math.isnan(self.ds["rank"].values[0]):
            return f"The points do not tell where the vibration of {listed(self.names, 'and')} ends."
        if len(self.names) == 1:
            return f"The border of {self.names[0]}: quiet above {self._quiet(0)} {self.unit}."
        return f"{self.names[0]} is quiet from the lowest belt speed on."

    def _answer_at(self, ds: xr.Dataset, head: str) -> str:
        """What is quiet at a belt speed, or throughout a range, and what is not."""
        verdicts: dict[tuple[str, str], list[str]] = {}
        for i, name in enumerate(self.names):
            chance = float(ds["quiet_probability"].values[i]) if "quiet_probability" in ds else math.nan
            verdict, sure = self._verdict(ds, i), chance
            told = [] if math.isnan(chance) else [f"P(quiet) {_share(chance)}"]
            if verdict == "partly":
                told = [f"above {self._quiet(i)} {self.unit}"]
            elif verdict == "vibrates":
                sure = 1.0 - chance
            if sure < _CERTAIN and verdict != "partly":
                told.append(f"P(vibrates) {_share(1.0 - chance - float(ds['undecided_probability'].values[i]))}")
            adverb = "probably " if sure < _CERTAIN else ""
            verdicts.setdefault((verdict, "perhaps " if sure < 0.5 else adverb), []).append(
                f"{name} ({', '.join(told)})" if told else name
            )
        throughout = " throughout" if self._is_range else ""
        phrases = {
            "quiet": ("is {}quiet" + throughout, "are {}quiet" + throughout),
            "partly": ("is quiet in a part of it",) + ("are quiet in a part of it",),
            "vibrates": ("{}vibrates" + throughout, "{}vibrate" + throughout),
            "window": ("is {}quiet, but vibrates at higher speeds", "are {}quiet, but vibrate at higher speeds"),
            "unknown": ("is not determined", "are not determined"),
        }  # fmt: skip
        said = [f"{listed(names, 'and')} {words[len(names) > 1].format(adverb)}" for kind, words in phrases.items()
                for (verdict, adverb), names in verdicts.items() if verdict == kind]  # fmt: skip
        return f"{head} {'; '.join(said)}."

    def _verdict(self, ds: xr.Dataset, i: int) -> str:
        """What a material does at a belt speed: vibrate, be quiet there and above, be quiet there, or nobody knows; in
        a range also be quiet in a part of it."""
        state, regime = self._state(i), REGIMES[int(ds["regime"].values[i])]
        if state == "not_determined" or (
            state == "unresolved" and regime not in VIBRATING and not ds["margin"].values[i] > 1
        ):
            return "unknown"
        if regime in VIBRATING:
            return "partly" if self._is_range and ds["vibrating_share"].values[i] < 1 else "vibrates"
        return "quiet" if ds["margin"].values[i] > 1 and state != "vibrates_throughout" else "window"

    def conditions(self) -> list[tuple[str, str]]:
        """The system, in the units in which it was given."""
        found = []
        for name in _SYSTEM:
            row, value = PARAMETERS[name], float(self.ds.attrs[f"system_{name}"])
            written = str(self.ds.attrs.get(f"written_{name}", f"{value:.6g} {units.spelled(row.units)}"))
            if name == "damping" and "damping_in_percent" in self.ds.attrs:
                written = f"{value:.4g} N s/m, {100.0 * value / critical_damping(self.ds):.3g} % of critical"
            assumed = " (assumed)" if name == "damping" and "damping_assumed" in self.ds.attrs else ""
            varies = f" ({'least' if name == 'damping' else 'largest'} of several: ranks are those there)"
            varies = varies if name in self.varied else ""
            found.append((row.long_name, f"{written}{assumed}{varies}"))
        if "friction_scale" in self.ds.attrs:
            found.append(("scale of friction", f"{float(self.ds.attrs['friction_scale']):g}"))
        if self.speeds:
            ends = (" to " if self._is_range else ", ").join(map(self.speed, self.speeds))
            found.append(("belt speed", f"{ends} {self.unit}"))
        return found

    def sheet(self) -> Sheet:
        """The table of ranks as a sheet of a workbook, conditions and remarks below it."""
        columns = [*self.columns()]
        columns[0], columns[1] = columns[1], columns[0]  # the material stays in sight
        heading = [f"{one.name}\n({one.unit})" if one.unit else one.name for one in columns]
        rows = [list(map(_number_or_word, row)) for row in zip(*(one.cells for one in columns), strict=True)]
        said = [self.what_quiet_means(), self.what_the_interval_means()]
        remarks = [[text] for text in (*self.remarks(), *said) if text]
        return Sheet("ranks", heading, rows, [[], ["Conditions:"], *self.conditions(), [], ["Remarks:"], *remarks])

    def what_quiet_means(self) -> str:
        """What was looked for, and where."""
        ds = self.ds
        low, high = (self.speed(float(ds.attrs[name])) for name in ("searched_from", "searched_to"))
        return (
            "Quiet: what begins in stick ends in steady sliding; neither stick-slip nor another vibration lasts. Belt "
            f"speeds from {low} to {high} {self.unit} were searched; a vibration that begins and ends between two of "
            f"{int(ds.attrs['searched_points'])} places there is missed."
        )

    def what_the_interval_means(self) -> str:
        """Where intervals come from."""
        if "quiet_above_low" not in self.ds:
            return ""
        without = bool((self.ds["rank"].notnull() & (self.ds["draws_used"] == 0)).any())
        none = " Where too few points are to spare, or follow another curve, there is none." if without else ""
        return (
            f"The {self.level} intervals are quantiles of {int(self.ds.attrs['draws']):,} curves a material, drawn "
            "from what its fit leaves open: the scatter of the points, not of specimens, temperature or the system."
            f"{none}{self._between_repeats()}"
        )

    def _between_repeats(self) -> str:
        """The materials whose interval holds more."""
        if "repeats" not in self.ds:
            return ""
        rows = zip(self.names, self.ds["repeats"].values, self.ds["repeat_names"].values, strict=True)
        told = [f"{name} ({str(names).replace('; ', ', ')})" for name, count, names in rows if count > 1]
        return f" Of {listed(told, 'and')}, measured repeatedly, they hold what differs between the repeats as well."

    # --- cells ----------------------------------------------------------------------------------------------------

    def _fit(self, i: int) -> str:
        if not self.ds["fit_good"].values[i] or self._state(i) == "not_determined":
            return self._doubt(i)
        return "a2 open" if self.ds["a2"].values[i] > 0 and self.ds["a2_low"].values[i] == 0 else "good"

    def _doubt(self, i: int) -> str:
        """In two words why a fit is not good; a remark says it in full."""
        if self._state(i) == "not_determined":
            return "not determined"
        if self.ds["a3"].values[i] == 0:
            return "no fall"
        names = [name for name in ("a1", "a2", "a3", "a4") if math.isinf(self.ds[f"{name}_high"].values[i])]
        return f"{listed(names, 'and')} open" if names else "doubtful"

    def _state(self, i: int) -> str:
        return QUIET_STATES[int(self.ds["quiet_state"].values[i])]

    def _quiet(self, i: int) -> str:
        if self._state(i) == "not_determined":
            return "-"
        sign = {"quiet_throughout": "< ", "vibrates_throughout": "> ", "unresolved": "<= "}.get(self._state(i), "")
        return sign + self.speed(float(self.ds["quiet_above"].values[i]))

    def _interval(self, i: int) -> str:
        low, high = (float(self.ds[f"quiet_above_{end}"].values[i]) for end in ("low", "high"))
        if math.isnan(low):
            return "not determined"
        return self.bound(low) if low == high or low == math.inf else f"{self.bound(low)} to {self.bound(high)}"

    def _margin(self, i: int) -> str:
        value = float(self.ds["margin"].values[i])
        if math.isnan(value):
            return "-"
        sign = {"vibrates_throughout": "< ", "unresolved": ">= "}.get(self._state(i), "")
        bound = self.speeds[0] / float(self.ds.attrs["searched_from"])  # nothing vibrates down to there
        return f"{sign}x {value:.3g}" if math.isfinite(value) else f"> x {bound:.3g}"

    # --- remarks --------------------------------------------------------------------------------------------------

    def _bounds(self) -> Iterator[str]:
        """Materials whose number is a bound."""
        states = [self._state(i) for i in range(len(self.names))]
        told = {
            "quiet_throughout": "no vibration lasts at any speed searched",
            "vibrates_throughout": "vibrates up to the fastest speed searched",
            "unresolved": "cells without a verdict lie around the border: the speed is an upper bound",
        }
        for state, words in told.items():
            if found := [name for name, one in zip(self.names, states, strict=True) if one == state]:
                yield f"{listed(found, 'and')}: {words}."
        undamped = self.ds.attrs["system_damping"] == 0
        for name, state, a2 in zip(self.names, states, self.ds["a2"].values, strict=True):
            if state == "vibrates_throughout" and undamped and a2 == 0:
                yield (
                    f"{name}: nothing takes energy out at high speed: the curve never rises and the damping is 0. Give "
                    "the damping of the system, or measure at higher speed."
                )

    def _undecided(self) -> Iterator[str]:
        """Materials of whose drawn curves some have no verdict at the belt speed."""
        if "undecided_probability" not in self.ds:
            return
        shares = self.ds["undecided_probability"].values.reshape(len(self.names), -1).max(axis=1)
        for name, share in zip(self.names, shares, strict=True):
            if share > 0:
                yield (
                    f"{name}: {_share(share)} of the curves drawn have no verdict at the belt speed (step limit); they "
                    "are not in P(quiet), and need not vibrate."
                )

    def _damping(self) -> Iterator[str]:
        """The damper that nobody told of."""
        if "damping_assumed" in self.ds.attrs:
            yield (
                "Damping 0 N s/m was assumed for all materials; a damper lowers the borders: give --damping, in N s/m "
                f'or in percent of critical damping ("3 %"). {_TYPICAL_DAMPING}.'
            )

    def _only_the_product(self) -> Iterator[str]:
        """What loads and scales of friction have in common."""
        if {"normal_load", "friction_scale"} & {*self.varied, *self.ds.attrs}:
            yield (
                "Only friction times load counts: twice the load moves a border as twice the friction coefficient at "
                "every speed does."
            )

    def _extrapolated(self) -> Iterator[str]:
        """A belt speed and borders outside of what was measured."""
        ends = float(self.ds["slowest_point"].min()), float(self.ds["fastest_point"].max())
        for asked in self.speeds:
            if not ends[0] <= asked <= ends[1]:
                side = f"slowest, {self.speed(ends[0])}" if asked < ends[0] else f"fastest, {self.speed(ends[1])}"
                yield (
                    f"The belt speed, {self.speed(asked)} {self.unit}, lies beyond the {side} {self.unit}, that was "
                    "measured of any material: what is told there follows from the fitted curves alone."
                )
        for i, name in enumerate(self.names):
            border, slow, fast = (
                float(self.ds[one].values[i]) for one in ("quiet_above", "slowest_point", "fastest_point")
            )
            if self._state(i) == "border" and not slow <= border <= fast:
                side = f"slowest, {self.speed(slow)}" if border < slow else f"fastest, {self.speed(fast)}"
                yield f"{name}: the border lies beyond the {side} {self.unit}, that was measured."

    def _order(self) -> Iterator[str]:
        """Neighbours whose order may be chance."""
        if "better_than_next" not in self.ds:
            return
        for i, chance in enumerate(self.ds["better_than_next"].values[:-1]):
            if not chance >= _CERTAIN and "not_determined" not in (self._state(i), self._state(i + 1)):
                one, other = self.names[i], self.names[i + 1]
                told = "cannot be told" if math.isnan(chance) else f"has a probability of {_share(chance)}"
                yield f"That {one} is quiet from a lower speed on than {other} {told}."

    def _falling(self) -> Iterator[str]:
        """Materials whose friction may fall for ever, as far as the points tell."""
        if "draws_falling" not in self.ds:
            return
        for name, share in zip(self.names, self.ds["draws_falling"].values, strict=True):
            if share >= _WORTH_SAYING:
                yield (
                    f"{name}: {_share(share)} of the curves that the points allow fall for ever (a2 < 0); where no "
                    "damper outweighs this, they vibrate at any speed, and open the interval upwards. Measure at "
                    "higher speed."
                )

    def _fits(self) -> Iterator[str]:
        """Curves that may not be used without reservation."""
        columns = (self.ds[one].values for one in ("fit_good", "fit_quality", "rank"))
        for name, good, quality, rank in zip(self.names, *columns, strict=True):
            if not good or math.isnan(rank):
                yield f"{name}: {'' if not math.isnan(rank) else 'not determined, and not ranked. '}{quality}"


def _three(value: float) -> str:
    return "-" if math.isnan(value) else f"{float(value):.3f}"


def _share(value: Any) -> str:
    if math.isnan(value):
        return "not known"
    return "> 99.9 %" if value > 0.999 else "< 0.1 %" if value < 0.001 else f"{100 * float(value):.3g} %"


def _number_or_word(cell: str) -> str | float:
    """What a cell of a sheet holds: a number as one, so that it can be sorted."""
    try:
        return float(cell.removeprefix("x "))  # a margin
    except ValueError:
        return cell
