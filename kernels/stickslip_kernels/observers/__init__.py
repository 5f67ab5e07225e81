"""Records of a motion: hooks that lanes and contacts call, compiled for the observer its tag names.

A contact ends modes; an observer looks at what happens on the way, and may declare a cell finished. A hook that an
observer does not have does nothing. In the frame of `layout.py`; `m` is the `Machine`, `i` the lane, `c` the cell.
"""

from .. import layout as at
from ..jit import by_type
from ..layout import DONE

hook = by_type(lambda m, *_: m.types[m.fields.index("observer")])
inline_hook = by_type(lambda m, *_: m.types[m.fields.index("observer")], inline=True)


# --- a cell begins and ends -----------------------------------------------------------------------------------------


@inline_hook
def begin_cell(m, i, c):
    """Cell c begins in lane i, its drive being open."""


@hook
def is_left(m, c):
    """Return whether cell c has not been computed, or not to its end by a contact that leaves it to another."""
    return True


@hook
def reject_cell(m, c, status):
    """Cell c cannot be computed."""


@inline_hook
def is_over(m, i):
    """Return whether the observer has seen enough; DECIDED_BY says why."""
    return False


@hook
def after_pause(m, i):
    """The cell has tried PAUSE steps, and slips."""


@hook
def status_out_of_steps(m, i):
    """Return how a cell ends whose step budget is spent."""
    return at.STEP_LIMIT


@hook
def finish(m, i, status, u, velocity):
    """The cell of lane i ends at u; DONE."""
    return DONE


# --- slip on the curve ----------------------------------------------------------------------------------------------


@hook
def before_commit(m):
    """Say of every lane, in row LOOK, whether to look at its step before it is committed."""


@inline_hook
def after_commit(m):
    """The good steps of the lanes that are not flagged have been committed."""


@inline_hook
def observe_slip_begin(m, i, u, w, fresh):
    """Slip begins at (u, w); not fresh: it only changes its direction."""


@inline_hook
def watch_from(m, i, u):
    """The lane has been put on the curve."""


@inline_hook
def observe_step(m, i, h, y, w, dw, jerk, work):
    """The first h of a step, before it is committed, with the state and the work at its end."""


@inline_hook
def observe_no_event(m, i):
    """The step was committed, and the mode goes on."""


@inline_hook
def observe_mode_end(m, i, u, kind):
    """The mode ends at the present state; True where the lane was put elsewhere instead, and its mode goes on."""
    return False


@inline_hook
def observe_standstill(m, i, dw):
    """w comes to zero, on the curve or on a line, w' being dw."""


# --- the other modes ------------------------------------------------------------------------------------------------


@hook
def observe_constant_speed(m, i, u, b, w, duration):
    """The next `duration`, at constant slip speed w from u on, the belt now at b."""


@inline_hook
def observe_line(m, i, line, u, w, dw, duration):
    """The next `duration` along a line, from (u, w) on, w' being dw."""


@inline_hook
def stays_on_line(m, i, line, u, w, dw, kind, t):
    """Return whether the fall that ends so after t stays where it ends; its cell is finished then."""
    return False


@inline_hook
def observe_trough(m, i, u, w):
    """A trough of w on the line."""


@inline_hook
def observe_load_that_stays(m, i, u, b):
    """Nothing in the present segment of the drive ends the stick phase."""


@inline_hook
def observe_contact(m, i, room, comes_back):
    """A slip has come to standstill, the load being `room` below static friction; comes_back: from a slip backwards."""


@hook
def observe_stick(m, i, start, u_start, load, after_slip, thrown):
    """A stick phase from `start` at u_start to now, with the load at its end; thrown: it did not stick at all."""


@inline_hook
def observe_breakaway(m, i, start, load, thrown):
    """The stick phase since `start` ends in a break-away under `load`."""


def register(tag, functions):
    """Let functions of the names of hooks serve as these for observers with this tag."""
    for name, stub in globals().items():
        if hasattr(stub, "of") and name in functions:
            stub.of(tag)(functions[name])
