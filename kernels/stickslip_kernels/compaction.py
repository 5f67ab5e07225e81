"""Few lanes at a time, brought together into lanes GATHERED and up: loops over them are short and full-width."""

import numpy as np

from . import layout as at
from .intrinsics import lowest_bit
from .jit import compiled

GROUP = 8


@compiled(inline=True)
def gather(s, lanes, rows):
    """Copy the step and these rows of the first GROUP of some lanes; the lanes left. Bit i of `lanes`: lane i."""
    for k in range(GROUP):
        if lanes == 0:
            break
        i, to = np.uint32(lowest_bit(lanes)), np.uint32(at.GATHERED + k)
        lanes &= lanes - 1
        for n in range(at.ORDER + 1):
            s[at.SERIES + n * at.WIDTH + to] = s[at.SERIES + n * at.WIDTH + i]
        for row in rows:
            s[row + to] = s[row + i]
    return lanes


@compiled(inline=True)
def scatter(s, lanes, rows):
    """Copy these rows back."""
    for k in range(GROUP):
        if lanes == 0:
            break
        i, of = np.uint32(lowest_bit(lanes)), np.uint32(at.GATHERED + k)
        lanes &= lanes - 1
        for row in rows:
            s[row + i] = s[row + of]
