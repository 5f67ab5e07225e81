"""Materials compared: friction curves fitted to measured points, ranked by the belt speed above which each is quiet.

`stick_slip_end.py` finds that speed for many curves at once; `compare.py` puts fits, intervals and ranks together;
`result.py` is the dataset and what commands ask of it, `table.py` says it to people, on screen and as a page.
"""
