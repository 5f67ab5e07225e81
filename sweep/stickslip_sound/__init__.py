"""What a cell sounds like, and how loud it is: an extension of `stickslip`.

extension.py   what the engine is told          command.py    `stickslip listen`
sounds.py      the sound of a cell, WAV files   loudness.py   levels of cells, weighted
plots.py       a sound and its spectrogram      series.py     the acceleration of a cycle as a Fourier series
"""
