"""What a cell sounds like, and how loud it is: an extension of `stickslip`.

`stickslip listen` writes the acceleration of a cell as a WAV file; `stickslip.sound` does so in Python, for records of
rigs and for levels of whole maps as well.

    extension.py   what the engine is told      api.py        the names in `stickslip.sound`
    command.py     `stickslip listen`           plots.py      a sound and its spectrogram
    making.py      the sound of a cell          series.py     its acceleration as a Fourier series
    cycles.py      where cycles start           sounds.py     WAV files, what to know when listening
    loudness.py    levels of cells, weighted    variables.py  the variables of levels

It leans on the engine alone. Others use it through `stickslip.sound`, if it is there.
"""
