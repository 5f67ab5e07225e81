"""However the same points are written, they are read to the same numbers, or refused: never to others."""

import csv
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers.data import rows
from stickslip.errors import ConfigError
from stickslip_materials.fit import Wanted, read_materials
from stickslip_rig.api import read_record

SPELLINGS = {  # of units of speed, with what they are in m/s
    Fraction(1, 1000): (
        "mm/s", "mm / s", "mm s-1", "mm s^-1", "mm s⁻¹", "mms-1", "mms⁻¹", "mm.s-1", "mm·s^-1", "mm*s**-1", "mm s^{-1}",
        "mm s^(-1)", "mm/sec", "mm/Sek", "mm/Sek.", "mm per second", "mm pro Sekunde", "mm par seconde", "mm_per_s",
        "millimetres per second", "Millimeter/Sekunde",
    ),
    Fraction(1): ("m/s", "m s-1", "ms-1", "m·s⁻¹", "meters per second", "m/sec"),
    Fraction(1, 60): ("m/min", "m per minute", "m min-1", "m/Minute"),
    Fraction(1, 60000): ("mm/min", "mm min^-1"),
    Fraction(1, 10**6): ("µm/s", "μm/s", "um/s", "µm s-1", "micron/s"),
    Fraction(1, 100): ("cm/s", "cm s-1"),
    Fraction(1000, 3600): ("km/h", "km/Stunde"),
    Fraction(254, 10000): ("in/s", "inch/s"),
}  # fmt: skip
WORDS = rows("materials.yaml")["test_written_alike"]
NONSENSE, PLACES, SPEEDS, FRICTIONS, ABOVE = (
    WORDS[name] for name in ("NONSENSE", "PLACES", "SPEEDS", "FRICTIONS", "ABOVE")
)
UNITS = [(name, size) for size, names in SPELLINGS.items() for name in names]
OTHERS = (
    ("Temp [°C]", "23.4"), ("FN [N]", "10.5"),
    ("sd", "0.003"), ("Nr", None), ("Datum", "2024-03-01"), ("rH", "0.45"),
)  # fmt: skip


def written(value):
    """A number as decimal text, exact where it ends; else to sixteen digits."""
    return f"{float(value):.16g}" if "e" not in f"{float(value):.16g}" else f"{float(value):.25f}".rstrip("0")


points = st.lists(
    st.tuples(st.integers(1, 999), st.integers(-6, -2), st.integers(50, 1500)), min_size=4, max_size=8, unique=True
)


@settings(max_examples=400)
@given(
    rows=points, unit=st.sampled_from(UNITS), place=st.sampled_from(PLACES), speed=st.sampled_from(SPEEDS),
    friction=st.sampled_from(FRICTIONS), separator=st.sampled_from(";\t,"), comma=st.booleans(),
    others=st.lists(st.sampled_from(OTHERS), max_size=3, unique=True), order=st.randoms(use_true_random=False),
    above=st.lists(st.sampled_from(ABOVE), max_size=12), end=st.sampled_from(["\n", "\r\n"]), spare=st.integers(0, 2),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252", "latin-1"]), below=st.booleans(),
    mute=st.sampled_from([None, *NONSENSE]),
)  # fmt: skip
def test_the_same_points_are_read_to_the_same_numbers_or_refused(
    rows, unit, place, speed, friction, separator, comma, others, order, above, encoding, end, spare, below, mute,
    tmp_path_factory,
):  # fmt: skip
    name, size = unit
    decimal = "," if comma and separator != "," else "."
    scale = 100 if "%" in friction else 1
    true = [(Fraction(a) * Fraction(10) ** b, Fraction(m, 1000)) for a, b, m in rows]
    columns = [
        [speed if below else place.format(speed, mute or name), *(written(v / size) for v, _ in true)],
        [friction, *(written(mu * scale) for _, mu in true)],
        *([head, *(text or str(i + 1) for i in range(len(rows)))] for head, text in others),
    ]
    if below:
        columns = [[head, mute or name if i == 0 else "", *rest] for i, (head, *rest) in enumerate(columns)]
    order.shuffle(columns)
    table = [[cell.replace(".", decimal) if i > below else cell for cell in line]
             for i, line in enumerate(zip(*columns, strict=True))]  # fmt: skip
    lines = [line.replace(";", separator) for line in above]
    lines += [separator.join(f'"{c}"' if separator in c else c for c in line) + separator * spare for line in table]
    path = tmp_path_factory.getbasetemp() / "alike.csv"
    path.write_bytes(end.join(lines).encode(encoding, "replace"))
    wanted = Wanted()
    try:
        found = read_materials(path, None, wanted)
    except ConfigError:
        return
    assert mute is None, "a unit that nobody understands was read"
    (one,) = found.values()
    assert not one.assumed
    assert one["speed"].tolist() == pytest.approx([float(v) for v, _ in true], rel=1e-12)
    assert one["mu"].tolist() == pytest.approx([float(mu) for _, mu in true], rel=1e-12)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("unit", UNITS, ids=lambda unit: unit[0])
def test_every_spelling_of_a_unit_is_read(unit, place, tmp_path):
    name, size = unit
    path = tmp_path / "points.csv"
    path.write_text(f"{place.format('speed', name)};mu\n" + "".join(f"{i};0.{i}\n" for i in range(1, 5)), "utf-8")
    (one,) = read_materials(path, None).values()
    assert one["speed"].tolist() == pytest.approx([float(i * size) for i in range(1, 5)], rel=1e-15) and not one.assumed


@pytest.mark.parametrize("unit", NONSENSE)
@pytest.mark.parametrize("place", [*PLACES, "{0}\n{1}"])
def test_a_unit_that_is_not_understood_is_an_error(unit, place, tmp_path):
    path = tmp_path / "points.csv"
    first, _, below = place.format("speed", unit).partition("\n")
    path.write_text(f"{first};mu\n" + (f"{below};-\n" if below else "") + "1;0.3\n2;0.2\n3;0.1\n4;0.1\n", "utf-8")
    with pytest.raises(ConfigError):
        read_materials(path, None)


# --- files as instruments write them, and what must come out of each: tests/data/instruments/expected.csv ------------

FOLDER = Path(__file__).parents[1] / "data" / "instruments"
EXPECTED = list(csv.DictReader((FOLDER / "expected.csv").read_text(encoding="utf-8").splitlines()))


def workbook(text, path):
    """The same table as a workbook, its numbers as numbers."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in csv.reader(text.splitlines(), delimiter=";"):
        book.active.append([number(cell) for cell in row])
    book.save(path)


def number(text):
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return text or None


def points_of(path, options):
    wanted = Wanted(**dict(one.split("=") for one in options.split("|") if one))
    return read_materials(path, None, wanted)


@pytest.mark.parametrize("row", EXPECTED, ids=[row["file"] for row in EXPECTED])
def test_a_file_of_an_instrument_is_read_right_or_refused(row, tmp_path):
    path = FOLDER / row["file"]
    if path.suffix == ".xlsx":
        raw = path.with_suffix(".csv").read_bytes()
        path = tmp_path / path.name
        workbook(raw.decode("cp1252" if b"\xfc" in raw or b"\xdf" in raw else "utf-8"), path)
    if row["kind"] == "refused":
        with pytest.raises(ConfigError):
            points_of(path, row["options"])
        return
    first, last, y = (float(row[name]) for name in ("first_x", "last_x", "first_y"))
    if row["kind"] == "record":
        record = read_record(path)
        force = record[row["materials"].split("|")[0]]
        assert "|".join(record.data_vars) == row["materials"] and record.sizes["time"] == int(row["points"])
        assert record["time"].values[[0, -1]].tolist() == pytest.approx([first, last]) and float(force[0]) == y
        assert float(record.get("normal_load", 0.0)) == float(row["load"] or 0)
        return
    found = points_of(path, row["options"])
    assert "|".join(found) == row["materials"]
    for points in found.values():
        x = points["time" if row["kind"] == "ageing" else "speed"]
        assert len(x) == int(row["points"]) and x[[0, -1]].tolist() == pytest.approx([first, last], rel=1e-12)
        assert not points.assumed
        assert not row["load"] or f"divided by {row['load']} N" in " ".join(points.notes)
    assert next(iter(found.values()))["mu"][0] == pytest.approx(y, rel=1e-12)
