"""Which combinations of quantities observations fix: directions along which the posterior is narrower than the prior.

Of two covariance matrices, prior P and posterior Q of the same numbers, the directions v with Q v = r P v are those
along which the data have narrowed what was known by sqrt(r), one after the other and independent of each other under
both; r is the same whatever units the numbers have. Products of powers show in logarithms ("stiffness/mass"): they are
taken of all quantities that are positive. Sums of quantities of one unit ("a1 + a3") are tried beside them, and stand
for the first direction where the observations fix one better than any product.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import NDArray

from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.suggest import listed

Floats = NDArray[np.float64]
Draws = Mapping[str, Floats]

FIXED, OPEN = 0.25, 0.75  # ratios of variances up to which a direction is fixed, and from which on nothing narrows it
_PART = 0.15  # of the largest part in a direction: what has less is left out of its name
_WHOLE = 0.05  # of an exponent or a coefficient: as near to 1 it is written as 1


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions of some numbers, the one that is fixed best first.

    ratio : (n,) posterior over prior variance. parts : (n, quantities), of numbers whose prior has the variance 1, the
    largest being 1; weights : the same of the numbers themselves. own : ratio of the variances of each number.
    middle, before, after : (n,) posterior median of the combinations, and their standard deviations. logs : names of
    those whose logarithms the numbers are.
    """

    names: Sequence[str]
    ratio: Floats
    parts: Floats
    weights: Floats
    own: Floats
    middle: Floats
    before: Floats
    after: Floats
    logs: Sequence[str] = ()

    def named(self, i: int) -> list[tuple[str, float]]:
        """The quantities that make up a direction, with their weights."""
        each = zip(self.names, self.weights[i], self.parts[i], strict=True)
        return [(name, weight) for name, weight, part in each if abs(part) >= _PART]

    def product(self, i: int) -> str:
        """`stiffness/mass`; what is not always positive is named beside."""
        named = self.named(i)
        powers = [(name, weight) for name, weight in named if name in self.logs]
        others = [name for name, _ in named if name not in self.logs]
        return listed([_powers(powers)] * bool(powers) + others, "with")

    def sentence(self, i: int) -> str:
        """`fix stiffness/mass to 3.2 % (before: 61 %)`; `tie a3 to stiffness^1.4 a2^0.4 within 9 % (before: 45 %)`."""
        named, is_fixed = self.named(i), self.ratio[i] < FIXED
        if any(name not in self.logs for name, _ in named):
            share = f"{100 * np.sqrt(self.ratio[i]):.2g} % of the scatter before"
            return f"{'fix' if is_fixed else 'narrow'} {self.product(i)} to {share}"
        spread = f"{_percent(self.after[i])} (before: {_percent(self.before[i])})"
        if all(abs(abs(weight) - 1.0) < _WHOLE for _, weight in named):
            return f"{'fix' if is_fixed else 'narrow'} {self.product(i)} to {spread}"
        first = max(named, key=lambda one: abs(self.parts[i][self.names.index(one[0])]))
        others = _powers([(name, -weight) for name, weight in named if name != first[0]])
        return f"{'tie' if is_fixed else 'loosely tie'} {first[0]} to {others} within {spread}"


def directions(prior: Draws, posterior: Draws) -> tuple[Directions, list[str]]:
    """The directions of draws of quantities from prior and posterior; and in words what is fixed and what not."""
    whole, total, texts = _of_logs(prior, posterior), _best_sum(prior, posterior), []
    shown, added = whole, ""
    if total is not None and total.ratio[0] < min(whole.ratio[0], FIXED):  # it takes the place of its largest part
        texts.append(f"the observations fix {_sum(total)} {_value(total)}")
        added, largest = f"({_sum(total)})", total.names[int(np.abs(total.parts[0]).argmax())]
        shown = _of_logs(*(
            {name: values for name, values in draws.items() if name != largest}
            | {added: total.weights[0] @ np.array([draws[name] for name in total.names])}
            for draws in (prior, posterior)
        ))  # fmt: skip
    for i in np.flatnonzero(shown.ratio < OPEN).tolist():
        if [name for name, _ in shown.named(i)] != [added]:
            texts.append(f"the observations {shown.sentence(i)}")
    single = [name for name, own in zip(whole.names, whole.own, strict=True) if own >= OPEN]
    joint = [whole.product(i) for i in np.flatnonzero(whole.ratio >= OPEN).tolist()
             if {name for name, _ in whole.named(i)}.isdisjoint(single)]  # fmt: skip
    if single or joint:
        texts.append(f"nothing here fixes {listed([*single, *joint])}")
    return whole, texts


def _of_logs(prior: Draws, posterior: Draws) -> Directions:
    """The directions of the logarithms of what is always positive, and of the rest as it is."""
    logs = [name for name in prior if (prior[name] > 0).all() and (posterior[name] > 0).all()]
    before, after = ({n: np.log(v) if n in logs else v for n, v in draws.items()} for draws in (prior, posterior))
    return _of(before, after, logs)


def _best_sum(prior: Draws, posterior: Draws) -> Directions | None:
    """The directions of those quantities of one unit of which a sum, or a difference, is fixed best."""
    groups: dict[str, list[str]] = {}
    for name in prior:
        groups.setdefault(SEARCHABLE[name].units, []).append(name)
    sums = [_of({name: prior[name] for name in names}, {name: posterior[name] for name in names})
            for names in groups.values() if len(names) > 1]  # fmt: skip
    return min(sums, key=lambda one: float(one.ratio[0]), default=None)


def _of(prior: Draws, posterior: Draws, logs: Sequence[str] = ()) -> Directions:
    names = list(prior)
    before, after = (np.array([draws[name] for name in names]) for draws in (prior, posterior))
    scale = before.std(1)
    p, q = (np.atleast_2d(np.cov(draws / scale[:, None])) for draws in (before, after))
    ratio, vectors = scipy.linalg.eigh(q, p)
    rows = np.arange(len(names))
    largest = np.abs(vectors.T).argmax(1)
    parts = vectors.T / vectors.T[rows, largest][:, None]
    weights = parts / scale
    weights = weights / weights[rows, largest][:, None]
    of_prior, of_posterior = weights @ before, weights @ after
    own = np.diag(q) / np.diag(p)
    return Directions(
        names, np.maximum(ratio, 0.0), parts, weights, own, np.median(of_posterior, axis=1), of_prior.std(1),
        of_posterior.std(1), logs,
    )  # fmt: skip


# --- words ------------------------------------------------------------------------------------------------------------


def _sum(of: Directions) -> str:
    """`mu_static - a1`."""
    terms = sorted(of.named(0), key=lambda one: one[1] < 0)
    text = " ".join(f"{'-' if weight < 0 else '+'} {_number(abs(weight))}{name}" for name, weight in terms)
    return text.removeprefix("+ ")


def _value(of: Directions) -> str:
    """`to 0.1 +- 0.002 (before: +- 0.05)`."""
    unit = units.spelled(SEARCHABLE[of.names[0]].units)
    return f"to {of.middle[0]:.4g} +- {of.after[0]:.2g} {unit}".rstrip() + f" (before: +- {of.before[0]:.2g})"


def _number(weight: float) -> str:
    return "" if abs(weight - 1.0) < _WHOLE else f"{weight:.2g} "


def _powers(each: Sequence[tuple[str, float]]) -> str:
    """`stiffness/mass`, `1/(mass^0.5 a1)`, of names with exponents."""
    over, under = (" ".join(_power(name, sign * exponent) for name, exponent in each if sign * exponent > 0)
                   for sign in (1, -1))  # fmt: skip
    return (over or "1") + (f"/({under})" if " " in under.replace(" + ", "+") else f"/{under}" if under else "")


def _power(name: str, exponent: float) -> str:
    """`mass`, or `mass^0.5`; exponents are not known to more digits."""
    digits = ".1f" if exponent > 0.1 else ".1g"
    return name if abs(exponent - 1.0) < _WHOLE else f"{name}^{exponent:{digits}}"


def _percent(spread: float) -> str:
    return f"{100.0 * np.expm1(spread):.2g} %" if spread < 0.65 else f"a factor of {np.exp(spread):.2g}"
