"""What a cell sounds like, and how loud.

    from stickslip import sound

    sound.of(cell)            a Sound, which plays itself in a notebook; .wav() are the bytes of a file
    sound.a_weighting(100)    how much fainter the ear hears a tone of 100 Hz than one of 1 kHz

Of the files, `series.py` has the acceleration as a Fourier series, `cycles.py` the states that cycles start from,
`making.py` the sound of a cell, `sounds.py` what is done with one.
"""

from stickslip.sound.making import RATE, of
from stickslip.sound.sounds import FULL_SCALE, Sound
from stickslip.sound.weighting import a_weighting

__all__ = ["FULL_SCALE", "RATE", "Sound", "a_weighting", "of"]
