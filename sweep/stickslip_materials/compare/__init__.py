"""Materials compared: friction curves fitted to measured points, ranked by the belt speed above which each is quiet.

`stick_slip_end.py` finds that speed for many curves at once; `compare.py` puts fits, intervals and ranks together;
`table.py` says it to people, `page.py` is the report, and `result.py` what commands ask of a result.
"""
