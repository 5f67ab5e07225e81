"""The configuration that `stickslip init` writes: every section with a comment, ready to run and to change."""

from __future__ import annotations

from string import Template

from stickslip.vocabulary.settings import EXECUTION, SOLVER

_TEXT = Template(
    """\
# A map of the regimes of a friction oscillator: a mass on a moving belt, held by a spring and a damper.
#
#   stickslip validate FILE    checks this file without computing anything
#   stickslip run FILE         computes the map and plots it
#
# A quantity is a number in SI (kg, N, m, s) or a text with a unit: 0.002 and "2 mm/s" are the same speed.
# Every quantity is given either in its section (the same in all cells) or under axes (varied), never in both.

title: My first map

# What is the same in all cells ----------------------------------------------------------------------------------------

system:
  mass: 1 kg
  normal_load: 10 N
  damping: 5 N s/m      # 0 unless given

# The friction coefficient over the slip speed w is a1 + a2 w + a3 exp(-w/a4).
friction:
  a1: 0.2               # constant part
  a2: 0.02              # s/m, slope of the rising branch at high speed
  a3: 0.1               # how far friction drops after break-away; 0 or less gives a curve that only rises
  a4: 20 mm/s           # the speed scale of the drop
# Instead of a1, a2 and a3 you may give what people measure; a4 stays:
#   mu_start: 0.3       # friction coefficient at break-away
#   mu_reversal: 0.25   # at the minimum of the curve
#   v_reversal: 0.1     # m/s, speed at the minimum
# And, if friction ends at another value than it starts from (hysteresis):
#   mu_stop: 0.25       # friction coefficient as the slip speed falls to zero; none unless given

# The initial state. These are the defaults:
start:
  displacement: 0
  velocity: sticking    # or a velocity: the motion that is reached may depend on it

# What varies ----------------------------------------------------------------------------------------------------------
# One dimension of the map per entry; in a plot of two, the first is the vertical axis.

axes:
  stiffness: {start: 0.1 N/mm, stop: 100 N/mm, num: 60, spacing: log}
  belt_speed: {start: 1 mm/s, stop: 200 mm/s, num: 80}   # spacing: linear unless given
# A list of values works too, and so do quantities that vary together, point by point:
#   damping: [0, 1, 2]
#   lubricant: {zip: {a1: [0.2, 0.1], a3: [0.1, 0.02]}, labels: [dry, oil]}

# How it is computed; these are the defaults --------------------------------------------------------------------------

solver:
  rtol: $rtol            # relative tolerance of a step, $least to $most
  max_steps: $max_steps     # step budget of a cell; a cell that needs more is "unresolved"
  early_stop: true      # stop once the regime is decided; false continues to the horizon
  # horizon: 10 min     # longest time simulated per cell; no limit unless given
execution:
  threads: auto
  block: $block           # cells computed together
  # dask: tcp://head:8786   # a Dask cluster computes; local: processes of this machine

# Where the result goes; relative names start at the folder the command is run in --------------------------------------

output:
  file: my_map.nc       # .nc (netCDF) or .zarr
  plot: my_map.png      # .png, .svg or .pdf
"""
)


def _plain(value: float | None) -> str:
    return f"{value:.9g}".replace("e-0", "e-")


TEMPLATE = _TEXT.substitute(
    rtol=_plain(SOLVER["rtol"].default),
    least=_plain(SOLVER["rtol"].at_least),
    most=_plain(SOLVER["rtol"].at_most),
    max_steps=_plain(SOLVER["max_steps"].default),
    block=_plain(EXECUTION["block"].default),
)
