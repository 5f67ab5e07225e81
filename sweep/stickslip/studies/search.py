"""Changes of labels along lines and among the points of a lattice.

Along lines a scan, then every bracket of every line narrowed together. A line is a number, a place on it a float, a
label a small integer. Some places have no label that can be believed; they are `undecided`. A bracket is a pair of
decided places with different labels and only undecided ones known between.

Beside its label a place may have a number, the guide, whose zero is where the labels change. Where it has opposite
signs at the ends of a bracket, a secant of it says where to look next (`_guess`), else the middle is. Which
part is kept the labels alone decide; so a guide that contradicts them has the same sign at both ends from then on.

Where theory knows the guide of any place (`guide_at`), a border is where the guide vanishes if all places about it, up
to the tolerance from decided ones, turn out to be undecided; `labels_at` gives no guide where a label contradicts it.

The secant is that of the ITP method (I. F. D. Oliveira, R. H. C. Takahashi, An enhancement of the bisection method
average performance preserving minmax optimality, ACM TOMS 47 (2021) 5): moved a little to the middle, and never so far
from it that halving would have been done a round earlier.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Labels = NDArray[np.int8]
Flags = NDArray[np.bool_]
_PROBES = np.arange(1, 8) / 8  # of a gap between undecided places, before all of it counts as undecided
_MORE_ROUNDS = 1  # than halving takes at most: n_0 of the article
_MOVED = 0.2  # kappa_1, over the first width; kappa_2 is 2


def _first_reach(width: Floats, narrow: Floats) -> Floats:
    """How wide a bracket may be after the first round so that halving still ends in time; it halves with each round.

    width, narrow : of the bracket, and at which the search ends.
    """
    narrow = np.maximum(narrow, np.finfo(np.float64).tiny)
    return np.asarray(narrow * np.exp2(np.ceil(np.log2(np.maximum(width / narrow, 1.0))) + _MORE_ROUNDS - 1))


def _guess(low: Floats, high: Floats, at_low: Floats, at_high: Floats, first: Floats, reach: Floats) -> Floats:
    """The place to look at inside each bracket.

    at_low, at_high : the number at the ends, of opposite sign. first : width of the bracket at the start.
    """
    width, middle = high - low, low + (high - low) / 2
    secant = low + width * (at_low / (at_low - at_high))
    to_middle = middle - secant
    moved = np.minimum(_MOVED / first * width**2, np.abs(to_middle))
    off = secant + np.copysign(moved, to_middle) - middle
    allowed = np.maximum(reach - width / 2, 0.0)
    return np.asarray(middle + np.clip(off, -allowed, allowed))


class Looked(NamedTuple):
    """Knowledge of places: labels, whether to believe them, and the guide (NaN: none there)."""

    labels: Labels
    decided: Flags
    guide: Floats | None = None


LabelsAt = Callable[[Integers, Floats], Looked]
GuideAt = Callable[[Integers, Floats], Floats]
# gap_low, gap_high: the outermost undecided places between low and high; NaN where there are none. at_low, at_high: the
# guide. first, change, reach: width of the bracket and change of the guide when it began to lead, 0 before, and what
# `_first_reach` says of it. guided: whether it led to the end. probed: whether all places between those undecided ones
# are undecided, as far as a few of them say. place: of the border.
BRACKET = np.dtype(
    [("line", np.int64), ("low", np.float64), ("high", np.float64), ("below", np.int8), ("above", np.int8),
     ("gap_low", np.float64), ("gap_high", np.float64), ("at_low", np.float64), ("at_high", np.float64),
     ("first", np.float64), ("change", np.float64), ("reach", np.float64), ("guided", np.bool_),
     ("probed", np.bool_), ("place", np.float64)]
)  # fmt: skip
Brackets = NDArray[Any]  # of dtype BRACKET
_NEAR_ZERO = 1e-3  # of the larger end of a range: places closer to 0 have no scale of their own
_FAR = 10.0  # ends further apart than this factor are scanned, and halved, by ratio
_OF_GUIDE = 1e-12  # how closely its zero is known, over a bracket
_JUMP = 0.01  # share of its change that the guide may keep at the end; one that keeps more jumps and has no zero


@dataclass(frozen=True)
class Scan:
    """Places of lines to look at first: `points` from `low` to `high`, both included; spacing "linear" or "log"."""

    low: float
    high: float
    points: int
    spacing: str

    @classmethod
    def over(cls, low: float, high: float, points: int) -> Scan:
        """Log spacing where both ends are above 0 and a factor of 10 or more apart, else linear."""
        return cls(low, high, points, "log" if low > 0 and high >= _FAR * low else "linear")

    @cached_property
    def places(self) -> Floats:
        """The places, ascending."""
        spread = np.geomspace if self.spacing == "log" else np.linspace
        return spread(self.low, self.high, self.points)

    def width(self, tolerance: float, low: Floats, high: Floats) -> Floats:
        """The width that brackets may keep: of the place; next to 0, to a thousandth of a range that holds it."""
        ends = [np.abs(low), np.abs(high)]
        least = _NEAR_ZERO * max(abs(self.low), abs(self.high)) if self.low <= 0 <= self.high else 0.0
        return np.asarray(tolerance * np.maximum(np.maximum(*ends), least))


def search_lines(
    lines: int, scan: Scan, tolerance: float, labels_at: LabelsAt, guide_at: GuideAt | None = None
) -> tuple[Brackets, Integers]:
    """The brackets of all lines, by line and place, and how many places of the scan were undecided, per line.

    labels_at : what is known of places on lines; called with all of them at once, once for the scan and once per round.
    Brackets are no wider than `tolerance` of the place (`Scan.width`), unless places inside could not be decided. What
    changes and changes back between two places of the scan is missed. guide_at : the guide of any place, by theory.
    """
    places = scan.places
    line, place = np.repeat(np.arange(lines), places.size), np.tile(places, lines)
    looked = labels_at(line, place)
    undecided = np.count_nonzero(~looked.decided.reshape(lines, places.size), axis=1)
    brackets = _narrowed(_brackets(line, place, looked), scan, tolerance, labels_at)
    brackets = _without_slivers(brackets, scan, tolerance)
    brackets["place"] = brackets["low"] + (brackets["high"] - brackets["low"]) / 2
    if guide_at is not None:
        _place_by_guide(brackets, guide_at)
    return brackets, undecided


def _brackets(line: Integers, place: Floats, looked: Looked) -> Brackets:
    """The brackets of places in order of line and place."""
    known, labels = np.flatnonzero(looked.decided), looked.labels
    low, high = known[:-1], known[1:]
    changes = (line[low] == line[high]) & (labels[low] != labels[high])
    low, high = low[changes], high[changes]
    brackets = np.zeros(low.size, BRACKET)
    brackets["line"], brackets["low"], brackets["high"] = line[low], place[low], place[high]
    brackets["below"], brackets["above"] = labels[low], labels[high]
    apart = high > low + 1
    brackets["gap_low"] = np.where(apart, place[np.where(apart, low + 1, 0)], np.nan)
    brackets["gap_high"] = np.where(apart, place[np.where(apart, high - 1, 0)], np.nan)
    guide = np.full(place.size, np.nan) if looked.guide is None else looked.guide
    brackets["at_low"], brackets["at_high"] = guide[low], guide[high]
    return brackets


def _narrowed(brackets: Brackets, scan: Scan, tolerance: float, labels_at: LabelsAt) -> Brackets:
    """Narrow all brackets until they are narrow enough; a third label on the way splits one into two.

    A bracket with undecided places is narrowed from both sides towards them; then it is looked at between them, once.
    """
    done = [brackets[:0]]
    while brackets.size:
        width, gap = scan.width(tolerance, brackets["low"], brackets["high"]), ~np.isnan(brackets["gap_low"])
        left = _middle(brackets["low"], np.where(gap, brackets["gap_low"], brackets["high"]), width)
        right = np.where(gap, _middle(brackets["gap_high"], brackets["high"], width), np.nan)
        _follow_guide(brackets, left, right, width)
        narrow = np.isnan(left) & np.isnan(right)
        between = narrow & (brackets["gap_high"] - brackets["gap_low"] > width) & ~brackets["probed"]
        done.append(brackets[narrow & ~between])
        brackets["probed"][between] = True
        start, end = brackets["gap_low"][between], brackets["gap_high"][between]
        probed = _looked_at(brackets[between], start[:, np.newaxis] + np.outer(end - start, _PROBES), labels_at)
        brackets = _looked_at(brackets[~narrow], np.stack([left, right], axis=1)[~narrow], labels_at)
        brackets = np.concatenate([brackets, probed])
    return np.concatenate(done)


def _middle(low: Floats, high: Floats, width: Floats) -> Floats:
    """A place between two, by ratio where they are far apart; NaN where they are near enough or neighbours."""
    with np.errstate(invalid="ignore"):
        middle = np.where(_far_apart(low, high), np.sqrt(low) * np.sqrt(high), low + (high - low) / 2)
    return np.where((high - low > width) & (low < middle) & (middle < high), middle, np.nan)


def _far_apart(low: Floats, high: Floats) -> Flags:
    return np.asarray((low > 0) & (high >= _FAR * low))


def _follow_guide(brackets: Brackets, left: Floats, right: Floats, width: Floats) -> None:
    """Let the guide, where there is one, say which places inside each bracket are looked at next, in place of middles.

    It may have led right to the border, where places tend to be undecided: then both sides of these are next.
    left, right : the middles, NaN where it is narrow enough; changed, as the notes on the guide in brackets are.
    """
    low, high, at_low, at_high = (brackets[name] for name in ("low", "high", "at_low", "at_high"))
    leads = ((at_low < 0) != (at_high < 0)) & np.isfinite(at_low) & np.isfinite(at_high)
    begins = leads & (brackets["first"] == 0) & ~_far_apart(low, high)
    for name, values in {"first": high - low, "change": np.abs(at_high - at_low)}.items():
        brackets[name][begins] = values[begins]
    brackets["reach"][begins] = _first_reach(high[begins] - low[begins], width[begins])
    leads &= brackets["first"] > 0
    brackets["guided"] = leads & (np.abs(at_high - at_low) <= _JUMP * brackets["change"])
    gap = ~np.isnan(brackets["gap_low"])
    at = np.flatnonzero(leads & gap)
    aside = np.maximum(width[at] / 4, brackets["gap_high"][at] - brackets["gap_low"][at])
    left[at] = np.maximum(left[at], brackets["gap_low"][at] - aside)  # NaN stays NaN
    right[at] = np.minimum(right[at], brackets["gap_high"][at] + aside)
    at = np.flatnonzero(leads & ~gap & ~np.isnan(left))
    there = _guess(low[at], high[at], at_low[at], at_high[at], brackets["first"][at], brackets["reach"][at])
    there = np.clip(there, low[at] + width[at] / 2, high[at] - width[at] / 2)  # so that both ends close in
    left[at] = np.where((low[at] < there) & (there < high[at]), there, left[at])
    brackets["reach"] /= 2


def _looked_at(brackets: Brackets, new: Floats, labels_at: LabelsAt) -> Brackets:
    """The brackets within these once the places `new` (n, k; NaN: none) have labels."""
    if not brackets.size:
        return brackets
    known = np.stack([brackets[name] for name in ("low", "high", "gap_low", "gap_high")], axis=1)
    places = np.concatenate([known, new], axis=1)
    labels, decided = np.zeros(places.shape, np.int8), np.zeros(places.shape, np.bool_)
    guide = np.full(places.shape, np.nan)
    labels[:, 0], labels[:, 1] = brackets["below"], brackets["above"]
    guide[:, 0], guide[:, 1] = brackets["at_low"], brackets["at_high"]
    decided[:, :2] = True
    bracket = np.broadcast_to(np.arange(brackets.size)[:, np.newaxis], places.shape)
    there = ~np.isnan(places)
    unknown = there & (np.arange(places.shape[1]) >= known.shape[1])
    looked = labels_at(brackets["line"][bracket[unknown]], places[unknown])
    labels[unknown], decided[unknown] = looked.labels, looked.decided
    if looked.guide is not None:
        guide[unknown] = looked.guide
    order = np.lexsort((places[there], bracket[there]))
    inner = _brackets(
        bracket[there][order], places[there][order],
        Looked(labels[there][order], decided[there][order], guide[there][order]),
    )  # fmt: skip
    outer = brackets[inner["line"]]
    for name in ("line", "first", "change", "reach"):
        inner[name] = outer[name]
    inner["probed"] = outer["probed"] & (inner["low"] == outer["low"]) & (inner["high"] == outer["high"])
    return inner


def _place_by_guide(brackets: Brackets, guide_at: GuideAt) -> None:
    """Put borders within brackets with undecided places where the guide vanishes, if it does there; changes these."""
    at = np.flatnonzero(~np.isnan(brackets["gap_low"]) & (brackets["at_low"] * brackets["at_high"] < 0))
    line, low, high = brackets["line"][at], brackets["low"][at], brackets["high"][at]

    def sign_at(which: Integers, share: Floats) -> Looked:
        guide = guide_at(line[which], low[which] + share * (high - low)[which])
        return Looked((guide > 0).astype(np.int8), np.isfinite(guide), guide)

    zeros, _ = search_lines(at.size, Scan(0.0, 1.0, 2, "linear"), _OF_GUIDE, sign_at)
    which = zeros["line"]
    brackets["place"][at[which]] = low[which] + zeros["place"] * (high - low)[which]
    brackets["guided"][at[which]] = True


def _without_slivers(brackets: Brackets, scan: Scan, tolerance: float) -> Brackets:
    """Brackets in order; two that enclose a label on less than the tolerance are one, unless nothing changes then."""
    brackets = brackets[np.lexsort((brackets["low"], brackets["line"]))]
    while brackets.size > 1:
        first, second = brackets[:-1], brackets[1:]
        near = (first["line"] == second["line"]) & (first["below"] != second["above"])
        near &= second["low"] - first["high"] <= scan.width(tolerance, first["low"], first["high"])
        near[1:] &= ~near[:-1]
        if not near.any():
            break
        first["high"][near], first["above"][near] = second["high"][near], second["above"][near]
        first["guided"][near] &= second["guided"][near]
        brackets = np.delete(brackets, np.flatnonzero(near) + 1)
    return brackets


# --- among the points of a lattice ------------------------------------------------------------------------------------

_NOTHING = (127, -128)  # smallest and largest label of no point at all
_OPEN = (-128, 126)  # of a point that differs from itself


class Boxes:
    """Boxes of points, split where the labels of their points differ.

    A window of points is covered by boxes of 2^depth + 1 points a side, which share their faces. Each is known by its
    corners and, unless without `centres`, its centre. A box in whose closed hull two computed points differ is split
    into boxes of half the side, known in the same way; those of 2 points a side have nothing inside. So a point that is
    computed for one box is looked at by every box it touches, whatever their sizes: a border that leaves a box through
    a face splits its neighbour too, and is followed to its end. Points with labels below 0 are undecided: they differ
    from everything, themselves included, so that all around them is computed.

    shape : points along each side, at least 2 each. Integers count points, the last dimension running fastest.
    """

    def __init__(self, shape: tuple[int, ...], depth: int, centres: bool = True) -> None:
        self.shape, self.depth, self._centres = shape, depth, centres
        side = 1 << depth
        lengths = tuple(-(-(n - 1) // side) * side for n in shape)  # the last boxes may end outside the window
        padded = tuple(n + 1 for n in lengths)
        self.known = np.zeros(shape, bool)
        self._labels = np.zeros(shape, np.int8)
        self._low, self._high = np.full(padded, _NOTHING[0], np.int8), np.full(padded, _NOTHING[1], np.int8)
        self._split = [np.zeros(tuple(n >> level for n in lengths), bool) for level in range(depth + 1)]
        self._begun = False

    def learn(self, places: Integers, labels: Labels) -> None:
        """Take in the labels of points."""
        at = np.unravel_index(places, self.shape)
        self.known[at], self._labels[at] = True, labels
        self._low[at] = np.where(labels < 0, _OPEN[0], labels)
        self._high[at] = np.where(labels < 0, _OPEN[1], labels)

    def wanted(self) -> Integers:
        """The points that must be computed next, none once all boxes are uniform: at first those of the largest boxes,
        then those of boxes that are split."""
        places = [np.zeros(0, np.int64)]
        if not self._begun:
            self._begun, every = True, np.argwhere(np.ones(self._split[-1].shape, bool))
            places.append(self._places(every << self.depth, self.depth))
        for level, (low, high) in zip(range(1, self.depth + 1), self._hulls(), strict=True):
            split = low < high
            fresh = np.argwhere(split & ~self._split[level])
            self._split[level] |= split
            for half in product((0, 1 << (level - 1)), repeat=len(self.shape)):
                places.append(self._places((fresh << level) + np.array(half), level - 1))
        return np.unique(np.concatenate(places))

    def inferred(self) -> Labels:
        """The labels of all points: where none is computed, that of the box, which is the same for all its points."""
        label = np.zeros(self._split[-1].shape, np.int8)
        for low, _ in reversed(list(self._hulls())):
            label = np.where(low == _NOTHING[0], _twice(label, low.shape), low)
        if self.depth:
            label = _twice(label, tuple(n - 1 for n in self._low.shape))
            label = np.pad(label, [(0, 1)] * label.ndim, "edge")[tuple(slice(n) for n in self.shape)]
        return np.where(self.known, self._labels, label) if self.depth else self._labels

    def _hulls(self) -> list[tuple[Labels, Labels]]:
        """Smallest and largest label of the computed points of each box, faces included; for levels 1 to depth."""
        low, high, hulls = self._low, self._high, []
        for level in range(self.depth + 1):
            for axis in range(low.ndim):
                low, high = (of(*_neighbours(ends, axis, 2 if level else 1))
                             for ends, of in ((low, np.minimum), (high, np.maximum)))  # fmt: skip
            hulls.append((low, high))
        return hulls[1:]

    def _places(self, first: NDArray[Any], level: int) -> Integers:
        """Corners and centres, where not yet known, of the boxes of a level with these first corners: (boxes, dims)."""
        side = 1 << level
        points = [first + np.array(corner) for corner in product((0, side), repeat=len(self.shape))]
        if level and self._centres:
            points.append(first + side // 2)
        inside = np.minimum(np.concatenate(points), np.array(self.shape) - 1)
        places = np.unique(np.ravel_multi_index(tuple(inside.T), self.shape))
        missing: Integers = places[~self.known.ravel()[places]]
        return missing


def _neighbours(values: Labels, axis: int, step: int) -> tuple[Labels, Labels]:
    """Neighbours along an axis: of every two points (step 1), or of every pair (step 2)."""
    before, last = [slice(None)] * axis, -1 if step == 1 else None
    return values[(*before, slice(0, last, step))], values[(*before, slice(1, None, step))]


def _twice(values: Labels, shape: tuple[int, ...]) -> Labels:
    """Each value twice along every axis, if it is not of that shape already."""
    if values.shape == shape:
        return values.copy()
    for axis in range(values.ndim):
        values = np.repeat(values, 2, axis)
    return values
