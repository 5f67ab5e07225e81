"""The bundle that every function of the kernels gets: arrays, and tags that choose what is compiled."""

from typing import Any, NamedTuple

RUNNING, DONE = False, True  # what functions of a machine return: the lane goes on, or its cell is finished


class Machine(NamedTuple):
    """A contact under a law, on a drive, seen by an observer. The types of these four are the specialisation.

    contact : tag of a contact, see `contacts`. law : tag of its law of friction.
    drive : `drive.SteadyBelt` or `drive.Segments`.
    observer : of the files in `observers`, with what it fills.
    s : the lanes, rows of `layout.py`. cells : float64 (CELL_ROWS, n), kernel units, C-contiguous.
    rtol : tolerance of a step. max_steps : trial steps a cell may take.
    """

    contact: Any
    law: Any
    drive: Any
    observer: Any
    s: Any
    cells: Any
    rtol: float
    max_steps: float
