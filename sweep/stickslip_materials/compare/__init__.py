"""Materials compared: friction curves fitted to measured points, ranked by the belt speed above which each is quiet.

`stick_slip_end.py` finds that speed for many curves at once; `compare.py` puts fits, intervals and ranks together;
`table.py` says it in words, `page.py` is the report.
"""

from stickslip_materials.compare.compare import compare

__all__ = ["compare"]
