"""The sound of a cell, and its level.

    from stickslip import sound

    sound.of(cell)            a Sound, which plays itself in a notebook; .wav() are the bytes of a file
    sound.of_record(a, rate)  that of a record, measured or simulated
    sound.save_all(folder, sounds)   named ones, a WAV file each
    sound.levels(cells)       how loud cells, maps, or all cells of a configuration are, in dB
    sound.summary(levels)     how many cells have a level, and its range
    sound.a_weighting(100)    how much fainter the ear hears a tone of 100 Hz than one of 1 kHz

Of the files, `series.py` has the acceleration as a Fourier series, `cycles.py` the states that cycles start from,
`making.py` the sound of a cell or a record, `sounds.py` what is done with one, `loudness.py` the levels.
"""

from stickslip_sound.loudness import a_weighting, levels, summary
from stickslip_sound.making import RATE, of, of_record
from stickslip_sound.sounds import FULL_SCALE, Sound, save_all

__all__ = ["FULL_SCALE", "RATE", "Sound", "a_weighting", "levels", "of", "of_record", "save_all", "summary"]
