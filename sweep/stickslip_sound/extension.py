"""What the engine is told of sounds: a command, Python calls, and a method of datasets."""

from stickslip.extensions import Extension

EXTENSION = Extension(
    commands={"One cell, and what a designer asks": {"listen": "stickslip_sound.command"}},
    calls={"sound": "stickslip_sound.sounds", "plots.plot_sound": "stickslip_sound.plots:plot_sound"},
    subjects=("acceleration_level_a",),
    methods={"sound": "stickslip_sound.sounds:sound_of_cell"},
)
