"""Files as instruments write them, and what must come out of each: tests/data/instruments/expected.csv."""

import csv
from pathlib import Path

import pytest

from stickslip.errors import ConfigError
from stickslip_materials.fit import Wanted, read_materials
from stickslip_rig.api import read_record

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
