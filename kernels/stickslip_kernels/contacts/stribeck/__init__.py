"""Friction of the slip speed alone, with stick: the contact that may age, and whose curve may have hysteresis.

modes.py                               the contract of contacts, and what begins and ends a mode
slip.py  stick.py  hysteresis.py       the modes; closed forms of stick, fall and hold
taylor.py  recurrences.py  runge_kutta.py    steps of slip, of two kinds
equations.py  friction.py  laws.py     the motion and the friction curve; the law of a table
"""
