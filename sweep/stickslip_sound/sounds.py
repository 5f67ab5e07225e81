"""A sound: an acceleration over time, ready to be heard, and what to know when judging it by ear.

It is written as a WAV file: samples between -1 and 1, and what they are in words.
"""

import base64
import io
import os
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from html import escape
from math import floor, isfinite, log10
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import wavfile  # type: ignore[import-untyped]

from stickslip.files.targets import replaced
from stickslip_sound.series import HIGHEST

Floats = NDArray[np.float64]
_LOUDEST = 32767  # of 16 bits


def wav_bytes(samples: NDArray[np.float64], rate: int, comment: str = "", floating: bool = False) -> bytes:
    """A WAV file of one channel.

    samples : 1 is full scale; what is beyond is cut off. floating : 32-bit numbers instead of 16-bit integers, which
        keep what is fainter than 1/65534 of full scale. comment : goes into the file, where players show comments.
    """
    samples = np.clip(samples, -1.0, 1.0)
    file = io.BytesIO()
    wavfile.write(file, rate, samples.astype(np.float32) if floating else np.rint(samples * _LOUDEST).astype(np.int16))
    return _with_comment(file.getvalue(), comment) if comment else file.getvalue()


def _with_comment(content: bytes, comment: str) -> bytes:
    """The file with a LIST chunk of information at its end; chunks have even lengths."""
    text = comment.encode("utf-8") + b"\0"
    text += b"\0" * (len(text) % 2)
    entry = b"INFOICMT" + struct.pack("<I", len(text)) + text
    content += b"\0" * (len(content) % 2) + b"LIST" + struct.pack("<I", len(entry)) + entry
    return content[:4] + struct.pack("<I", len(content) - 8) + content[8:]


FULL_SCALE = 100.0  # m/s2
KNEE = 0.9  # of full scale, from where on what is louder is compressed
_LOWEST = 20.0  # Hz that are heard
_FAINT = 1e-3  # of full scale


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
        return softly_clipped(self.acceleration / self.full_scale)

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
        """A WAV file, 16-bit, or 32-bit floating."""
        pace = "" if self.slow == 1.0 else f"; {self.slow:g} times slower"
        comment = f"{self.title or 'stickslip'}; full scale {self.full_scale:g} m/s2{pace}"
        return wav_bytes(self.samples, self.rate, comment, floating)

    def save(self, path: str | os.PathLike[str], floating: bool = False) -> None:
        """Write a WAV file, whole or not at all. Raises StoreError."""
        with replaced(path) as temporary:
            temporary.write_bytes(self.wav(floating))

    def described(self) -> str:
        """Regime, frequency and peak, on a line."""
        kind = f"{self.regime.replace('_', '-')}, " if self.regime else ""
        if self.regime and isfinite(self.frequency):
            kind += f"{_hertz(self.frequency)}, "
        pace = "" if self.slow == 1.0 else f", {self.slow:g} times slower"
        return f"{kind}peaks of {self.peak:.3g} m/s2{pace}"

    def remarks(self) -> list[str]:
        """Remarks for whoever judges it by ear, a line each."""
        return [*self._of_regime(), *self._of_pitch(), *self._of_level()]

    def _of_regime(self) -> Iterator[str]:
        if self.regime == "stuck":
            if self.peak == 0.0:
                yield "silence: the cell is stuck, the contact never breaks away"
        elif self.regime in ("damped", "creep") and not self.repeats:
            yield "it settles to steady sliding: what sounds is the decay, silence after it"
        elif self.regime and not self.repeats:
            yield f"{self.regime.replace('_', ' ')}: the motion from the start"

    def _of_pitch(self) -> Iterator[str]:
        if self.heard >= min(HIGHEST, 0.5 * self.rate):
            what, aim = "is above hearing, so nothing is heard", 2000.0
        elif self.heard < _LOWEST:
            slip = "a click at the end of each slip, and harmonics"
            tones = slip if self.regime == "stick_slip" else "harmonics, if any"
            what, aim = f"is below hearing ({_LOWEST:g} Hz), what is heard is {tones}", 200.0
        else:  # or there is none
            return
        factor = _decade(self.heard / aim)
        brought = f"slow {self.slow * factor:.3g} brings it to {_hertz(self.heard / factor)}"
        yield f"{_hertz(self.heard)} {what}: {brought}"

    def _of_level(self) -> Iterator[str]:
        peaks = f"peaks of {self.peak:.3g} m/s2"
        if self.clips:
            yield (
                f"clips: {peaks} are compressed at a full scale of {self.full_scale:g} m/s2; "
                f"one of {_round_up(self.peak / KNEE):g} m/s2 would not"
            )
        elif 0.0 < self.peak < _FAINT * self.full_scale:
            yield (
                f"faint: {peaks} at a full scale of {self.full_scale:g} m/s2; one of "
                f"{_round_up(self.peak / KNEE):.3g} m/s2 makes it loud, to be compared with others of that scale only"
            )

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.wav()).decode("ascii")
        words = "<br>".join(map(escape, filter(None, [self.title, self.described(), *self.remarks()])))
        return f'<audio controls src="data:audio/wav;base64,{data}"></audio><div>{words}</div>'


def softly_clipped(samples: Floats) -> Floats:
    """The same up to 0.9, above that compressed, smoothly, so that nothing reaches 1."""
    over = np.abs(samples) - KNEE
    room = 1.0 - KNEE
    return np.where(over > 0.0, np.copysign(KNEE + room * np.tanh(np.maximum(over, 0.0) / room), samples), samples)


def _hertz(frequency: float) -> str:
    return f"{frequency / 1e3:.3g} kHz" if frequency >= 1e3 else f"{frequency:.3g} Hz"


def _decade(ratio: float) -> float:
    """The power of ten next to a ratio, one at least that changes something."""
    exponent = round(log10(ratio))
    return float(10.0 ** (exponent or (1 if ratio > 1.0 else -1)))


def _round_up(value: float) -> float:
    """The next of 1, 2, 5, 10, ... that is no smaller."""
    scale = 10.0 ** floor(log10(value))
    return float(next(step * scale for step in (1.0, 2.0, 5.0, 10.0) if step * scale >= value * (1.0 - 1e-12)))


def save_all(target: Path, sounds: Iterable[tuple[str, Sound]]) -> list[str]:
    """Write named sounds of one scale, a WAV file each, into a folder; or the one there is. Returns lines on them."""
    single = target.suffix.lower() == ".wav"
    written, clipping, loudest, full_scale = 0, 0, 0.0, 0.0
    for name, sound in sounds:
        sound.save(target if single else target / f"{name}.wav")
        full_scale, loudest = sound.full_scale, max(loudest, sound.peak)
        written, clipping = written + 1, clipping + sound.clips
    if not written:
        return ["none: no test was integrated to its end"]
    lines = [f"{target if single else target / '*.wav'} (full scale {full_scale:g} m/s2)"]
    if clipping:
        lines.append(f"{clipping:,} of {written:,} clip, with peaks of up to {loudest:.3g} m/s2: softly compressed")
    return lines
