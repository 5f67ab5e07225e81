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
margins over the amplitude, to be compared with the error of the integration.
"""

from math import inf, isnan, nan

from .. import layout as at
from ..jit import compiled


@compiled(inline=True)
def begin_margin(s, i, fresh):
    """A slip begins at standstill or, not fresh, goes on from there, forwards (b > 0) or the other way."""
    if fresh:
        s[at.W_LEAST + i] = inf
    elif s[at.B + i] > 0.0:
        s[at.W_LEAST + i] = 0.0


@compiled(inline=True)
def note_trough(s, i, w):
    """A trough of w, or the value that w settles at; what rounding leaves below zero has been found to be above."""
    s[at.W_LEAST + i] = min(s[at.W_LEAST + i], max(w, 0.0))


@compiled(inline=True)
def note_closeness(s, i, margin):
    """What becomes of the motion was decided by this share of its amplitude."""
    s[at.CLOSEST + i] = min(s[at.CLOSEST + i], abs(margin))


@compiled(inline=True)
def note_closest_trough(s, i):
    """The least trough of the slip under way decides, too."""
    if s[at.W_LEAST + i] > 0.0:
        note_closeness(s, i, s[at.W_LEAST + i] / s[at.AMPLITUDE + i])


@compiled(inline=True)
def note_standstill(s, i, dw):
    """w comes to zero at the rate dw."""
    if s[at.B + i] > 0.0:
        s[at.W_LEAST + i] = -0.5 * dw * dw / s[at.B + i]


@compiled(inline=True)
def margin_of_slip(s, i):
    """The margin of the slip under way, or of the one before the present break-away; NaN if it was not released."""
    least = s[at.W_LEAST + i]
    return nan if isnan(s[at.CYCLE_START + i]) or least == inf else least
