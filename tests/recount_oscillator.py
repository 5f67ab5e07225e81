"""Count the crossings and the regimes of tests/data/oscillator.csv again, by SciPy, one event at a time.

    python tests/recount_oscillator.py [--write]

says which rows of the table count otherwise, and with --write puts the counts into its columns `crossings` and
`regime`; the others stay as they are, to the letter. The table was made with a settling band of 1e-4 mu_start; here
it is 1e-4 of the distance from steady sliding at which the slip begins, and the side on which it begins counts as the
first. Two minutes.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from helpers.scipy_oscillator import Oscillator

TABLE = Path(__file__).parent / "data" / "oscillator.csv"
BAND_SHARE = 1e-4  # of the distance from steady sliding at which the slip begins
SETTLED = 0.05  # distance from steady sliding, in bands, from which on nothing crosses the band any more
STANDSTILL = 1e-4  # speed and acceleration, in bands, that are the end of an approach to somewhere else


@dataclass
class Counted(Oscillator):
    """The motion from the first break-away to the next stick phase, or until it has settled."""

    sides: int = 0  # extrema of xi outside the band, those in a row on one side counting once
    side: float = 0.0
    band: float = np.nan
    sticks: bool = False

    def stick(self):
        if self.band > 0.0:
            self.sticks, self.horizon = True, self.time
            return None
        after = super().stick()
        self.centre = self.stribeck(self.belt)
        self.band = BAND_SHARE * np.hypot(self.xi - self.centre, self.eta)
        self.note_side()
        return after

    def note_side(self):
        distance = self.xi - self.centre
        if abs(distance) > self.band and np.sign(distance) != self.side:
            self.side, self.sides = np.sign(distance), self.sides + 1

    def slip(self, law, *guards):
        """Stop at every extremum of xi, and for good where nothing is left to count."""

        def unsettled(xi, eta):
            return np.hypot(xi - self.centre, eta) - SETTLED * self.band

        def moving(xi, eta):
            return np.hypot(eta, self.change_of_speed(xi, eta, law)) - STANDSTILL * self.band

        extrema = (lambda xi, eta: eta, lambda xi, eta: -eta)
        while True:
            end = super().slip(law, *guards, *extrema, unsettled, moving)
            if end is None or end < len(guards):
                return end
            if end >= len(guards) + len(extrema):
                self.horizon = self.time
                return None
            self.note_side()

    @property
    def crossings(self):
        return max(self.sides - 1, 0)

    @property
    def regime(self):
        if self.sticks:
            return "stick_slip"
        return "damped" if self.crossings >= 2 else "creep"


def count(row):
    """(crossings, regime) of a row of the table."""
    m, k, load = (float(row[name]) for name in ("mass", "stiffness", "normal_load"))
    speed = load / np.sqrt(k * m)
    motion = Counted(
        belt=float(row["belt_speed"]) / speed,
        horizon=1e5,
        curve=(float(row["a1"]), float(row["a2"]) * speed, float(row["a3"]), float(row["a4"]) / speed),
        gamma=float(row["damping"]) / np.sqrt(k * m),
        mu_stop=float(row["mu_stop"]),
    )
    return motion.crossings, motion.regime


def main():
    """The command line."""
    with TABLE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    for number, row in enumerate(rows):
        crossings, regime = count(row)
        if (str(crossings), regime) != (row["crossings"], row["regime"]):
            print(f"row {number}: {row['crossings']} {row['regime']} -> {crossings} {regime}", flush=True)
        row["crossings"], row["regime"] = crossings, regime
    if "--write" in sys.argv[1:]:
        with TABLE.open("w", newline="") as file:
            writer = csv.DictWriter(file, rows[0], lineterminator="\r\n")
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
