"""GNU Octave's ode23s straight through the discontinuity, as the article did: no events, sgn() in the right-hand side.

Another process; it states its own seconds, start-up excluded. ode23s runs at its default tolerance (1e-3), as a
reader of the article would run it; its steps shrink to nothing at every stick, so it gets one cell and the first
tenth of the horizon, the rate being scaled. "Re-stick" is where |v_rel| is next below 1e-3. ode45 with events sticks
by hand.
"""

from __future__ import annotations

import shutil
import subprocess
from functools import partial

import numpy as np

from peers import Peer
from problem import A1, A2, A3, A4, Answer, Cells

SHARE = 0.1  # of the horizon

THROUGH = """
k = {k:.17g}; b = {belt:.17g}; last = {last:.17g};
mu = @(w) {A1} + {A2} * w + {A3} * exp(-w / {A4});
f = @(t, s) [s(2); sign(b - s(2)) * mu(abs(b - s(2))) - k * s(1)];
opt = odeset("RelTol", {rtol:g}, "AbsTol", {atol:g});
tic; [t, s] = ode23s(f, [0 last], [0; b], opt); seconds = toc;
u = b - s(:, 2); slip = find(u > 0.05 * b + 3e-3, 1); stick = slip - 1 + find(u(slip:end) < 1e-3, 1);
if isempty(stick), first = [NaN NaN]; else first = [t(stick) s(stick, 1)]; end
printf("%.17g %.17g %.17g %.17g %.17g\\n", seconds, first, s(end, 1), s(end, 2));
"""

WITH_EVENTS = """
1;
function [value, terminal, direction] = rest(t, s)
  value = s(2); terminal = 1; direction = -1;
end
k = {k:.17g}; b = {belt:.17g}; last = {last:.17g}; start = {A1} + {A3};
f = @(t, s) [k * (b - s(2)); s(1) - {A2} * s(2) - {A3} * (exp(-s(2) / {A4}) - 1)];
opt = odeset("RelTol", {rtol:g}, "AbsTol", {atol:g}, "Events", @rest);
tic; t = 0; x = 0; first = [NaN NaN]; g = {A3} / {A4} - {A2};
while true
  release = t + (start / k - x) / b;
  if release >= last, v = b; x = x + b * (last - t); break; end
  d = 1e-4 / max(g, sqrt(k)); w = k * b * d^2 * (1 / 2 + g * d / 6);
  [tt, s, te] = ode45(f, [release + d, last], [k * b * d; w], opt);
  t = tt(end); x = (s(end, 1) + start) / k; v = b - s(end, 2);
  if isempty(te) || t >= last, break; end
  if isnan(first(1)), first = [t x]; end
end
seconds = toc;
printf("%.17g %.17g %.17g %.17g %.17g\\n", seconds, first, x, v);
"""


def available() -> str | None:
    return None if shutil.which("octave-cli") else "not installed (Debian package octave)"


def solve(cells: Cells, horizon: float, rtol: float, script: str, share: float, loose: float | None = None) -> Answer:
    rows, rtol = [], loose or rtol
    for k, belt in zip(cells.k.tolist(), cells.belt.tolist(), strict=True):
        text = script.format(
            k=k, belt=belt, last=share * horizon, rtol=rtol, atol=1e-3 * rtol, A1=A1, A2=A2, A3=A3, A4=A4
        )
        run = subprocess.run(
            ["octave-cli", "--no-gui", "--norc", "--quiet", "--eval", text], capture_output=True, text=True, timeout=120
        )
        rows.append([float(word) for word in run.stdout.split()[-5:]])
    seconds, *found = np.array(rows).T
    if share < 1.0:  # not the end of the others
        found[2][:], found[3][:] = np.nan, np.nan
    return Answer(*found, seconds=float(seconds.sum()) / share)


PEERS = [
    Peer(
        "GNU Octave ode45, events",
        "events",
        partial(solve, script=WITH_EVENTS, share=1.0),
        {1e-6: 2},
        available,
        repeats=1,
    ),
    Peer(
        "GNU Octave ode23s at 1e-3, as the article",
        "none: through the jump",
        partial(solve, script=THROUGH, share=SHARE, loose=1e-3),
        {1e-6: 1},
        available,
        repeats=1,
    ),
]
