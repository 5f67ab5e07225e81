"""The peers, one file each, with one interface (`Peer`). `all_peers` lists them, those that cannot run included."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module, util

from problem import Answer, Cells

FILES = (
    "numba_scalar",
    "cpp_scalar",
    "heyoka_taylor",
    "numbalsoda_dop853",
    "diffrax_events",
    "scipy_events",
    "tanh_friction",
    "octave_article",
    "siconos",
)


@dataclass(frozen=True)
class Peer:
    """One way to solve P1.

    how : how it handles events. solve(cells, horizon, rtol) : computes on one thread.
    sample : cells to solve in one repetition, by rtol; a tolerance that is not listed is not run.
    solve_threads(cells, horizon, rtol, threads) : where it can use several.
    available : None, or why it cannot run here.
    """

    name: str
    how: str
    solve: Callable[[Cells, float, float], Answer]
    sample: Mapping[float, int]
    available: Callable[[], str | None] = lambda: None
    solve_threads: Callable[[Cells, float, float, int], Answer] | None = None
    repeats: int = 3


def needs(*modules: str) -> Callable[[], str | None]:
    """Available if all of these can be imported."""

    def reason() -> str | None:
        missing = [name for name in modules if util.find_spec(name) is None]
        return f"not installed: {', '.join(missing)}" if missing else None

    return reason


def all_peers() -> list[Peer]:
    return [peer for file in FILES for peer in import_module(f"peers.{file}").PEERS]
