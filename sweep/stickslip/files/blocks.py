"""Long tables in blocks of lines, of which plain ones, numbers and separators alone, are read by pandas.

Whatever might be read otherwise than line by line is not: quotation marks, remarks, empty lines, other characters than
ASCII, lines of another number of cells. Numbers are the nearest doubles, as Python reads them.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

_BLOCK = 8 << 20  # bytes, more than the longest line has
_DIGITS = b"0123456789+-.,;eE \t\n"
_LETTERS = bytes(set(range(32, 127)) - set(b'"#'))
_LINE, _COMMA_MARK = ord("\n"), ","


def blocks(rest: bytes, begins: int) -> Iterator[tuple[int, bytes]]:
    """A text in blocks of whole lines, each with the number of its first one; `begins` is that of the text."""
    start = 0
    while start < len(rest):
        end = len(rest) if len(rest) - start <= _BLOCK else rest.rfind(b"\n", start, start + _BLOCK) + 1
        yield begins, (block := rest[start:end])
        begins, start = begins + block.count(b"\n"), end


def plain_numbers(
    block: bytes, separator: str, width: int, columns: Sequence[int], comma: bool
) -> NDArray[np.float64] | None:
    """The columns at the positions `columns` of a block, (columns, lines); None if it is not plain, or no numbers.

    comma : whether they have decimal commas.
    """
    other = block.translate(None, _DIGITS)
    if other.translate(None, _LETTERS) or not _has_cells(block, separator, width):
        return None
    import pandas as pd

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # pandas 3 reads so without being told to
            frame = pd.read_csv(
                BytesIO(block), sep=separator, header=None, names=range(width), usecols=sorted(set(columns)),
                index_col=False, dtype=np.float64, na_filter=False, decimal=_COMMA_MARK if comma else ".",
                skip_blank_lines=False, engine="c", float_precision="round_trip",
            )  # fmt: skip
    except ValueError:  # also those of pandas
        return None
    array = np.stack([frame[column].to_numpy() for column in columns])
    if not np.isfinite(array).all():
        return None
    is_logical = other and ((array == 0) | (array == 1)).all(axis=1).any()  # pandas takes a column of "true" as ones
    return None if is_logical else array


def _has_cells(block: bytes, separator: str, width: int) -> bool:
    """Tell whether every line has so many cells."""
    text = np.frombuffer(block, np.uint8)
    ends = np.flatnonzero(text == _LINE)
    if not ends.size or ends[-1] != text.size - 1:
        ends = np.append(ends, text.size)
    before = np.searchsorted(np.flatnonzero(text == ord(separator)), ends)
    return bool((np.diff(before, prepend=0) == width - 1).all()) and (width > 1 or bool((np.diff(ends) > 1).all()))
