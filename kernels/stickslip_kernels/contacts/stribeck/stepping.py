"""Stepping a law: by its Taylor series where that has a recurrence, else by the Runge-Kutta pair."""

from ...linking import by_law
from . import runge_kutta, taylor
from .laws import LAWS, RECURRENCES
from .table import Table


@by_law("sf:")
def try_step(law, s, rtol):
    """Try a step in every lane: its end, the work done, whether it is GOOD."""
    raise NotImplementedError


@by_law("sici:")
def begin_stepping(law, s, i, cells, c):
    """Choose the first step of a slip of cell c in lane i."""
    raise NotImplementedError


@by_law("sif:")
def restart(law, s, i, h):
    """Let the next step of lane i, after a change of mode, be of about the size h."""
    raise NotImplementedError


@by_law("sife:f")
def extreme_slope(law, s, i, h, at_end):
    """w' where w'' of lane i vanishes within h; at_end as for `roots.arrival`."""
    raise NotImplementedError


for _tag in (*map(type, LAWS.values()), Table):
    _stepper = taylor if _tag in RECURRENCES else runge_kutta
    for _function in (try_step, begin_stepping, restart, extreme_slope):
        _function.of(_tag)(getattr(_stepper, _function.__name__))
