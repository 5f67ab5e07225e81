"""Materials compared, for people: the table of ranks, the answer in a line, notes, and the page to read, to send and to
print: answer, ranks, picture and notes, and on a second sheet what they rest on."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import xarray as xr

from stickslip.config.studies import ReportTable
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import scales_of
from stickslip.vocabulary.models import BREAKAWAY, FORMULA
from stickslip.vocabulary.quantities import PARAMETERS, QUIET_STATES, REGIMES, UNDECIDED, VIBRATING, flag_label, listed
from stickslip_materials.compare.result import MATERIAL_VARIABLES, speeds_of

_SIGNS = {"quiet_throughout": "< ", "vibrates_throughout": "> ", "unresolved": "<= "}  # of numbers that are bounds
_AGAIN = "Saved as a file, this configuration finds all borders of these curves (stickslip run):"
_MEANT = ("quiet_above", "margin", "quiet_probability", "fit_good")


def verdict(row: Any) -> str:
    """ "quiet", "vibrates" or "open" on a material at a belt speed or in a range: open where regime, margin and the
    probability of being quiet, which are shown, contradict each other.

    row : a material, by names of MATERIAL_VARIABLES, with its `state`.
    """
    quiet = row.quiet_probability  # NaN without draws, which then contradict nothing
    if row.state == "not_determined" or int(row.regime) in UNDECIDED:
        return "open"
    if REGIMES[int(row.regime)] in VIBRATING:
        return "open" if row.margin > 1 or quiet > 0.5 else "vibrates"
    return "quiet" if row.margin > 1 and not quiet < 0.5 else "open"


class RankTable:
    """A comparison (`stickslip.compare`) for people. unit : of speeds; None takes that of the measured points."""

    def __init__(self, ds: xr.Dataset, unit: str | None = None) -> None:
        self.ds = ds
        self.names = [str(name) for name in ds["material"].values]
        self.unit = unit or str(ds["quiet_above"].attrs.get("display_units", "m/s"))
        self.factor = 1.0 / units.si_value(f"1 {self.unit}", "m s-1")
        self.speeds = speeds_of(ds)
        self._searched = [float(ds.attrs[f"searched_{end}"]) for end in ("from", "to")]
        self._is_range = "speed_range_from" in ds.attrs
        several = [ds.isel(belt_speed=j) for j in range(ds.sizes.get("belt_speed", 0))]
        self._at = [_rows(at) for at in several or [ds]]  # materials at each belt speed
        self._rows = self._at[0]

    def _speed(self, value: float) -> str:
        """A speed (m/s) as a number in the unit of the table."""
        number = self.factor * value
        return f"{number:.3g}" if number < 1000 else f"{number:.0f}"

    def _span(self, speeds: Sequence[float]) -> str:
        return f"{' to '.join(map(self._speed, speeds))} {self.unit}"

    def table(self) -> ReportTable:
        """The ranks, the best material first."""
        rows = self._rows
        columns = {
            "rank": [_number(row.rank, 0) for row in rows],
            "material": self.names,
            f"quiet above [{self.unit}]": [self._quiet(row) for row in rows],
        }
        if "quiet_above_low" in self.ds:
            columns[f"{100 * float(self.ds.attrs['confidence']):g} % interval"] = [self._interval(row) for row in rows]
        several = len(self._at) > 1
        for at, speed in zip(self._at, self.speeds, strict=False):
            place = self._span(self.speeds if self._is_range else [speed])
            name = f"worst from {place}" if self._is_range else f"at {place}"
            columns[name] = [flag_label(REGIMES[row.regime]) if row.regime else "-" for row in at]
            if not several:
                columns["margin"] = [self._margin(row) for row in at]
            if "quiet_probability" in self.ds:
                columns[f"P(quiet) at {place}" if several else "P(quiet)"] = [_share(r.quiet_probability) for r in at]
        columns[BREAKAWAY] = [_number(getattr(row, BREAKAWAY), 3) for row in rows]
        columns["fit"] = ["not determined" if math.isnan(row.rank) else "good" if row.fit_good else "doubtful"
                          for row in rows]  # fmt: skip
        names = [*columns]
        return ReportTable("", names[:2], names[2:], [*zip(*columns.values(), strict=True)])

    def _quiet(self, row: Any) -> str:
        return "-" if row.state == "not_determined" else _SIGNS.get(row.state, "") + self._speed(row.quiet_above)

    def _interval(self, row: Any) -> str:
        """An interval, whose ends may be 0 and inf, beyond the speeds searched."""
        if math.isnan(row.quiet_above_low):
            return "not determined"
        least, most = self._searched
        ends = [f"< {self._speed(least)}" if end == 0 else f"> {self._speed(most)}" if end > most else self._speed(end)
                for end in (row.quiet_above_low, row.quiet_above_high)]  # fmt: skip
        return " to ".join(dict.fromkeys(ends))

    def _margin(self, row: Any) -> str:
        if math.isnan(row.margin):
            return "-"
        if math.isinf(row.margin):  # nothing vibrates down to the slowest speed searched
            return f"> {self.speeds[0] / self._searched[0]:.3g}"
        return f"{ {'vibrates_throughout': '< ', 'unresolved': '>= '}.get(row.state, '') }{row.margin:.3g}"

    def conditions(self) -> list[tuple[str, str]]:
        """The system, as it was given, and the belt speeds searched."""
        attributes = self.ds.attrs
        names = [name.removeprefix("system_") for name in attributes if name.startswith("system_")]
        system = {name: float(attributes[f"system_{name}"]) for name in names}
        rows = {name: f"{value:.4g} {units.spelled(PARAMETERS[name].units)}" for name, value in system.items()}
        rows |= {name: attributes.get(f"given_{name}", text) for name, text in rows.items() if name != "damping"}
        share = 100.0 * system["damping"] / float(scales_of(system).critical_damping)
        rows["damping"] += f" ({share:.3g} % of critical{', assumed' * ('damping_assumed' in attributes)})"
        shown = [(PARAMETERS[name].long_name, text) for name, text in rows.items()]
        return [*shown, ("belt speeds searched", self._span(self._searched))]

    def answer(self) -> str:
        """What is quiet at the belt speeds of the request, or in their range; without any the best material."""
        if self._is_range:
            return f"from {self._span(self.speeds)}: {_answer_at(self._rows)}"
        if self.speeds:
            lines = (f"at {self._span([speed])}: {_answer_at(at)}"
                     for at, speed in zip(self._at, self.speeds, strict=True))  # fmt: skip
            return "\n".join(lines)
        best = self._rows[0]
        if math.isnan(best.rank):
            return f"not determined: {listed(self.names, 'and')}"
        return f"quiet from the lowest belt speed on: {best.name}, above {self._quiet(best)} {self.unit}"

    def notes(self) -> list[tuple[str, str]]:
        """What the table does not show by itself: on all materials (""), then on those whose fit is not good."""
        notes = []
        if "synthetic" in self.ds.attrs:
            notes.append(("", f"SYNTHETIC, not measured, as the files say: {self.ds.attrs['synthetic']}"))
        if "damping_assumed" in self.ds.attrs:
            text = "damping 0 N s/m was assumed, and a damper lowers the borders: give the damping (metal in one piece "
            notes.append(("", f"{text}has below 1 % of critical, structures with joints 3 to 7 %)"))
        measured = min(row.slowest_point for row in self._rows), max(row.fastest_point for row in self._rows)
        if beyond := [self._speed(speed) for speed in self.speeds if not measured[0] <= speed <= measured[1]]:
            where = f"belt speed {listed(beyond, 'and')} {self.unit} lies beyond the speeds that were measured"
            notes.append(("", f"{where}, {self._span(measured)}"))
        ranked = [row for row in self._rows if math.isfinite(row.rank)]
        for this, after in pairwise(ranked):  # NaN without intervals, which then say nothing
            if this.quiet_above_high >= after.quiet_above_low:
                notes.append(("", f"{this.name} may be behind {after.name}: their intervals overlap"))
        return notes + [(row.name, row.fit_quality) for row in self._rows if math.isnan(row.rank) or not row.fit_good]

    def remarks(self) -> list[str]:
        """The notes as lines."""
        return [f"{name}: {text}" if name else text for name, text in self.notes()]


def _answer_at(rows: Sequence[Any]) -> str:
    """The materials by verdict."""
    names = {kind: [row.name for row in rows if verdict(row) == kind] for kind in ("quiet", "vibrates", "open")}
    return "; ".join(f"{kind} {listed(of_kind, 'and')}" for kind, of_kind in names.items() if of_kind)


def _rows(ds: xr.Dataset) -> list[Any]:
    """Materials, each with its numbers and words by name, NaN for those that the comparison lacks, and its state."""
    count = ds.sizes["material"]
    columns: dict[str, list[Any]] = dict.fromkeys(MATERIAL_VARIABLES, [math.nan] * count)
    columns |= {str(name): v.values.tolist() for name, v in ds.variables.items() if v.dims == ("material",)}
    columns |= {"name": columns["material"], "state": [QUIET_STATES[code] for code in columns["quiet_state"]]}
    return [SimpleNamespace(**dict(zip(columns, row, strict=True))) for row in zip(*columns.values(), strict=True)]


def _number(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def _share(value: Any) -> str:
    if math.isnan(value):
        return "not known"
    return "> 99.9 %" if value > 0.999 else "< 0.1 %" if value < 0.001 else f"{100 * float(value):.3g} %"


def material_page(ds: xr.Dataset, title: str | None = None) -> str:
    """A page of a comparison (`stickslip.compare`). title : that of the dataset, unless given."""
    from stickslip.plots import pages
    from stickslip_materials.plots import plot_materials

    ranking = RankTable(ds)
    alt = f"Friction over slip speed of {', '.join(ranking.names)}, and the belt speeds above which they are quiet"
    table = ranking.table()
    columns = [*(pages.Column(name, is_text=True) for name in table.words), *map(pages.Column, table.numbers)]
    system = f"The system: {', '.join(f'{name} {value}' for name, value in ranking.conditions())}."
    notes = [(name or "all", text) for name, text in ranking.notes()]
    qualities = pages.terms(zip(ranking.names, map(str, ds["fit_quality"].values), strict=True), "names")
    files = pages.terms([("points", str(ds.attrs["files"]).replace("\n", ", "))], "short")
    origin = pages.provenance(ds.attrs) + files + pages.paragraph(_AGAIN)
    small = [
        ("The fitted curves", pages.paragraph(f"Friction coefficient over slip speed w: {FORMULA}.") + qualities),
        ("What the numbers mean", pages.terms(_meanings(), "short")),
        ("Where this comes from", origin + pages.configuration(ds.attrs["configuration"])),
    ]
    sections = [
        pages.PageSection("Which is quiet", pages.table(columns, table.rows) + pages.paragraph(system)),
        pages.PageSection("Friction, and where vibration ends", pages.embedded(plot_materials(ds, title=""), alt)),
        *([pages.PageSection("Notes", pages.terms(notes, "short"))] if notes else []),
    ]
    sections[-1] = sections[-1]._replace(html=sections[-1].html + pages.details(small))
    return pages.page(str(ds.attrs["title"]) if title is None else title, ranking.answer(), sections)


def _meanings() -> Iterator[tuple[str, str]]:
    """The columns that decide, as the dataset describes them."""
    for row in map(MATERIAL_VARIABLES.__getitem__, _MEANT):
        yield row.name.replace("_", " "), f"{row.long_name} ({row.comment})" if row.comment else row.long_name
