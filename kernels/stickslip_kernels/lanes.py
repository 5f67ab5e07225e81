"""The hot loops: one trial step of WIDTH trajectories at once.

Branch-free loops over the lanes of one flat buffer, which LLVM turns into full-width vector code (a test looks at the
assembly). A step is tried as the contact does it (`contacts/`); accepting, rejecting and choosing the next step are
part of the loops. Whatever is rare only raises the lane's FLAG; the scalar code of the contact then looks at that lane
before the step is committed.
"""

from . import contacts, observers
from . import layout as at
from .arithmetic import lowest_bit, nonzero_bits, select, widest_vectors
from .jit import compiled
from .layout import DONE, WIDTH
from .roots import find_crossings, grazes, may_turn, reaches


@compiled(inline=True)
def step_lanes(m):
    """Try one step in every lane; commit it where it is good and nothing happened, else leave it as a candidate.

    Idle lanes compute numbers nobody reads.
    """
    contacts.try_step(m)
    observers.before_commit(m)
    watch_and_commit(m.s, contacts.smallest_step(m.contact))
    observers.after_commit(m)
    if nonzero_bits(m.s, at.FLAG, WIDTH) != 0:
        contacts.expand(m)
    find_crossings(m.s)


@compiled
def watch_and_commit(s, smallest_step):
    """Raise flags where something happened inside the step; commit the other good steps."""
    widest_vectors()
    for i in range(at.WIDTH):
        w, dw, h = s[at.W_NEW + i], s[at.DW_NEW + i], s[at.TAKEN + i]
        reached = reaches(s, i, w)
        look = reached | grazes(s, i, h, w, dw) | ((s[at.TURN + i] > 0.0) & may_turn(s, i, h, dw))
        look = look | (s[at.LOOK + i] > 0.0) | (s[at.TAU + i] + h >= s[at.TAU_END + i])
        good = s[at.GOOD + i] > 0.0
        tried = s[at.TRIED + i] + 1.0
        halted = (tried >= s[at.PAUSE + i]) | (not (s[at.STEP + i] >= smallest_step))
        commit = good & (not look) & (not halted)
        s[at.FLAG + i] = select(halted, at.HALTED, select(look & good, at.LOOK_FIRST, at.NOTHING_MET))
        s[at.TRIED + i] = tried
        s[at.CROSSES + i] = select(look & good & (reached | (s[at.TURNING + i] > 0.0)), 1.0, 0.0)
        s[at.AFTER + at.Y + i] = select(commit, s[at.Y_NEW + i], s[at.Y + i])
        s[at.AFTER + at.W + i] = select(commit, w, s[at.W + i])
        s[at.AFTER + at.DW + i] = select(commit, dw, s[at.DW + i])
        s[at.AFTER + at.JERK + i] = select(commit, s[at.JERK_NEW + i], s[at.JERK + i])
        s[at.AFTER + at.WEAK + i] = select(commit, s[at.WEAK_NEW + i], s[at.WEAK + i])
        s[at.AFTER + at.SIDE_LAST + i] = select(commit, s[at.SIDE_LAST_NEW + i], s[at.SIDE_LAST + i])
        s[at.AFTER + at.CROSSED + i] = select(commit, s[at.CROSSED_NEW + i], s[at.CROSSED + i])
        s[at.AFTER + at.LOOP_COUNT + i] = select(commit, s[at.LOOP_COUNT_NEW + i], s[at.LOOP_COUNT + i])
        s[at.AFTER + at.ERROR_LOG + i] = select(commit, s[at.ERROR_LOG_NEW + i], s[at.ERROR_LOG + i])
        s[at.AFTER + at.TAU + i] = s[at.TAU + i] + select(commit, h, 0.0)
        s[at.AFTER + at.HEAT + i] = s[at.HEAT + i] + select(commit, s[at.WORK + i], 0.0)
    # The state is copied back from rows of its own: storing a select where it was loaded from becomes a masked store,
    # at 40 cycles each on some processors (Zen 3).
    for i in range(at.STATE_NUMBERS):
        s[i] = s[at.AFTER + i]


# --- a block of cells, the unit of work: arrays in, arrays out; serial, nogil, and it never raises --------------------


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
