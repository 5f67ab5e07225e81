"""A block of cells: the unit of work. Arrays in, arrays out; serial, nogil, and it never raises."""

from . import contacts
from . import layout as at
from .intrinsics import lowest_bit, nonzero_bits, widest_vectors
from .jit import compiled
from .lanes import step_lanes
from .layout import WIDTH  # a literal, which `nonzero_bits` needs
from .machine import DONE


@compiled
def next_cell(m, i, first):
    """Start the next cell, from number `first` on, that does not finish at once in lane i: all cells are gone through
    twice, the second time for those that are later.

    Returns the number after it; the lane idles if there is none.
    """
    c, size = first, m.cells.shape[1]
    while c < 2 * size:
        number, again = c % size, c >= size
        c += 1
        if contacts.is_later(m, number) == again and contacts.begin_cell(m, i, number) != DONE:
            return c
    m.s[at.CELL + i] = -1.0
    return c


@compiled
def run_lanes(m, stop):
    """Integrate every cell of the block of a machine, unless `stop` is set meanwhile.

    WIDTH cells are in progress at a time; a finished lane takes the next cell of the queue. The results of a cell do
    not depend on its lane or its neighbours.
    """
    widest_vectors()
    following, busy = 0, 0  # cells started so far; bit i: lane i is in progress
    for i in range(at.WIDTH):
        following = next_cell(m, i, following)
        busy |= (m.s[at.CELL + i] >= 0.0) << i
    while stop[0] == 0 and busy != 0:
        step_lanes(m)
        flagged = nonzero_bits(m.s, at.FLAG, WIDTH) & busy
        while flagged != 0:
            i = lowest_bit(flagged)
            flagged &= flagged - 1
            if contacts.handle_event(m, i) == DONE:
                following = next_cell(m, i, following)
                busy ^= (m.s[at.CELL + i] < 0.0) << i


@compiled
def run(m, stop):
    """`run_lanes`, and once more by another contact for the cells that this one leaves."""
    run_lanes(m, stop)
    contacts.run_rest(m, stop)
