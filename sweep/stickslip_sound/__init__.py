"""What a cell sounds like, and how loud it is: an extension of `stickslip`.

extension.py   what the engine is told          api.py        the names in `stickslip.sound`
command.py     `stickslip listen`               plots.py      a sound and its spectrogram
sounds.py      the sound of a cell, WAV files   loudness.py   levels of cells, weighted
series.py      the acceleration of a cycle as a Fourier series, and where the cycle begins
"""
