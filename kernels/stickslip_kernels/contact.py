"""The bundle that every function of the contact machine gets: arrays, and tags that choose what is compiled."""

from typing import Any, NamedTuple

RUNNING, DONE = False, True  # what functions of the machine return: the lane goes on slipping, or its cell is finished


class Contact(NamedTuple):
    """One machine: a law on a drive, seen by an observer. The types of these three are the specialisation.

    law : tag of a friction law, see `laws`. drive : `drive.SteadyBelt` or `drive.Segments`.
    observer : `observers.regime.Regime` or `observers.signals.Signals`, with what it fills.
    s : the lanes, rows of `layout.py`. cells : float64 (CELL_ROWS, n), kernel units, C-contiguous.
    rtol : tolerance of a step. max_steps : trial steps a cell may take.
    """

    law: Any
    drive: Any
    observer: Any
    s: Any
    cells: Any
    rtol: float
    max_steps: float
