"""A sound: an acceleration over time, ready to be heard, and what to know when judging it by ear."""

import base64
import io
import os
import struct
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from html import escape
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import wavfile  # type: ignore[import-untyped]

from stickslip.files.targets import replaced
from stickslip_sound.series import HIGHEST

Floats = NDArray[np.float64]
_LOUDEST = 32767  # of 16 bits
FULL_SCALE = 100.0  # m/s2
KNEE = 0.9  # of full scale, from where on what is louder is compressed
_LOWEST = 20.0  # Hz that are heard


@dataclass(frozen=True, eq=False)
class Sound:
    """The sound that a microphone following the mass would record.

    acceleration : m/s2, limited to what is heard, faded at both ends. rate : samples a second. slow : how many times
        slower than the motion. full_scale : the acceleration (m/s2) that is the loudest the sound can be.
    regime : of the cell; nothing of a record. frequency : of its cycle, or of its decay (Hz, of the motion); NaN where
        there is neither.
    repeats : whether it is the cycle without the transient before.
    """

    acceleration: Floats
    rate: int
    slow: float
    full_scale: float
    regime: str
    frequency: float
    repeats: bool
    title: str = ""

    @cached_property
    def samples(self) -> Floats:
        """Between -1 and 1: in proportion to the acceleration up to 0.9, above that softly compressed."""
        samples = self.acceleration / self.full_scale
        over, room = np.abs(samples) - KNEE, 1.0 - KNEE
        return np.where(over > 0.0, np.copysign(KNEE + room * np.tanh(np.maximum(over, 0.0) / room), samples), samples)

    @property
    def seconds(self) -> float:
        """Duration, s."""
        return self.acceleration.size / self.rate

    @cached_property
    def peak(self) -> float:
        """Largest magnitude of the acceleration, m/s2."""
        return float(np.abs(self.acceleration).max(initial=0.0))

    @property
    def clips(self) -> bool:
        """Return whether some of it is compressed."""
        return self.peak > KNEE * self.full_scale

    @property
    def heard(self) -> float:
        """The frequency as it is heard, Hz."""
        return self.frequency / self.slow

    def wav(self, floating: bool = False) -> bytes:
        """A WAV file of one channel, with a comment that players show: 16-bit integers, or 32-bit numbers, which keep
        what is fainter than 1/65534 of full scale."""
        samples, file = np.clip(self.samples, -1.0, 1.0), io.BytesIO()
        stored = samples.astype(np.float32) if floating else np.rint(samples * _LOUDEST).astype(np.int16)
        wavfile.write(file, self.rate, stored)
        pace = "" if self.slow == 1.0 else f"; {self.slow:g} times slower"
        comment = f"{self.title or 'stickslip'}; full scale {self.full_scale:g} m/s2{pace}"
        return _with_comment(file.getvalue(), comment)

    def save(self, path: str | os.PathLike[str], floating: bool = False) -> None:
        """Write a WAV file, whole or not at all. Raises StoreError."""
        with replaced(path) as temporary:
            temporary.write_bytes(self.wav(floating))

    def described(self) -> str:
        """Regime, frequency and peak, on a line."""
        frequency = f"{self.frequency:.3g} Hz" if self.regime and isfinite(self.frequency) else ""
        pace = "" if self.slow == 1.0 else f"{self.slow:g} times slower"
        words = (self.regime.replace("_", "-"), frequency, f"peaks of {self.peak:.3g} m/s2", pace)
        return ", ".join(filter(None, words))

    def remarks(self) -> list[str]:
        """Remarks for whoever judges it by ear, a line each."""
        remarks = []
        if self.regime == "stuck" and self.peak == 0.0:
            remarks.append("silence: the cell is stuck")
        elif self.regime and not self.repeats:
            remarks.append("the motion from the start, not a cycle")
        if self.heard < _LOWEST or self.heard >= min(HIGHEST, 0.5 * self.rate):
            side = "below" if self.heard < _LOWEST else "above"
            remarks.append(f"{self.heard:.3g} Hz is {side} hearing: another `slow` brings it there")
        if self.clips:
            remarks.append(f"clips: peaks of {self.peak:.3g} m/s2 are compressed at {self.full_scale:g} m/s2")
        return remarks

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.wav()).decode("ascii")
        words = "<br>".join(map(escape, filter(None, [self.title, self.described(), *self.remarks()])))
        return f'<audio controls src="data:audio/wav;base64,{data}"></audio><div>{words}</div>'


def _with_comment(content: bytes, comment: str) -> bytes:
    """A file with a LIST chunk of information at its end; chunks have even lengths."""
    text = comment.encode("utf-8") + b"\0"
    text += b"\0" * (len(text) % 2)
    entry = b"INFOICMT" + struct.pack("<I", len(text)) + text
    content += b"\0" * (len(content) % 2) + b"LIST" + struct.pack("<I", len(entry)) + entry
    return content[:4] + struct.pack("<I", len(content) - 8) + content[8:]


def save_all(target: Path, sounds: Iterable[tuple[str, Sound]]) -> list[str]:
    """Write named sounds of one scale, a WAV file each, into a folder; or the one there is. Returns lines on them."""
    is_file = target.suffix.lower() == ".wav"
    written = []
    for name, sound in sounds:
        sound.save(target if is_file else target / f"{name}.wav")
        written.append((sound.full_scale, sound.peak, sound.clips))
    if not written:
        return ["none: no test was integrated to its end"]
    scales, peaks, clips = zip(*written, strict=True)
    lines = [f"{target if is_file else target / '*.wav'} (full scale {scales[0]:g} m/s2)"]
    return lines + [f"{sum(clips):,} of {len(clips):,} clip, with peaks of up to {max(peaks):.3g} m/s2"] * any(clips)
