"""The sound of a cell or a record, and how loud cells are: what is in `stickslip.sound`."""

from stickslip_sound.loudness import a_weighting, levels
from stickslip_sound.sounds import FULL_SCALE, RATE, Sound, of, of_record

__all__ = ["FULL_SCALE", "RATE", "Sound", "a_weighting", "levels", "of", "of_record"]
