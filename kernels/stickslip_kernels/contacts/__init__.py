"""Contacts: what friction does to the mass, a file or a folder each, behind the contract below.

Lanes (`lanes.py`) hand out cells, commit steps, and look for what happens inside them; observers
(`observers/`) record it. Neither knows what friction is. The type of the tag `m.contact` chooses the functions that
both call, when the kernels are compiled, so that the choice costs nothing at run time.

A contact keeps, in the frame of `layout.py`, with y' = B - w:

    rows Y, W, DW, JERK     y, the slip speed w, w' and w'' of each lane
    row WEAK                a number of its own, committed with them: an inner state, say
    rows LEVEL, SIDE, TURN  the slip speed at which its present mode ends, if any (-inf and -1: none)

and for a trial step Y_NEW ... WEAK_NEW, TAKEN, WORK, GOOD, and SERIES, of flagged lanes at least: the powers of w over
the step, from which all else about it follows (`dense.py`). Rows of `cells` that are not of the oscillator are its
parameters, in a meaning of its own.

The file of a contact has a tag class, its `TAG`, `LAWS` (tags of its laws of friction by name), `LINKED` (functions of
a law that it calls, `linking.py`), `REGIMES` (the observer of its maps), and ends in `register`, which takes its
functions by their names. A contact without modes has `begin_cell` and `handle_event` from `smooth.py`.
"""

from importlib import import_module
from math import nan

from .. import layout as at
from ..dense import horner, load_and_speed, speed
from ..jit import by_type
from ..objects import CONTACTS, contact_of
from ..roots import FOR_A_VALUE, crossing

_of_machine = by_type(lambda m, *_: m.types[m.fields.index("contact")])
_inline = by_type(lambda m, *_: m.types[m.fields.index("contact")], inline=True)


@_of_machine
def begin_cell(m, i, c):
    """Put cell c into lane i; DONE if it is finished at once, else RUNNING."""
    raise NotImplementedError


@_inline
def is_later(m, c):
    """Return whether cell c is begun after those that are not later, so that lanes at work step alike."""
    return False


@_inline
def try_step(m):
    """Try a step in every lane: its end, the work done, whether it is GOOD."""
    raise NotImplementedError


@_inline
def expand(m):
    """Rows SERIES of the lanes with a FLAG, where `try_step` leaves them out."""


@_inline
def handle_event(m, i):
    """Look at lane i, whose step was flagged: show it to the observer and commit it; RUNNING, or DONE."""
    raise NotImplementedError


@by_type(lambda contact, *_: contact, inline=True)
def steady_friction(contact, law, cells, c, w):
    """Friction coefficient of cell c in steady sliding at slip speed w >= 0."""
    raise NotImplementedError


@_of_machine
def run_rest(m, stop):
    """Run the cells that this contact leaves, by the one that takes them; `observers.is_left` tells which."""


@by_type(lambda contact, *_: contact, inline=True)
def smallest_step(contact):
    """The step below which a cell cannot be integrated."""
    return at.SMALLEST_STEP


@_inline
def deviation(m, i):
    """How far lane i is from steady sliding, its inner state included: small motions do as linear theory says."""
    return 0.0


@_inline
def inner_load(m, i, t, y, w):
    """What the inner state adds to the load of steady sliding at t after the start of the step, where w and y are
    these; NaN where a lane cannot be put elsewhere."""
    return nan


@_inline
def put(m, i, y, w, load):
    """Put lane i at y and w, its inner state adding `load`."""


@_inline
def loops_are_cheap(m, i):
    """Return whether lane i had better follow most of its loops than pass over them."""
    return False


@_inline
def friction(m, i, t, w):
    """Friction coefficient at t after the start of the step of lane i, the slip speed being w: what is left of the
    load."""
    y, dw = load_and_speed(m.s, i, t)[0], horner(m.s, i, t)[1]
    return y + m.s[at.OFFSET + i] - m.s[at.G + i] * w - dw


@_inline
def extreme_slope(m, i, h, at_end):
    """w' where w'' vanishes within h; at_end as for `roots.arrival`."""
    return speed(m.s, i, crossing(m.s, i, 2, 0.0, h, at_end, FOR_A_VALUE))[1]


def register(tag, functions):
    """Let functions of the names above serve contacts with this tag."""
    for name, stub in globals().items():
        if hasattr(stub, "of") and name in functions:
            stub.of(tag)(functions[name])


def files():
    """The files of contacts by their names."""
    return {name.partition(".")[0]: import_module(f".{name}", __name__) for name in CONTACTS}


def of_law(law):
    """The file of the contact that has a law of this name (`objects.CONTACTS`), and the law's tag."""
    file = files()[contact_of(law)]
    return file, file.LAWS[law]
