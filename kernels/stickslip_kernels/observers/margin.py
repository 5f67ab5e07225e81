"""By how much the slip after break-away misses standstill: a number whose zero is where stick-slip ends by grazing.

Row W_LEAST holds it for the slip under way. Above 0 it is the least trough of w so far; a slip that settles has the
belt speed b as its last one. Where w comes to zero at a rate v = -w', and the contact sticks, it is -v^2/(2 b): as w''
is b where w and w' vanish, that is the depth of the trough that w would have had under friction that stays as it is at
standstill, and b t^2/2 if t is the length of the stick phase until the load has risen to that friction. So value and
slope are continuous at zero, on the curve and on the line of a hysteretic one, and whatever static friction adds.

A standstill that does not stick, grazing or in passing to a slip the other way and back, makes it 0: below 0 means a
stick phase. A slip the other way that ends in a stick phase keeps what the standstill before it gave.

A verdict hangs on more than the last slip: on every trough and every standstill on the way, on whether static friction
holds the mass there, and on which side of the settling band an extremum lies. Row CLOSEST has the smallest of these
margins over the amplitude and over what errors have grown by, to be compared with the tolerance.

In the plane an area grows by the divergence of the flow, minus the drag gamma + mu', and what two motions side by side
are apart, over their speed f = (q, w'), q = w - b, as the area over f^2. So the logarithm of that, GAIN, changes by

    -drag (q^2 - w'^2)/(q^2 + w'^2),      drag = -(q + w'')/w',

and is at least 0, since errors are made anew at any time. It is large beside unstable cycles, and where slip rides on
the falling branch.
"""

from math import inf, isnan, nan

from .. import layout as at
from ..exponential import exp
from ..intrinsics import select, widest_vectors
from ..jit import compiled

FLAT = 1e-18  # (w'/q)^2 below which rounding hides the drag


@compiled(inline=True)
def begin_margin(s, i, fresh):
    """A slip begins at standstill or, not fresh, goes on from there, forwards (b > 0) or the other way."""
    if fresh:
        s[at.W_LEAST + i], s[at.SLIP_LEAST + i], s[at.GAIN + i], s[at.GAIN_TOP + i] = inf, inf, 0.0, 0.0
    elif s[at.B + i] > 0.0:
        s[at.W_LEAST + i] = 0.0


@compiled(inline=True)
def note_trough(s, i, w):
    """A trough of w, or the value that w settles at; what rounding leaves below zero has been found to be above."""
    s[at.W_LEAST + i] = min(s[at.W_LEAST + i], max(w, 0.0))


@compiled(inline=True)
def note_closeness(s, i, margin):
    """Return what becomes of the motion was decided by this share of its amplitude."""
    s[at.CLOSEST + i] = min(s[at.CLOSEST + i], abs(margin))


@compiled(inline=True)
def note_closest_trough(s, i):
    """The least trough of the slip under way decides, too; half of what errors grow by in a dip comes after it."""
    if s[at.W_LEAST + i] > 0.0:
        note_closeness(s, i, s[at.W_LEAST + i] / s[at.AMPLITUDE + i] * exp(-0.5 * s[at.GAIN_TOP + i]))


@compiled(inline=True)
def note_gain(s, i, h, w, dw, jerk):
    """Return the growth of errors of lane i in a step over h, by the motion at its end; a turning point has none."""
    q, squared = w - s[at.B + i], dw * dw
    square = q * q
    growth = h * (q + jerk) * (square - squared) / (dw * (square + squared))
    gain = max(s[at.GAIN + i] + select(squared > FLAT * square, growth, 0.0), 0.0)
    s[at.GAIN + i] = gain
    s[at.GAIN_TOP + i] = max(s[at.GAIN_TOP + i], gain)


@compiled
def grow_errors(s):
    """The same of all lanes whose steps have been committed."""
    widest_vectors()
    for i in range(at.WIDTH):
        committed = (s[at.FLAG + i] == at.NOTHING_MET) & (s[at.GOOD + i] > 0.0)
        note_gain(s, i, select(committed, s[at.TAKEN + i], 0.0), s[at.W + i], s[at.DW + i], s[at.JERK + i])


@compiled(inline=True)
def note_standstill(s, i, dw):
    """w comes to zero at the rate dw."""
    if s[at.B + i] > 0.0:
        s[at.W_LEAST + i] = -0.5 * dw * dw / s[at.B + i]


@compiled(inline=True)
def margin_of_slip(s, i):
    """The margin of the slip under way, or of the one before the present break-away; NaN if it was not released."""
    least = min(s[at.W_LEAST + i], s[at.SLIP_LEAST + i])
    return nan if isnan(s[at.CYCLE_START + i]) or least == inf else least
