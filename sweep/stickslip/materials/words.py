"""Materials compared, in words: the table of ranks and the remarks below it, for the screen and for pages."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from stickslip.dataset.export import Sheet
from stickslip.vocabulary import units
from stickslip.vocabulary.flags import QUIET_STATES, REGIMES, flag_label
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.words import listed

_SYSTEM = ("mass", "stiffness", "damping", "normal_load")
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
        self._ds = ds
        self.unit = unit or str(ds["quiet_above"].attrs.get("display_units", "m/s"))
        self.factor = 1.0 / units.si_value(f"1 {self.unit}", "m s-1")
        self.level = f"{100 * float(ds.attrs['confidence']):g} %"

    @property
    def names(self) -> list[str]:
        """The materials, best first."""
        return [str(name) for name in self._ds["material"].values]

    def speed(self, value: float) -> str:
        """A speed (m/s) as a number in the unit of the table."""
        number = self.factor * value
        return f"{number:.3g}" if number < 1000 else f"{number:.0f}"

    def columns(self) -> Iterator[Shown]:
        """The table of ranks."""
        ds, count = self._ds, range(self._ds.sizes["material"])
        yield Shown("rank", "", False, tuple(str(int(rank)) for rank in ds["rank"].values))
        yield Shown("material", "", True, tuple(self.names))
        yield Shown("quiet above", self.unit, False, tuple(map(self._quiet, count)))
        if "quiet_above_low" in ds:
            yield Shown(f"{self.level} interval", self.unit, True, tuple(map(self._interval, count)))
        if "regime" in ds:
            at = f"at {self.speed(float(ds.attrs['belt_speed']))} {self.unit}"
            regimes = tuple(flag_label(REGIMES[int(code)]) for code in ds["regime"].values)
            yield Shown(at, "", True, regimes)
            yield Shown("margin", "speed over border", False, tuple(map(self._margin, count)))
            if "quiet_probability" in ds:
                yield Shown("P(quiet)", "", False, tuple(map(_share, ds["quiet_probability"].values)))
        yield Shown("tendency", "Eq. (3)", False, tuple(f"{float(one):.3f}" for one in ds["tendency"].values))
        yield Shown("mu_start", "", False, tuple(f"{float(one):.3f}" for one in ds["mu_start"].values))
        yield Shown("fit", "", True, tuple(map(self._fit, count)))

    def remarks(self) -> list[str]:
        """What the table does not say by itself."""
        return [
            *self._bounds(),
            *self._damping(),
            *self._extrapolated(),
            *self._order(),
            *self._falling(),
            *self._fits(),
        ]

    def answer(self) -> str:
        """The decision: what is quiet at the belt speed that was asked for, else from which speed on the best is."""
        if "belt_speed" not in self._ds.attrs:
            if len(self.names) == 1:
                return f"The border of {self.names[0]}: quiet above {self._quiet(0)} {self.unit}."
            return f"{self.names[0]} is quiet from the lowest belt speed on."
        at = f"At {self.speed(float(self._ds.attrs['belt_speed']))} {self.unit}"
        quiet: list[str] = []
        loud: list[str] = []
        for i, name in enumerate(self.names):
            here = bool(self._ds["margin"].values[i] > 1) and self._state(i) != "vibrates_throughout"
            chance = self._ds["quiet_probability"].values[i] if "quiet_probability" in self._ds else math.nan
            (quiet if here else loud).append(name if math.isnan(chance) else f"{name} (P(quiet) {_share(chance)})")
        told = [f"{at} {listed(quiet, 'and')} {'are' if len(quiet) > 1 else 'is'} quiet"] if quiet else []
        told += [
            f"{'' if quiet else f'{at} '}{listed(loud, 'and')} {'vibrate' if len(loud) > 1 else 'vibrates'}"
        ] * bool(loud)
        return "; ".join(told) + "."

    def conditions(self) -> list[tuple[str, str]]:
        """The system, in the units in which it was given."""
        found = []
        for name in _SYSTEM:
            row, value = PARAMETERS[name], float(self._ds.attrs[f"system_{name}"])
            written = self._ds.attrs.get(f"written_{name}", f"{value:.6g} {units.spelled(row.units)}")
            assumed = " (assumed)" if name == "damping" and "damping_assumed" in self._ds.attrs else ""
            found.append((row.long_name, f"{written}{assumed}"))
        if "belt_speed" in self._ds.attrs:
            found.append(("belt speed", f"{self.speed(float(self._ds.attrs['belt_speed']))} {self.unit}"))
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
        ds = self._ds
        low, high = (self.speed(float(ds.attrs[name])) for name in ("searched_from", "searched_to"))
        return (
            "Quiet: what begins in stick ends in steady sliding; neither stick-slip nor another vibration lasts. Belt "
            f"speeds from {low} to {high} {self.unit} were searched; a vibration that begins and ends between two of "
            f"{int(ds.attrs['searched_points'])} places there is missed."
        )

    def what_the_interval_means(self) -> str:
        """Where intervals come from."""
        if "quiet_above_low" not in self._ds:
            return ""
        return (
            f"The {self.level} intervals are quantiles of {int(self._ds.attrs['draws']):,} curves a material, drawn "
            "from the covariance of its fit: the scatter of the points, not of specimens, temperature or the system"
            f"{self._assumed()}.{self._between_repeats()}"
        )

    def _between_repeats(self) -> str:
        """The materials whose interval holds more."""
        if "repeats" not in self._ds:
            return ""
        rows = zip(self.names, self._ds["repeats"].values, self._ds["repeat_names"].values, strict=True)
        told = [f"{name} ({str(names).replace('; ', ', ')})" for name, count, names in rows if count > 1]
        return f" Of {listed(told, 'and')}, measured repeatedly, they hold what differs between the repeats as well."

    def _assumed(self) -> str:
        """The materials whose fit assumed that friction never rises."""
        assumed = (self._ds["a2"] == 0) & np.isinf(self._ds["a2_high"])
        names = [name for name, zero in zip(self.names, assumed.values, strict=True) if zero]
        return f"; that a2 = 0, which the fit of {listed(names, 'and')} assumed, is taken for granted" if names else ""

    # --- cells ----------------------------------------------------------------------------------------------------

    def _fit(self, i: int) -> str:
        if not self._ds["fit_good"].values[i]:
            return "see below"
        return "a2 open" if self._ds["a2"].values[i] > 0 and self._ds["a2_low"].values[i] == 0 else "good"

    def _state(self, i: int) -> str:
        return QUIET_STATES[int(self._ds["quiet_state"].values[i])]

    def _quiet(self, i: int) -> str:
        sign = {"quiet_throughout": "< ", "vibrates_throughout": "> ", "unresolved": "<= "}.get(self._state(i), "")
        return sign + self.speed(float(self._ds["quiet_above"].values[i]))

    def _interval(self, i: int) -> str:
        low, high = (float(self._ds[f"quiet_above_{end}"].values[i]) for end in ("low", "high"))
        if math.isnan(low):
            return "not determined"
        least, most = (float(self._ds.attrs[name]) for name in ("searched_from", "searched_to"))
        first = self.speed(low) if low > 0 else f"< {self.speed(least)}"
        last = self.speed(high) if math.isfinite(high) else f"> {self.speed(most)}"
        return (
            f"< {self.speed(least)}"
            if high == 0
            else f"> {self.speed(most)}"
            if low == math.inf
            else f"{first} to {last}"
        )

    def _margin(self, i: int) -> str:
        value = float(self._ds["margin"].values[i])
        sign = {"vibrates_throughout": "< ", "unresolved": ">= "}.get(self._state(i), "")
        return f"{sign}x {value:.3g}" if math.isfinite(value) else "> 1"

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
        undamped = self._ds.attrs["system_damping"] == 0
        for name, state, a2 in zip(self.names, states, self._ds["a2"].values, strict=True):
            if state == "vibrates_throughout" and undamped and a2 == 0:
                yield (
                    f"{name}: nothing takes energy out at high speed: the curve never rises and the damping is 0. Give "
                    "the damping of the system, or measure at higher speed."
                )

    def _damping(self) -> Iterator[str]:
        """The damper that nobody told of."""
        if "damping_assumed" in self._ds.attrs:
            yield "Damping 0 N s/m was assumed for all materials; a damper lowers the borders: give --damping."

    def _extrapolated(self) -> Iterator[str]:
        """A belt speed and borders outside of what was measured."""
        ends = float(self._ds["slowest_point"].min()), float(self._ds["fastest_point"].max())
        if "belt_speed" in self._ds.attrs and not ends[0] <= (asked := float(self._ds.attrs["belt_speed"])) <= ends[1]:
            side = f"slowest, {self.speed(ends[0])}" if asked < ends[0] else f"fastest, {self.speed(ends[1])}"
            yield (
                f"The belt speed, {self.speed(asked)} {self.unit}, lies beyond the {side} {self.unit}, that was "
                "measured of any material: what is told there follows from the fitted curves alone."
            )
        for i, name in enumerate(self.names):
            border, slow, fast = (
                float(self._ds[one].values[i]) for one in ("quiet_above", "slowest_point", "fastest_point")
            )
            if self._state(i) == "border" and not slow <= border <= fast:
                side = f"slowest, {self.speed(slow)}" if border < slow else f"fastest, {self.speed(fast)}"
                yield f"{name}: the border lies beyond the {side} {self.unit}, that was measured."

    def _order(self) -> Iterator[str]:
        """Neighbours whose order may be chance."""
        if "better_than_next" not in self._ds:
            return
        for i, chance in enumerate(self._ds["better_than_next"].values[:-1]):
            if not chance >= _CERTAIN:
                one, other = self.names[i], self.names[i + 1]
                told = "cannot be told" if math.isnan(chance) else f"has a probability of {_share(chance)}"
                yield f"That {one} is quiet from a lower speed on than {other} {told}."

    def _falling(self) -> Iterator[str]:
        """Materials whose friction may fall for ever, as far as the points tell."""
        if "draws_falling" not in self._ds:
            return
        for name, share in zip(self.names, self._ds["draws_falling"].values, strict=True):
            if share >= _WORTH_SAYING:
                yield (
                    f"{name}: {_share(share)} of the curves that the points allow fall for ever (a2 < 0); where no "
                    "damper outweighs this, they vibrate at any speed, and open the interval upwards. Measure at "
                    "higher speed."
                )

    def _fits(self) -> Iterator[str]:
        """Curves that may not be used without reservation."""
        for name, good, quality in zip(
            self.names, self._ds["fit_good"].values, self._ds["fit_quality"].values, strict=True
        ):
            if not good:
                yield f"{name}: {quality}"


def _share(value: Any) -> str:
    if math.isnan(value):
        return "not known"
    return "> 99.9 %" if value > 0.999 else "< 0.1 %" if value < 0.001 else f"{100 * float(value):.3g} %"


def _number_or_word(cell: str) -> str | float:
    """What a cell of a sheet holds: a number as one, so that it can be sorted."""
    try:
        return float(cell)
    except ValueError:
        return cell
