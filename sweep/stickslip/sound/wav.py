"""WAV files: samples between -1 and 1, and what they are in words."""

from __future__ import annotations

import io
import struct

import numpy as np
from numpy.typing import NDArray
from scipy.io import wavfile  # type: ignore[import-untyped]

_LOUDEST = 32767  # of 16 bits


def wav_bytes(samples: NDArray[np.float64], rate: int, comment: str = "", floating: bool = False) -> bytes:
    """A WAV file of one channel.

    samples : 1 is full scale; what is beyond is cut off. floating : 32-bit numbers instead of 16-bit integers, which
        keep what is fainter than 1/65534 of full scale. comment : goes into the file, where players show comments.
    """
    held = np.clip(samples, -1.0, 1.0)
    stored = held.astype(np.float32) if floating else np.rint(held * _LOUDEST).astype(np.int16)
    file = io.BytesIO()
    wavfile.write(file, rate, stored)
    return _with_comment(file.getvalue(), comment) if comment else file.getvalue()


def _with_comment(content: bytes, comment: str) -> bytes:
    """The file with a LIST chunk of information at its end; chunks have even lengths."""
    text = comment.encode("utf-8") + b"\0"
    text += b"\0" * (len(text) % 2)
    entry = b"INFOICMT" + struct.pack("<I", len(text)) + text
    content += b"\0" * (len(content) % 2) + b"LIST" + struct.pack("<I", len(entry)) + entry
    return content[:4] + struct.pack("<I", len(content) - 8) + content[8:]
