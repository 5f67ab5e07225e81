"""Tables larger than people expect: long records are read in seconds, what no instrument writes is refused early."""

import os
import time
import zipfile

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.errors import ConfigError
from stickslip.files import tables, texts
from stickslip_materials.fit import CURVE_COLUMNS, read_points
from stickslip_rig.records import read_record

HEADING = "time [s]; force [N]; acceleration [m/s2]\n"
ODD = ["1_0", "nan", "inf", "", " ", "TRUE", "true", "٣", "1e400", "1.2.3", "1e", "0x10", "1 2", '"1"', "#1", "+ 1",
       "1e999", "1,5", "1.5", "-", "a", "1.", ".5", "+1", " 1 ", "1e-400", "1E5", "\t1", "1;"]  # fmt: skip


def short_blocks(monkeypatch):
    """Blocks of a few lines, so that short tables are read as long ones are."""
    monkeypatch.setattr(texts, "_BEGINNING", 100)
    monkeypatch.setattr(texts, "_BLOCK", 120)


def outcome(path, wanted):
    """The numbers that a table is read to, or what is said of it."""
    try:
        table = tables.read_table(path, "a, b")
        return {column: values.tolist() for column, values in tables.numbers(table, wanted).items()}, table.remarks
    except ConfigError as error:
        return str(error)


cell = st.one_of(
    st.decimals(-1000, 1000, places=3).map(str),
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.integers(0, 10**20).map(str),
)


@settings(max_examples=100, deadline=None)
@given(
    rows=st.lists(st.tuples(cell, cell, cell), min_size=1, max_size=30), data=st.data(), comma=st.booleans(),
    separator=st.sampled_from(",;\t"), end=st.sampled_from(["\n", "\r\n", "\r"]), odd=st.integers(0, 2),
    last=st.booleans(),
)  # fmt: skip
def test_a_long_table_is_read_to_the_bit_as_line_by_line(
    rows, data, separator, comma, end, odd, last, tmp_path_factory
):
    """Or refused with the same words, whatever stands in it."""
    decimal = "," if comma and separator != "," else "."
    lines = [[text.replace(".", decimal) for text in row] for row in rows]
    for _ in range(odd):
        lines[data.draw(st.integers(0, len(lines) - 1))][data.draw(st.integers(0, 2))] = data.draw(st.sampled_from(ODD))
    written = [separator.join(line) for line in lines]
    if odd:
        place = data.draw(st.integers(0, len(written)))
        written.insert(
            place, data.draw(st.sampled_from(["", "# remark", separator * 2, "1" + separator * 3, "1", "µ"]))
        )
    path = tmp_path_factory.getbasetemp() / "long.csv"
    heading = separator.join(["time [s]", "force [N]", "status"])
    path.write_bytes((heading + end + end.join(written) + end * last).encode())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(texts, "_BEGINNING", 1 << 20)
        slow = outcome(path, [0, 1])
        short_blocks(patch)
        assert outcome(path, [0, 1]) == slow


def test_a_column_of_words_that_is_left_out_does_not_slow_a_record(monkeypatch):
    block = b"".join(b"%d.5;ok;true\n" % i for i in range(100))
    assert texts.plain_numbers(block, ";", 3, [0], False)[0].tolist() == [i + 0.5 for i in range(100)]
    assert texts.plain_numbers(block, ";", 3, [0, 2], False) is None


def test_what_is_wrong_in_a_long_table_is_named_by_its_line(tmp_path, monkeypatch):
    short_blocks(monkeypatch)
    lines = [f"{i}; 1,5; {i},25" for i in range(200)]
    lines[150] = "150; 1,5; 1.25"
    lines[170] = "170; 1,5"
    path = tmp_path / "record.csv"
    path.write_text(HEADING + "\n".join(lines))
    with pytest.raises(ConfigError) as refused:
        read_record(path)
    assert [problem.place.line for problem in refused.value.problems] == [152, 172]
    lines[150], lines[170] = "150; 1,5; 1,25", "169; 1,5; 1,25"
    path.write_text(HEADING + "\n".join(lines))
    with pytest.raises(ConfigError, match="expected time to increase") as refused:
        read_record(path)
    assert refused.value.problems[0].place.line == 172


def test_remarks_below_the_beginning_of_a_long_record_count(tmp_path, monkeypatch):
    short_blocks(monkeypatch)
    lines = [f"{i};1;2" for i in range(50)]
    lines[30] = "  # load: 12 N"
    path = tmp_path / "record.csv"
    path.write_text(HEADING + "\n".join(lines))
    record = read_record(path)
    assert float(record["normal_load"]) == 12
    assert record.sizes["time"] == 49


# --- what no instrument writes ----------------------------------------------------------------------------------------

SHEET = (
    '<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>{}</sheetData></worksheet>'
)


def workbook(path, rows):
    """A workbook whose first sheet has these rows of XML."""
    import openpyxl

    openpyxl.Workbook().save(path)
    with zipfile.ZipFile(path) as whole:
        parts = {name: whole.read(name) for name in whole.namelist()}
    parts["xl/worksheets/sheet1.xml"] = SHEET.format(rows).encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            archive.writestr(name, content)
    return path


def row(number, *cells):
    """A row of XML: letters of columns with their numbers or words."""
    texts = (
        f'<c r="{at}{number}"><v>{value}</v></c>'
        if isinstance(value, int | float)
        else f'<c r="{at}{number}" t="inlineStr"><is><t>{value}</t></is></c>'
        for at, value in cells
    )
    return f'<row r="{number}">{"".join(texts)}</row>'


POINTS = row(1, ("A", "speed [mm/s]"), ("B", "mu")) + "".join(row(i, ("A", i), ("B", 0.5)) for i in range(2, 9))


HOSTILE = {
    "columns": lambda: ",".join(["speed [mm/s]", *map(str, range(200_000))]),
    "line": lambda: "speed [mm/s], mu " * 1_000_000,
    "quotation": lambda: "speed [mm/s], mu\n" + '1, "0.5\n' * 50_000,
    "zeros": lambda: "\0" * 10_000_000,
    "points": lambda: "speed [mm/s], mu\n" + "1, 0.5\n" * 200_000,
}
SHEETS = {
    "stray": lambda: POINTS + row(1048576, ("XFD", 1)),  # took four gigabytes before
    "rows": lambda: POINTS + "".join(row(i, ("A", 1), ("B", 1)) for i in range(9, 110_000)),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", [*HOSTILE, *SHEETS])
def test_hostile_tables_are_refused_in_seconds(name, tmp_path):
    path = tmp_path / f"{name}.{'csv' if name in HOSTILE else 'xlsx'}"
    if name in HOSTILE:
        path.write_text(HOSTILE[name]())
    else:
        workbook(path, SHEETS[name]())
    begin = time.process_time()
    with pytest.raises(ConfigError, match=name):
        read_points(path, CURVE_COLUMNS)
    assert time.process_time() - begin < 8.0


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
def test_a_pipe_a_device_and_a_folder_are_no_tables(tmp_path):
    """A pipe would wait for ever, a device never end."""
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    for path in (pipe, "/dev/zero", tmp_path):
        with pytest.raises(ConfigError, match="expected"):
            read_points(path, CURVE_COLUMNS)


def test_a_file_beyond_the_limit_is_not_read(tmp_path, monkeypatch):
    path = tmp_path / "huge.csv"
    with path.open("wb") as file:
        file.truncate(texts.LARGEST_TEXT + 1)  # takes no room on the disk
    with pytest.raises(ConfigError, match="expected at most"):
        read_points(path, CURVE_COLUMNS)


def test_a_workbook_is_read_by_its_cells_and_not_by_what_it_claims(tmp_path):
    path = workbook(tmp_path / "points.xlsx", POINTS)
    with zipfile.ZipFile(path) as whole:
        parts = {name: whole.read(name) for name in whole.namelist()}
    sheet = parts["xl/worksheets/sheet1.xml"].replace(b"<sheetData>", b'<dimension ref="A1:XFD1048576"/><sheetData>')
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in (parts | {"xl/worksheets/sheet1.xml": sheet}).items():
            archive.writestr(name, content)
    assert read_points(path, CURVE_COLUMNS)["speed"].tolist() == pytest.approx([i / 1000 for i in range(2, 9)])
