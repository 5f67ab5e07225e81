"""From what was measured back to what causes it: an extension of `stickslip`.

`stickslip explain` draws oscillators and laws of friction that explain observations, `stickslip next` says which
measurement would tell most, `stickslip goal` which friction a part should have to be quiet.

    extension.py   what the engine is told          api.py        the Python calls
    command.py     `explain` and `next`             goal/         `goal`: section, verdicts, study, plot
    section.py     the section `explain`            draws.py      `uncertain: {explained: ...}`
    likelihood.py  how well cells explain           smc.py        draws of any posterior, by sequential Monte Carlo
    study.py       both together                    summary.py    draws reduced to numbers, and their tables
    directions.py  what observations fix together   proposals.py  the next measurement
    plots.py       prior beside posterior           document.py   `observed` and `prior`, the short form of a file

It leans on the engine alone.
"""
