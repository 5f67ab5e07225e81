"""Siconos: friction as a set-valued law, event-capturing time-stepping (Moreau-Jean, theta 1/2) at a fixed step.

No event is located: at every step a one-step problem finds either a friction impulse within its bounds or a non-zero
slip speed, so that stick and slip need no case distinction. The model as its users would build it: a
LagrangianLinearTIDS for the mass and the spring, a Relay for the friction, driven from Python. Coordinate z = x -
v_belt t, in which the belt is at rest and the far end of the spring moves (the force). A Relay has dry friction of a
constant level only, so its bounds are set before every step to mu(w) at the last slip speed (semi-explicit); they are
impulses, that is, times the step.

Errors are of the first order in the step: an event is known to a step, and mu(w) is that of the step before. The step
is all there is to choose, rtol is not used. Another process, as Debian's package is for the system's Python; it states
its own CPU seconds, start-up excluded. A step costs the same everywhere, so the finer row does a share of the horizon,
its rate being scaled.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from functools import cache, partial

import numpy as np

from peers import Peer
from problem import A1, A2, A3, A4, Answer, Cells

SCRIPT = """
import json, sys, time
from math import exp
import siconos.kernel as sk
from siconos.numerics import SICONOS_RELAY_PGS  # the fastest of four by a little: one unknown

def trajectory(k, belt, last, h, A1, A2, A3, A4):
    mass = sk.LagrangianLinearTIDS([0.0], [0.0], [[1.0]])
    mass.setKPtr([[k]])
    mass.setFExtPtr([0.0])
    friction = sk.RelayNSL(1, -1.0, 1.0)
    # y = z - 1: Siconos takes y for a gap, and leaves out a law whose gap is open
    contact = sk.Interaction(friction, sk.LagrangianLinearTIR([[1.0]], [-1.0]))
    model = sk.NonSmoothDynamicalSystem(0.0, last)
    model.insertDynamicalSystem(mass)
    model.link(contact, mass)
    clock, scheme, problem = sk.TimeDiscretisation(0.0, h), sk.MoreauJeanOSI(0.5), sk.Relay(SICONOS_RELAY_PGS)
    stepping = sk.TimeStepping(model, clock, scheme, problem)
    z, velocity, force = mass.q(), mass.velocity(), mass.fExt()  # views
    steps, slipped, first = round(last / h), False, None
    for n in range(steps):
        w = abs(velocity[0])
        bound = h * (A1 + A2 * w + A3 * exp(-w / A4))
        friction.setLb(-bound)
        friction.setUb(bound)
        force[0] = -k * belt * (n + 0.5) * h
        stepping.computeOneStep()
        if first is None:
            slips = velocity[0] < -1e-9
            if slipped and not slips:
                first = (n + 1) * h, z[0] + belt * (n + 1) * h
            slipped = slips
        stepping.nextStep()
    return *(first or (float("nan"),) * 2), z[0] + belt * steps * h, belt + velocity[0]

task = json.loads(sys.argv[1])
start = time.process_time()
found = [trajectory(*cell, *task["fixed"]) for cell in task["cells"]]
print(json.dumps([time.process_time() - start, found]))
"""


@cache
def interpreter() -> str | None:
    """A Python that has Siconos. -I: none of our PYTHONPATH, and this file cannot be taken for the package."""
    for python in dict.fromkeys((shutil.which("python3"), "/usr/bin/python3")):
        if python and shutil.which(python):
            check = subprocess.run([python, "-I", "-c", "import siconos.kernel"], capture_output=True, timeout=60)
            if check.returncode == 0:
                return python
    return None


def available() -> str | None:
    return None if interpreter() else "not installed (Debian package python3-siconos)"


def solve(cells: Cells, horizon: float, rtol: float, step: float, share: float) -> Answer:
    pairs = list(zip(cells.k.tolist(), cells.belt.tolist(), strict=True))
    task = json.dumps({"cells": pairs, "fixed": [share * horizon, step, A1, A2, A3, A4]})
    run = subprocess.run(
        [interpreter(), "-I", "-c", SCRIPT, task], capture_output=True, text=True, timeout=300, check=True
    )
    seconds, rows = json.loads(run.stdout.splitlines()[-1])
    found = np.array(rows).T
    if share < 1.0:  # not the end of the others
        found[2:] = np.nan
    return Answer(*found, seconds=seconds / share)


PEERS = [
    Peer(
        f"Siconos, Moreau-Jean, step {step:g}",
        "time-stepping",
        partial(solve, step=step, share=share),
        {1e-6: sample},
        available,
        repeats=1,
    )
    for step, share, sample in ((1e-3, 1.0, 4), (1e-4, 0.5, 1))
]
