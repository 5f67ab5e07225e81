"""Materials compared, in words: the table of ranks, the verdict, notes; for screen and page."""

import math
from collections.abc import Callable, Iterator, Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import xarray as xr

from stickslip.vocabulary import units
from stickslip.vocabulary.flags import QUIET_STATES, REGIMES, UNDECIDED, VIBRATING, flag_label
from stickslip.vocabulary.models import BREAKAWAY, CURVE
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.suggest import listed
from stickslip_materials.compare.dataset import speeds_of
from stickslip_materials.compare.system import SYSTEM, critical_damping
from stickslip_materials.variables import MATERIAL_VARIABLES

# V. Adams, A. Askenazi, Building Better Products with Finite Element Analysis (1999), viscous damping ratios.
_TYPICAL_DAMPING = (
    "Metal in one piece has below 1 % of critical, structures of metal have 2 to 4 %, with joints 3 to 7 %, rubber 5 %"
)
_WORTH_SAYING = 0.01  # share of the curves drawn
_CERTAIN = 0.975  # probability
_BOUNDS = {  # of materials whose number is a bound: the sign before it, and why
    "quiet_throughout": ("< ", "No vibration lasts at any speed searched."),
    "vibrates_throughout": ("> ", "It vibrates up to the fastest speed searched."),
    "unresolved": ("<= ", "Cells without a verdict lie around the border: the speed is an upper bound."),
}
_ANSWERS = {  # of one material, of several; in place of {} "probably ", in place of * "throughout"
    "quiet": ("is {}quiet*", "are {}quiet*"),
    "partly": ("is quiet in a part of it", "are quiet in a part of it"),
    "vibrates": ("{}vibrates", "{}vibrate"),
    "settles": ("settles there, but vibrates at higher speeds", "settle there, but vibrate at higher speeds"),
    "open": ("may be quiet or not", "may be quiet or not"),
    "unknown": ("is not determined", "are not determined"),
}


class RankColumn(NamedTuple):
    """A column of the table: its heading, its unit, whether it holds words, and the cells, best material first."""

    name: str
    unit: str
    is_text: bool
    cells: tuple[str, ...]


def verdict(row: Any, fastest: float = math.nan) -> str:
    """The numbers of a material at a belt speed in one word, a key of `_ANSWERS`.

    These are the regime of the fitted curve, its margin, and the probability of being quiet among the curves drawn,
    all of which are shown; where one of them contradicts the others nothing is decided.

    row : a material, by names of MATERIAL_VARIABLES, with its `state`. fastest : the end (m/s) of a range of speeds.
    """
    vibrates, beyond = REGIMES[int(row.regime)] in VIBRATING, row.margin > 1
    quiet = row.quiet_probability  # NaN without draws, which then contradict nothing
    if row.state == "not_determined" or int(row.regime) in UNDECIDED:
        return "unknown"
    if beyond:
        return "open" if vibrates or quiet < 0.5 else "quiet"
    if row.state == "unresolved" and not vibrates:
        return "unknown"
    if 1.0 - quiet - row.undecided_probability < 0.5:
        return "open"
    if row.quiet_above < fastest:
        return "partly"
    return "vibrates" if vibrates else "settles"


class RankTable:
    """A comparison (`stickslip.compare`) in words. unit : of speeds; None takes that of the measured points."""

    def __init__(self, ds: xr.Dataset, unit: str | None = None) -> None:
        self.ds = ds
        self.names = [str(name) for name in ds["material"].values]
        self.unit = unit or str(ds["quiet_above"].attrs.get("display_units", "m/s"))
        self.factor = 1.0 / units.si_value(f"1 {self.unit}", "m s-1")
        self.level = f"{100 * float(ds.attrs['confidence']):g} %"
        self.speeds = speeds_of(ds)
        self._is_range = "speed_range_from" in ds.attrs
        several = [ds.isel(belt_speed=j) for j in range(ds.sizes.get("belt_speed", 0))]
        self._at = [_rows(at) for at in several or [ds]]  # materials at each belt speed
        self._rows = self._at[0]

    def speed(self, value: float) -> str:
        """A speed (m/s) as a number in the unit of the table."""
        number = self.factor * value
        return f"{number:.3g}" if number < 1000 else f"{number:.0f}"

    def _bound(self, value: float) -> str:
        """A border, 0 and inf being beyond the speeds searched, in the unit of the table."""
        least, most = (float(self.ds.attrs[name]) for name in ("searched_from", "searched_to"))
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
            name = place.strip() or f"{'worst from' if self._is_range else 'at'} {ends}"
            yield self._column(name, None, lambda row: flag_label(REGIMES[row.regime]) if row.regime else "-", rows)
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
        return self._bound(low) if low == high or low == math.inf else f"{self._bound(low)} to {self._bound(high)}"

    def _margin(self, row: Any) -> str:
        if math.isnan(row.margin):
            return "-"
        sign = {"vibrates_throughout": "< ", "unresolved": ">= "}.get(row.state, "")
        bound = self.speeds[0] / float(self.ds.attrs["searched_from"])  # nothing vibrates down to there
        return f"{sign}x {row.margin:.3g}" if math.isfinite(row.margin) else f"> x {bound:.3g}"

    def conditions(self) -> list[tuple[str, str]]:
        """The system, in the units in which it was given."""
        attributes, rows = self.ds.attrs, []
        for name in SYSTEM:
            row, value = PARAMETERS[name], float(attributes[f"system_{name}"])
            text = str(attributes.get(f"written_{name}", f"{value:.6g} {units.spelled(row.units)}"))
            if name == "damping" and "damping_in_percent" in attributes:
                text = f"{value:.4g} N s/m, {100.0 * value / critical_damping(self.ds):.3g} % of critical"
            text += " (assumed)" if name == "damping" and "damping_assumed" in attributes else ""
            rows.append((row.long_name, text))
        if self.speeds:
            speeds = (" to " if self._is_range else ", ").join(map(self.speed, self.speeds))
            rows.append(("belt speed", f"{speeds} {self.unit}"))
        return rows

    # --- the verdict --------------------------------------------------------------------------------------------------

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
            kind = verdict(row, self.speeds[-1] if self._is_range else math.nan)
            quiet, vibrating = row.quiet_probability, 1.0 - row.quiet_probability - row.undecided_probability
            chance = vibrating if kind == "vibrates" else quiet
            is_open = kind in ("quiet", "vibrates") and chance < _CERTAIN
            notes = [] if math.isnan(quiet) else [f"P(quiet) {_share(quiet)}"]
            if kind in ("partly", "settles"):
                notes = [f"above {self._quiet(row)} {self.unit}"]
            elif is_open or kind == "open":
                notes += [] if math.isnan(quiet) else [f"P(vibrates) {_share(vibrating)}"]
            name = f"{row.name} ({', '.join(notes)})" if notes else row.name
            groups.setdefault((kind, "probably " if is_open else ""), []).append(name)
        throughout = " throughout" if self._is_range else ""
        parts = [f"{listed(names, 'and')} {forms[len(names) > 1].replace('*', throughout).format(adverb)}"
                 for kind, forms in _ANSWERS.items()
                 for (other, adverb), names in groups.items() if other == kind]  # fmt: skip
        return f"{head} {'; '.join(parts)}."

    def method(self) -> list[str]:
        """The meaning of quiet and of the intervals."""
        ds = self.ds
        low, high = (self.speed(float(ds.attrs[name])) for name in ("searched_from", "searched_to"))
        sentences = [
            "Quiet: what begins in stick ends in steady sliding, at this speed and at all above it; neither stick-slip "
            f"nor another vibration lasts. Belt speeds from {low} to {high} {self.unit} were searched; a vibration "
            f"that begins and ends between two of {int(ds.attrs['searched_points'])} places there is missed."
        ]
        if "quiet_above_low" not in ds:
            return sentences
        text = (
            f"The {self.level} intervals are quantiles of {int(ds.attrs['draws']):,} curves a material, drawn "
            "from what its fit leaves open: the scatter of the points, not of specimens, temperature or the system."
        )
        if bool((ds["rank"].notnull() & (ds["draws_used"] == 0)).any()):
            text += " Where too few points are to spare, or follow another curve, there is none."
        return [*sentences, text]

    # --- notes --------------------------------------------------------------------------------------------------------

    def notes(self) -> list[tuple[str, str]]:
        """What the table does not show by itself: on the system, then at most one note a material, by its name."""
        texts = []
        if "damping_assumed" in self.ds.attrs:
            texts.append(
                "Damping 0 N s/m was assumed for all materials; a damper lowers the borders: give --damping, in N s/m "
                f'or in percent of critical damping ("3 %"). {_TYPICAL_DAMPING}.'
            )
        slowest, fastest = min(row.slowest_point for row in self._rows), max(row.fastest_point for row in self._rows)
        if beyond := [self.speed(speed) for speed in self.speeds if not slowest <= speed <= fastest]:
            ends = f"{self.speed(slowest)} to {self.speed(fastest)} {self.unit}"
            texts.append(
                f"Belt speed {listed(beyond, 'and')} {self.unit} lies beyond the speeds that were measured, {ends}: "
                "what is told there follows from the fitted curves alone."
            )
        notes = ((row.name, " ".join(self._facts(i))) for i, row in enumerate(self._rows))
        return [*(("", text) for text in texts), *((name, text) for name, text in notes if text)]

    def remarks(self) -> list[str]:
        """The notes as lines."""
        return [f"{name}: {text}" if name else text for name, text in self.notes()]

    def _facts(self, place: int) -> Iterator[str]:
        """Sentences on what keeps the numbers of a material from being certain."""
        row = self._rows[place]
        if math.isnan(row.rank):
            yield f"not determined, and not ranked. {row.fit_quality}"
            return
        if not row.fit_good:
            yield row.fit_quality
        if row.state in _BOUNDS:
            yield _BOUNDS[row.state][1]
        slope = getattr(row, CURVE.slope)
        if row.state == "vibrates_throughout" and slope == self.ds.attrs["system_damping"] == 0:
            yield "The curve never rises and the damping is 0: give the damping, or measure at higher speed."
        if row.state == "border" and not row.slowest_point <= row.quiet_above <= row.fastest_point:
            ends = f"{self.speed(row.slowest_point)} to {self.speed(row.fastest_point)} {self.unit}"
            yield f"The border lies beyond the speeds that were measured, {ends}."
        undecided = max(rows[place].undecided_probability for rows in self._at)
        if undecided > 0:
            yield f"{_share(undecided)} of the curves drawn have no verdict at the belt speed (step limit)."
        if row.draws_falling >= _WORTH_SAYING:
            yield f"{_share(row.draws_falling)} of them fall for ever ({CURVE.slope} < 0): measure at higher speed."
        following = self._rows[place + 1] if place + 1 < len(self._rows) else row
        if following is not row and not math.isnan(following.rank) and row.better_than_next < _CERTAIN:
            chance = _share(row.better_than_next)
            yield f"That it is quiet from a lower speed on than {following.name} has a probability of {chance}."


def _rows(ds: xr.Dataset) -> list[Any]:
    """Materials, each with its numbers and words by name, NaN for those that the comparison lacks, and its state."""
    count = ds.sizes["material"]
    columns: dict[str, list[Any]] = dict.fromkeys(MATERIAL_VARIABLES, [math.nan] * count)
    columns |= {str(name): v.values.tolist() for name, v in ds.variables.items() if v.dims == ("material",)}
    columns |= {"name": columns["material"], "state": [QUIET_STATES[code] for code in columns["quiet_state"]]}
    return [SimpleNamespace(**dict(zip(columns, row, strict=True))) for row in zip(*columns.values(), strict=True)]


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


def _share(value: Any) -> str:
    if math.isnan(value):
        return "not known"
    return "> 99.9 %" if value > 0.999 else "< 0.1 %" if value < 0.001 else f"{100 * float(value):.3g} %"
