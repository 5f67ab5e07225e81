"""From what was measured back to what causes it: an extension of `stickslip`.

extension.py   what the engine is told              api.py         the Python calls
command.py     `explain` and `next`                 section.py     what a file says of explanations
likelihood.py  how well cells explain               study.py       draws, by sequential Monte Carlo
summary.py     these reduced to numbers             proposals.py   the next measurement
goal.py        `goal`: section, plane, verdicts     goal_study.py  its regions, and the ways there
plots.py       plots of all of it
"""
