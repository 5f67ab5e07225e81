"""Options of an integration, and its results."""

from __future__ import annotations

import json
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, isinf
from numbers import Integral
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from stickslip.vocabulary import models
from stickslip.vocabulary.models import Model, OnBristles, own_law
from stickslip.vocabulary.own_laws import is_law
from stickslip.vocabulary.quantities import EXECUTION, SOLVER, VARIABLES, VARIABLES_OF
from stickslip_kernels import layout

Results = dict[str, NDArray[Any]]
Progress = Callable[[float, int], None]
StopFlag = NDArray[np.int64]
_CHECKED = (SOLVER["rtol"], SOLVER["max_steps"], EXECUTION["block"], EXECUTION["threads"])


def stop_flag() -> StopFlag:
    """A flag that the kernels poll; once it is 1 they return within milliseconds."""
    return np.zeros(1, np.int64)


class SolverKeywords(TypedDict, total=False):
    """Keywords of calls that say how to integrate; what is None or left out is as in `options`, or the default."""

    options: Options | None
    law: str | None
    rtol: float | None
    horizon: float | None
    max_steps: int | None
    threads: int | None


@dataclass(frozen=True)
class Options:
    """Options of an integration, and of how work is spread. Defaults and limits are those of the configuration.

    law : one of `vocabulary.models.LAWS`, or one of one's own. horizon : s; inf for none. threads : None for one per
    processor. block : most cells computed together. variables : the only ones that are kept, `regime` among them; None
    for all.
    """

    law: str = "stribeck"
    rtol: float = 1e-6
    horizon: float = inf
    max_steps: int = 100_000
    early_stop: bool = True
    threads: int | None = None
    block: int = 4096
    variables: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        if self.law not in models.LAWS and not is_law(self.law):
            remedy = models.law_remedy(self.law)
            names = ", ".join((*models.LAWS, *models.own_names()))
            raise ValueError(f"law: got {self.law!r}, expected {names}{f'; {remedy}' if remedy else ''}")
        if own := own_law(self.law):  # which a process that gets these options may not know
            object.__setattr__(self, "law", own if self.law == own else OnBristles(own))
        if not self.horizon > 0:
            raise ValueError(f"horizon: got {self.horizon!r}, expected a time > 0 (s)")
        if not self.early_stop and isinf(self.horizon):
            raise ValueError("early_stop=False integrates every cell to the horizon, so it needs a finite horizon (s)")
        for row in _CHECKED:
            value = getattr(self, row.name)
            if value is None and row.word:
                continue
            if row.whole and not isinstance(value, int | Integral) or not row.allows(value):
                raise ValueError(f"{row.name}: got {value!r}, expected {row.expected.removesuffix(row.otherwise)}")

    @classmethod
    def of(cls, keywords: SolverKeywords, otherwise: Options | None = None) -> Options:
        """From the keywords of a call, which stop a cell once its regime is known.

        otherwise : the options where there are none among the keywords. Raises TypeError for other names, ValueError.
        """
        if unknown := set(keywords) - SolverKeywords.__annotations__.keys():
            known = ", ".join(SolverKeywords.__annotations__)
            raise TypeError(f"got an unexpected keyword argument {min(unknown)!r}; known are {known}")
        given: dict[str, Any] = {name: value for name, value in keywords.items() if value is not None}
        base = given.pop("options", None) or otherwise or cls()
        kinds = {"rtol": float, "horizon": float, "max_steps": int}
        given = {name: kinds.get(name, lambda value: value)(value) for name, value in given.items()}
        return replace(base, early_stop=True, **given)

    def keeping(self, variables: Sequence[str]) -> Options:
        """The same for these variables and the regime alone. Raises ValueError for names of none."""
        known = columns(replace(self, variables=None))
        if isinstance(variables, str) or (unknown := [name for name in variables if name not in known]):
            got = repr(variables) if isinstance(variables, str) else ", ".join(map(repr, unknown))
            raise ValueError(f"variables: got {got}, expected a list of names out of {', '.join(known)}")
        return replace(self, variables=tuple(dict.fromkeys(("regime", *variables))))

    def for_contact(self, names: Container[Any]) -> Options:
        """The same for cells with quantities of these names, which may make the contact one of bristles."""
        law = models.law_of_contact(self.law, names)
        return self if law == self.law else replace(self, law=law)

    @property
    def until(self) -> int:
        """How far a cell is followed, a code of `layout.py`: no further than what is kept of it needs."""
        if not self.early_stop:
            return layout.UNTIL_HORIZON
        alone = self.variables is not None and all(VARIABLES[name].when == "regime" for name in self.variables)
        return layout.UNTIL_REGIME if alone else layout.UNTIL_METRICS

    @property
    def friction(self) -> dict[str, Any]:
        """The friction law as plain data, with the points that a table consists of."""
        points = getattr(own_law(self.law), "points", None)
        return {"law": str(self.law)} | ({"table": points()} if points else {})

    def described(self, **sections: Any) -> str:
        """The friction law and the solver, as text for the provenance of cells that are no configuration.

        sections : further sections of what was asked.
        """
        return json.dumps(json.loads(_shared(self)) | sections, default=float) if sections else _shared(self)


@lru_cache(maxsize=16)
def _shared(options: Options) -> str:
    solver = {
        "rtol": options.rtol, "early_stop": options.early_stop, "max_steps": options.max_steps,
        "horizon": None if isinf(options.horizon) else options.horizon,
    }  # fmt: skip
    return json.dumps({"friction": options.friction, "solver": solver})


@dataclass(frozen=True)
class Computed:
    """Results by names of `VARIABLES`, flat, in SI; `done` cells of them, fewer than all after an interruption."""

    results: Results
    done: int

    @property
    def complete(self) -> bool:
        """Return whether every cell was computed."""
        return self.done == len(self.results["regime"])


def columns(options: Options) -> Mapping[str, np.dtype[Any]]:
    """Names and types of what `compute` gives, in its order."""
    return _columns(models.model_of(options.law), options.early_stop, options.variables)


@lru_cache
def _columns(model: Model, early_stop: bool, chosen: tuple[str, ...] | None) -> Mapping[str, np.dtype[Any]]:
    whole = {"regime": np.int8, "status": np.int8, "steps": np.int32}
    names = [v.name for v in VARIABLES_OF[model].values() if v.when != "full" or not early_stop]
    return {name: np.dtype(whole.get(name, np.float64)) for name in names if chosen is None or name in chosen}


def joined(parts: Sequence[Results]) -> Results:
    """Columns of several ranges, end to end."""
    names = dict.fromkeys(name for part in parts for name in part)
    return {name: np.concatenate([part[name] for part in parts if name in part]) for name in names}
