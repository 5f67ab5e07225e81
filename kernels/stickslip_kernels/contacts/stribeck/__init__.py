"""Friction of the slip speed alone, with stick: the contact that may age, and whose curve may have hysteresis.

    slip.py  stick.py  hysteresis.py      the modes
    stepping.py  taylor.py  runge_kutta.py  recurrences.py  resolvable.py    steps of slip, of two kinds
    equations.py  extreme_slope.py  friction.py  laws/    the motion and the friction curve
    table.py                               the law of measured points, and of shapes that people register
    hysteresis_line.py  first_passage.py  ageing.py       closed forms of fall, hold and stick

`modes.py` fulfils the contract of contacts, and says what begins and ends a mode.
"""
