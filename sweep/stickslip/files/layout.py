"""Lines of tables in parts: separators, numbers, remarks, and rows that are no measurements."""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence

NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?", re.ASCII)
DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d{1,3})?", re.ASCII)
_DECIMAL_POINT = re.compile(r"[-+]?\d*\.\d+(?:[eE][-+]?\d{1,3})?", re.ASCII)
_WRITTEN = re.compile(r"[-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?")
_LETTERS = re.compile(r"[^\W\d_]{2}|[Øø]")
_SUMMARY = re.compile(  # rows of spreadsheets and instruments that are no measurements
    r"(?:arithm\w*\.? )?(?:mean|mittel(?:wert)?|mw|average|avg|durchschnitt|moyenne|moy|median|m[ée]diane?|ø"
    r"|max(?:imum|imalwert)?|min(?:imum|imalwert)?|std|stdev(?:\.[sp])?|std\.? ?dev\.?|st\.? ?dev\.?|sd|stabw\w*"
    r"|std\.?-?abw\w*\.?|standard ?abw\w*\.?|standard deviation|[ée]cart[- ]type|sum|summe|somme|total|count|anzahl"
    r"|nombre|range|spannweite|varian[cz]e?|rsd|cv|rms)"
    r"(?: ?(?:value|wert|valeur|%|\(.*\)|\[.*\]))?\s*[:=]?", re.IGNORECASE,
)  # fmt: skip
SEPARATORS = {";": "semicolons", "\t": "tabulators", ",": "commas"}
MOST_ABOVE = 300  # lines above the heading
_OPEN = re.compile(r'(?:^|[;,\t])\s*"[^"]*$')  # a cell that is not closed
_MOST_JOINED = 4  # lines of one heading
_LONGEST_HEADING = 2_000  # characters
_UNIT_APART = re.compile(r"[ \t]+(?=[\[(])")


def plain_cells(line: str, mark: str) -> list[str]:
    """The cells of a line without quotation marks, and without the empty ones behind the last."""
    texts = [line[begin:end].strip().strip('"').strip() for begin, end in cells_of(line, mark)]
    while texts and not texts[-1]:
        texts.pop()
    return texts


def cells_of(line: str, separator: str) -> Iterator[tuple[int, int]]:
    """Begin and end of each cell of a line; separators in quotation marks are none."""
    quoted, begin = False, 0
    for i, character in enumerate(f"{line}{separator}"):
        if character == '"':
            quoted = not quoted
        elif character == separator and not quoted:
            yield begin, i
            begin = i + 1


def is_number(text: str) -> bool:
    """True for a number, with a decimal point or comma."""
    return bool(NUMBER.fullmatch(text.strip().replace(",", ".")))


def is_remark(line: str) -> bool:
    """True for a line that holds no cells."""
    return line.lstrip().startswith(("#", "% "))


def summary(line: str, separator: str) -> str:
    """The label of a row of means, extremes or the like; nothing for a row of measurements."""
    texts = plain_cells(line, separator) if _LETTERS.search(line) else []
    return next((text for text in texts if _SUMMARY.fullmatch(text) and any(map(is_number, texts))), "")


def is_row(line: str, separator: str) -> bool:
    """Tell a row of measurements, or of their means, from a line that stands above the names of columns."""
    texts = plain_cells(line, separator)
    numbers = sum(map(is_number, texts))
    return bool(texts) and (is_number(texts[0]) or 2 * numbers >= max(len(texts), 3) or bool(summary(line, separator)))


def separated(text: str, below: bytes) -> tuple[str, bytes]:
    """A text whose numbers are separated by blanks with tabs in their place; any other as it is."""
    lines = text.splitlines()
    rows = [line.split() for line in lines[-20:] if "\t" not in line and ";" not in line]
    numbers = [len(row) for row in rows if row and all(map(_WRITTEN.fullmatch, row))]
    if len(numbers) < 2 or {*numbers} == {1}:
        return text, below
    rest = b"\n".join(b"\t".join(line.split()) for line in below.split(b"\n"))
    return "\n".join(_tabbed(line, numbers[-1]) for line in lines), rest


def _tabbed(line: str, width: int) -> str:
    """The cells of a line apart from each other, whose names may hold single blanks."""
    mark, bare = ("# ", line.lstrip("#% ")) if line.lstrip().startswith(("#", "%")) else ("", line.strip())
    if len(bare) > _LONGEST_HEADING:
        return "\t".join(line.split())
    ways = (re.split(r"\s{2,}", bare), re.split(r"\s*[,;\t]\s*", bare), _UNIT_APART.sub("", bare).split(), bare.split())
    return next((mark + "\t".join(cells) for cells in ways if len(cells) == width), line)


def whole_lines(text: str, begins: int) -> Iterator[tuple[int, str]]:
    """The lines of a text, numbered; near the top a cell in quotation marks may go on in the next line."""
    begun: tuple[int, str] | None = None
    for number, line in enumerate(text.splitlines(), begins):
        if begun is not None:
            begun = (begun[0], f"{begun[1]} {line}")
        elif number < begins + MOST_ABOVE and _OPEN.search(line) and line.count('"') % 2:
            begun = (number, line)
        if begun is None:
            yield number, line
        elif begun[1].count('"') % 2 == 0 or number - begun[0] >= _MOST_JOINED:
            yield begun
            begun = None
    if begun is not None:
        yield begun


def heading_at(
    lines: Sequence[str], declared: str, is_heading: Callable[[Sequence[str]], bool] | None
) -> tuple[int, str]:
    """The number of the line that names the columns, and their separator."""
    marks = [declared] if declared else [*SEPARATORS]
    for i, line in enumerate(lines):
        for mark in marks:
            names = plain_cells(line, mark)
            if is_heading is None or len(names) < 2 or any(map(is_number, names)) or not is_heading(names):
                continue
            for row in lines[i + 1 : i + 3]:  # a line of units may stand between names and numbers
                row_cells = plain_cells(row, mark)
                if is_heading(row_cells):
                    break
                if 1 < sum(map(is_number, row_cells)) and len(row_cells) <= len(names):
                    return i, mark
    several = [i for i, line in enumerate(lines) if any(len(plain_cells(line, mark)) > 1 for mark in marks)]
    named = (i for i in several if is_heading and any(is_heading(plain_cells(lines[i], mark)) for mark in marks))
    at = next(named, several[0] if several else 0)
    return at, declared or _separator(lines[at], lines[min(at + 1, len(lines) - 1)])


def _separator(heading: str, row: str) -> str:
    """The separator that cuts the heading and the first row into as many cells; else the one that the heading has."""
    counts = {mark: [len(list(cells_of(line, mark))) for line in (heading, row)] for mark in SEPARATORS}
    used = [mark for mark, (cells, _) in counts.items() if cells > 1]
    return next((mark for mark in used if counts[mark][0] == counts[mark][1]), used[0] if used else ",")


def rows_within(rows: Iterable[tuple[int, str]], separator: str, width: int) -> Iterator[tuple[int, str]]:
    """Lines that hold something, without the empty cells that spreadsheets write behind the last column."""
    for number, line in rows:
        if line.endswith(separator):
            if not line.strip(f"{separator} "):
                continue
            spare = line.count(separator) - width + 1
            for _ in range(spare):
                line = line.removesuffix(separator)
        yield number, line


def thousands(texts: Sequence[str], comma: bool) -> bool:
    """Tell whether the decimal marks of a column rather stand between thousands: 500, 1,000, 1,500."""
    marked = re.compile(r"[-+]?[1-9]\d{0,2}[,]\d{3}" if comma else r"[-+]?[1-9]\d{0,2}[.]\d{3}")
    whole = [text for text in texts if text.lstrip("+-").isdigit()]
    others = [text for text in texts if text and text not in whole]
    return bool(others) and any(len(text) > 2 for text in whole) and all(map(marked.fullmatch, others))


def mixed_marks(text: str, comma: bool) -> str:
    """The remedy where a text has a decimal point though the file has decimal commas; nothing where it has none."""
    if comma and _DECIMAL_POINT.fullmatch(text):
        return "the file mixes decimal commas and decimal points: write one of them throughout"
    return "leave out the points between thousands" if comma and "." in text else ""
