"""Which combinations of quantities observations fix: directions along which the posterior is narrower than the prior.

Of two covariance matrices, prior P and posterior Q of the same numbers, the directions v with Q v = r P v are those
along which the data have narrowed what was known by sqrt(r), one after the other and independent of each other under
both; r is the same whatever units the numbers have. Products of powers show in the logarithms of the quantities
("stiffness/mass"), sums and differences in the quantities themselves ("mu_static - a1"): taken is what the data fix
most.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import NDArray

from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.suggest import listed

Floats = NDArray[np.float64]

FIXED, OPEN = 0.25, 0.75  # ratios of variances up to which a direction is fixed, and from which on nothing narrows it
_PART = 0.15  # of the largest part in a direction: what has less is left out of its name


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions, the one that is fixed best first.

    of_logs : whether they are products of powers. ratio : (n,) posterior over prior variance. weights : (n, quantities),
    exponents or coefficients, the largest part of each being 1. middle, before, after : (n,) posterior median, and
    standard deviations of the combination (of its logarithm).
    """

    names: Sequence[str]
    of_logs: bool
    ratio: Floats
    weights: Floats
    parts: Floats
    middle: Floats
    before: Floats
    after: Floats

    def sentences(self) -> list[str]:
        """`the data fix stiffness/mass to 3.2 % (before: 61 %)`, and what nothing fixes."""
        texts = []
        for i in np.flatnonzero(self.ratio < OPEN):
            verb = "fix" if self.ratio[i] < FIXED else "narrow"
            texts.append(f"the observations {verb} {self._name(i)} {self._spread(i)}")
        undecided = np.abs(self.parts[self.ratio >= OPEN]) >= _PART
        fixed = np.abs(self.parts[self.ratio < FIXED]) >= _PART
        names = [name for j, name in enumerate(self.names) if undecided[:, j].any() and not fixed[:, j].any()]
        alone = [name for j, name in enumerate(self.names) if undecided[:, j].any() and fixed[:, j].any()]
        if names:
            texts.append(f"nothing here fixes {listed(names, 'and')}")
        if alone:
            texts.append(f"nothing here fixes {listed(alone, 'and')} one by one")
        return texts

    def _name(self, i: int) -> str:
        """The combination in words."""
        weights = [(name, weight) for name, weight, part in zip(self.names, self.weights[i], self.parts[i], strict=True)
                   if abs(part) >= _PART]  # fmt: skip
        if not self.of_logs:
            return " ".join(
                f"{'- ' if weight < 0 else '+ '}{'' if abs(abs(weight) - 1) < 0.05 else f'{abs(weight):.2g} '}{name}"
                for name, weight in weights
            ).removeprefix("+ ")
        over = [_power(name, weight) for name, weight in weights if weight > 0]
        under = [_power(name, -weight) for name, weight in weights if weight < 0]
        return "/".join([" ".join(over) or "1", *under])

    def _spread(self, i: int) -> str:
        """`to 3.2 % (before: 61 %)`, or `to 0.1 +- 0.002 (before: +- 0.05)`."""
        if self.of_logs:
            return f"to {_percent(self.after[i])} (before: {_percent(self.before[i])})"
        named = [SEARCHABLE[name].units for name, part in zip(self.names, self.parts[i], strict=True) if abs(part) >= _PART]
        unit = units.spelled(named[0]) if len(set(named)) == 1 else ""
        return f"to {self.middle[i]:.4g} +- {self.after[i]:.2g} {unit}".rstrip() + f" (before: +- {self.before[i]:.2g})"


def _power(name: str, exponent: float) -> str:
    """`mass`, or `mass^0.5`."""
    return name if abs(exponent - 1.0) < 0.05 else f"{name}^{exponent:.2g}"


def _percent(spread: float) -> str:
    return f"{100.0 * np.expm1(spread):.2g} %" if spread < 1.0 else f"a factor of {np.exp(spread):.2g}"


def directions(prior: Mapping[str, Floats], posterior: Mapping[str, Floats]) -> Directions:
    """The directions of draws of quantities from prior and posterior."""
    plain = _of(prior, posterior, False)
    if not all((draws[name] > 0).all() for draws in (prior, posterior) for name in draws):
        return plain
    logs = _of({n: np.log(v) for n, v in prior.items()}, {n: np.log(v) for n, v in posterior.items()}, True)
    alike = len({SEARCHABLE[name].units for name in prior}) == 1 or plain.ratio[0] < 0.5 * logs.ratio[0]
    return plain if alike and plain.ratio[0] < logs.ratio[0] and _of_one_unit(plain) else logs


def _of_one_unit(plain: Directions) -> bool:
    """Whether the parts of the best direction have one unit, so that it is a sum that means something."""
    return len({SEARCHABLE[n].units for n, p in zip(plain.names, plain.parts[0], strict=True) if abs(p) >= _PART}) == 1


def _of(prior: Mapping[str, Floats], posterior: Mapping[str, Floats], of_logs: bool) -> Directions:
    names = list(prior)
    before, after = (np.array([draws[name] for name in names]) for draws in (prior, posterior))
    scale = before.std(1)
    p, q = (np.atleast_2d(np.cov(draws / scale[:, None])) for draws in (before, after))
    ratio, vectors = scipy.linalg.eigh(q, p)
    parts = vectors.T  # of numbers whose prior has a standard deviation of 1
    largest = parts[np.arange(len(names)), np.abs(parts).argmax(1)][:, None]
    parts = parts / largest
    weights = parts / scale
    weights = weights / weights[np.arange(len(names)), np.abs(parts).argmax(1)][:, None]
    return Directions(
        names, of_logs, np.maximum(ratio, 0.0), weights, parts, np.median(weights @ after, axis=1),
        (weights @ before).std(1), (weights @ after).std(1),
    )  # fmt: skip
