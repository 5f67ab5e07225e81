"""Goals: the region of a plane in which cells are quiet over whole ranges, and what each would need to lie there.

`section.py` says what is asked, `verdict.py` whether a place of the plane is quiet; borders are those of the engine,
with verdicts in place of regimes, the ways to them those of margins; `plots.py` draws them.
"""
