"""What a law is stepped by: the file that its own file names as STEPPER."""

from . import runge_kutta, taylor
from .laws import STEPPERS, by_law

FILES = {"taylor": taylor, "runge_kutta": runge_kutta}


@by_law
def try_step(law, s, rtol):
    """Try a step in every lane: its end, the work done, whether it is GOOD."""
    raise NotImplementedError


@by_law
def begin_stepping(law, s, i, cells, c):
    """Choose the first step of a slip of cell c in lane i."""
    raise NotImplementedError


@by_law
def restart(law, s, i, h):
    """Let the next step of lane i, after a change of mode, be of about the size h."""
    raise NotImplementedError


@by_law
def extreme_slope(law, s, i, h, at_end):
    """w' where w'' of lane i vanishes within h; at_end as for `roots.arrival`."""
    raise NotImplementedError


for _tag, _stepper in STEPPERS.items():
    for _function in (try_step, begin_stepping, restart, extreme_slope):
        _function.of(_tag)(getattr(FILES[_stepper], _function.__name__))
