"""When w passes a level inside the step, in many lanes at once: as `roots.arrival`, but branch-free.

The levels are those that flagged lanes will ask for: where the mode ends, else the speed of the belt, where u turns.
Two passes over the series after a first guess are enough for nearly every step; where they are not, CROSSES becomes 0
and the scalar search does it.
"""

from . import layout as at
from .compaction import GROUP, gather, scatter
from .dense import horner
from .events import reaches
from .intrinsics import nonzero_bits, select, widest_vectors
from .jit import compiled
from .layout import WIDTH  # a literal, which `nonzero_bits` needs
from .roots import integrals_after, reverted

NEEDED = (
    at.W, at.W_NEW, at.DW, at.DW_NEW, at.TAKEN, at.B, at.ALPHA, at.LEVEL, at.SIDE, at.CROSSES,
)  # fmt: skip
FOUND = (at.CROSSES, at.CROSS_LEVEL, at.CROSS_TIME, at.CROSS_RISE, at.CROSS_FALLEN)


@compiled
def find_crossings(s):
    """Rows CROSS_TIME, CROSS_RISE and CROSS_FALLEN of the lanes with CROSSES."""
    lanes = nonzero_bits(s, at.CROSSES, WIDTH)
    while lanes != 0:
        left = gather(s, lanes, NEEDED)
        guess_crossings(s)
        close_in(s)
        integrate_to_crossings(s)
        scatter(s, lanes, FOUND)
        lanes = left


@compiled(inline=True)
def guess_crossings(s):
    """Hermite's inverse cubic between the ends of the step, else Newton's method from its end; then one by Halley."""
    widest_vectors()
    for i in range(at.GATHERED, at.GATHERED + GROUP):
        w0, w1, slope0, slope1, end = s[at.W + i], s[at.W_NEW + i], s[at.DW + i], s[at.DW_NEW + i], s[at.TAKEN + i]
        reached = reaches(s, i, w1)
        level = select(reached, s[at.LEVEL + i], s[at.B + i])
        change = w1 - w0
        per_all = 1.0 / (change * slope0 * slope1)
        per_slope0, per_slope1 = change * slope1 * per_all, change * slope0 * per_all
        part = (level - w0) * slope0 * slope1 * per_all
        rest = 1.0 - part
        bow = rest * per_slope0 - part * per_slope1
        cubic = part * part * (3.0 - 2.0 * part) * end + change * part * rest * bow
        within = (slope0 * slope1 > 0.0) & (cubic > 0.0) & (cubic <= end)
        t = select(within, cubic, end + (level - w1) * per_slope1)
        w, dw, a = horner(s, i, t)[:3]
        off = level - w
        s[at.CROSS_LEVEL + i], s[at.GUESS + i] = level, t + off * dw / (dw * dw + off * a)


@compiled(inline=True)
def close_in(s):
    """The series about the guess, and how far the crossing is from there."""
    widest_vectors()
    for i in range(at.GATHERED, at.GATHERED + GROUP):
        t, end, level = s[at.GUESS + i], s[at.TAKEN + i], s[at.CROSS_LEVEL + i]
        w, dw, a, b = horner(s, i, t)[:4]
        d, settled = reverted(level, w, dw, a, b, end)
        towards = (s[at.W_NEW + i] - s[at.W + i]) * dw > 0.0
        found = settled & (t > 0.0) & (t + d > 0.0) & (t + d <= end) & towards
        s[at.CROSS_TIME + i] = t + d
        s[at.CROSSES + i] = min(s[at.CROSSES + i], select(found, 1.0, 0.0))
        s[at.GUESS_W + i], s[at.GUESS_DW + i], s[at.GUESS_A + i], s[at.GUESS_B + i] = w, dw, a, b


@compiled(inline=True)
def integrate_to_crossings(s):
    """Return what y rises by, and the double integral of w, up to the crossing."""
    widest_vectors()
    for i in range(at.GATHERED, at.GATHERED + GROUP):
        t, end = s[at.GUESS + i], s[at.CROSS_TIME + i]
        once, twice = horner(s, i, t)[4:6]
        w, dw, a, b = s[at.GUESS_W + i], s[at.GUESS_DW + i], s[at.GUESS_A + i], s[at.GUESS_B + i]
        once, twice = integrals_after(end - t, once, twice, w, dw, a, b)
        s[at.CROSS_RISE + i] = end * (s[at.B + i] + 0.5 * end * s[at.ALPHA + i]) - once
        s[at.CROSS_FALLEN + i] = twice
