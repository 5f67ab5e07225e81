"""Results as tables: every value, by the words and units of the dataset, whatever the size."""

import re
from io import StringIO

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import stickslip
from helpers.commands import call
from stickslip.dataset import export
from stickslip.files import tables

CELL = {"mass": 1.0, "normal_load": 1.0, "belt_speed": 0.1, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
MAP = """\
title: small
system: {mass: 1, normal_load: 1, damping: 0.1}
axes:
  lubricant: {zip: {a1: [1, 0.8], a3: [0.3, 0.1]}, labels: ["dry, new", 'oil "B"']}
  stiffness: [1, 10, 100]
  belt_speed: {start: 0.1, stop: 3, num: 4}
friction: {a2: 0.1, a4: 0.1}
"""


@pytest.fixture(scope="module")
def small():
    return stickslip.run(stickslip.config.reader.parse_config(MAP))


def test_every_cell_is_a_row_with_its_coordinates_and_values(small, tmp_path):
    table = export.write_table(small, tmp_path / "map.csv")
    found = pd.read_csv(tmp_path / "map.csv")
    assert len(found) == table.rows == small["regime"].size and not table.left_out
    assert list(found.columns[:5]) == ["lubricant", "a1", "a3", "stiffness [N/m]", "belt_speed [m/s]"]
    names = small["regime"].attrs["flag_meanings"].split()
    for number, (i, j, k) in enumerate(np.ndindex(small["regime"].shape)):
        row, cell = found.iloc[number], small.isel(lubricant=i, stiffness=j, belt_speed=k)
        assert row["lubricant"] == str(cell["lubricant"].values) and row["stiffness [N/m]"] == float(cell["stiffness"])
        assert row["regime"] == names[int(cell["regime"])]
        for name, heading in (("period", "period [s]"), ("spring_force_max", "spring_force_max [N]")):
            np.testing.assert_equal(row[heading], float(f"{float(cell[name]):.9g}"))  # NaN is empty
    assert "a1" in found and "mass" not in found


def test_a_workbook_has_the_same_rows_and_says_where_they_come_from(small, tmp_path):
    export.write_table(small, tmp_path / "map.xlsx", ["regime", "period"])
    found = pd.read_excel(tmp_path / "map.xlsx", sheet_name=None)
    np.testing.assert_allclose(found["data"]["period [s]"], small["period"].values.ravel(), rtol=5e-6)
    about = dict(found["about"].values)
    assert about["title"] == "small" and "axes" in about["configuration"] and about["mass"] == "1 kg"


def test_a_table_larger_than_memory_is_written_a_chunk_at_a_time(tmp_path, monkeypatch):
    """Rows of a file on disk, in order, no more of them in memory than a few chunks have."""
    from stickslip.files import reading, writing

    monkeypatch.setattr(export, "_MOST_ROWS", 2**9)
    monkeypatch.setattr(writing, "_CHUNK_VALUES", 2**9)
    shape, size = (40, 700), 28_000
    values = np.arange(float(size)).reshape(shape)
    attributes = {"source": "stickslip test"}
    ds = xr.Dataset({name: (("y", "x"), values) for name in "abcdefgh"}, {"x": np.arange(700.0)}, attributes)
    writing.write(ds, tmp_path / "large.nc")
    read, frames = [], export.ResultTable.frames
    monkeypatch.setattr(export.ResultTable, "frames", lambda table: (read.append(x) or x for x in frames(table)))
    with reading.look_into(tmp_path / "large.nc") as lazy:
        table = export.write_table(lazy, tmp_path / "large.csv")
    assert table.rows == size and max(map(len, read)) <= 2**10  # a few stored chunks
    found = pd.read_csv(tmp_path / "large.csv")
    np.testing.assert_array_equal(found["a"], np.arange(float(size)))
    np.testing.assert_array_equal(found["y"], np.repeat(np.arange(40), 700))


RESULTS = {
    "cells": lambda: stickslip.evaluate({**CELL, "stiffness": [1.0, 10.0, 100.0]}),
    "borders": lambda: stickslip.border({**CELL, "stiffness": [1.0, 10.0]}, "belt_speed", (0.01, 5.0), scan=16),
    "margins": lambda: stickslip.margins({**CELL, "stiffness": [1.0, 10.0]}, ("belt_speed",), joint=False, scan=8),
    "contours": lambda: stickslip.contours(
        {**CELL, "stiffness": [1.0]}, ("stiffness", "belt_speed"),
        {"stiffness": (1.0, 10.0), "belt_speed": (0.1, 3.0)}, 16, scan=16, tolerance=1e-3,
    ),
    "attractors": lambda: stickslip.attractors(
        {**CELL, "stiffness": [1.0, 10.0]}, {"displacement": (-2.0, 2.0), "velocity": (-1.0, 1.0)}, samples=16
    ),
    "trajectory": lambda: stickslip.simulate(duration=10.0, samples=50, **CELL, stiffness=1.0),
}  # fmt: skip


@pytest.mark.parametrize("kind", RESULTS)
def test_every_result_is_a_table(kind, tmp_path):
    ds = RESULTS[kind]()
    table = export.write_table(ds, tmp_path / "found.csv")
    found = pd.read_csv(tmp_path / "found.csv")
    assert len(found) == table.rows > 0 and len(found.columns) == len(table.columns)
    if kind == "contours":
        assert {"line", "regime_left", "stiffness [N/m]", "belt_speed [m/s]"} <= set(found)
        assert len(found) == ds.sizes["node"] and found["line"].nunique() == ds.sizes["line"]
    if kind == "trajectory":
        np.testing.assert_allclose(found["time [s]"], ds["time"], rtol=5e-6)


def test_the_command_exports_what_is_asked_for(small, tmp_path, monkeypatch):
    from stickslip.files import writing

    monkeypatch.chdir(tmp_path)
    writing.write(small, "map.nc")
    done = call("export", "map.nc", "--variable", "regime", "--select", "stiffness=10 N/m")
    assert done.exit_code == 0 and "table    map.csv (8 rows," in done.stdout, done.output
    assert set(pd.read_csv("map.csv")) == {"lubricant", "a1", "a3", "belt_speed [m/s]", "regime"}
    for words, said in (
        (["--variable", "perod"], "did you mean period?"),
        (["-o", "map.ods"], "map.ods: tables end in .csv, .xlsx"),
    ):
        wrong = call("export", "map.nc", *words)
        assert wrong.exit_code == 2 and said in wrong.stderr


def test_a_run_keeps_its_map_and_makes_the_table_of_it(here):
    (here / "small.yaml").write_text(MAP)
    done = call("run", "small.yaml", "-o", "found.csv")
    assert done.exit_code == 0, done.output
    assert {p.name for p in here.iterdir()} == {"small.yaml", "found.nc", "found.csv"}
    assert len(pd.read_csv("found.csv")) == 24
    (here / "found.csv").unlink()
    again = call("run", "small.yaml", "-o", "found.csv")
    assert "is complete already" in again.stdout and len(pd.read_csv("found.csv")) == 24


@pytest.mark.parametrize("suffix", [".csv", ".xlsx"])
def test_cells_that_are_left_out_are_empty_and_dates_are_dates(small, suffix, tmp_path):
    ds = small[["regime", "status"]].where(small.stickslip.mask("damped"))
    days = np.datetime64("2026-01-01", "ns") + np.arange(ds.sizes["stiffness"]) * np.timedelta64(1, "D")
    export.write_table(ds.assign(day=("stiffness", days)), tmp_path / f"part{suffix}")
    found = (pd.read_csv if suffix == ".csv" else pd.read_excel)(tmp_path / f"part{suffix}")
    assert found["regime"].value_counts(dropna=False).to_dict() == {
        "damped": int((small["regime"] == 2).sum()), np.nan: int((small["regime"] != 2).sum())
    }  # fmt: skip
    assert set(pd.to_datetime(found["day"])) == {*days}


LIVE = ["=cmd|' /C calc'!A0", "+1+2", "-2+3", "@SUM(A1)", "\t=1+1", " =1+1", "a;=1+1", "'=quoted", "＝1+1"]
TAME = ["grease 2", "-5", "+1.5", "R-134a", "a = b", "'s-Gravenhage", "Öl (1+2)"]


def test_no_label_is_a_formula_in_csv_and_our_reader_knows_the_label(tmp_path):
    labels = [*LIVE, *TAME]
    ds = xr.Dataset({"mu": ("material", np.linspace(-1, 1, len(labels)), {"units": "1"})}, {"material": labels})
    export.write_table(ds, tmp_path / "labels.csv")
    text = (tmp_path / "labels.csv").read_text(encoding="utf-8-sig")
    table = tables.read_table(tmp_path / "labels.csv", "material, mu")
    assert [row[0].text for row in tables.cells(table)] == labels
    cells = pd.read_csv(tmp_path / "labels.csv")["material"]
    assert all(cell.startswith("'") or ";'=" in cell for cell in cells[: len(LIVE)].astype(str))
    assert not re.search(r"(^|[;,\t]\"?)\s*[=@]", text, re.MULTILINE) and list(cells[-len(TAME) :]) == TAME
    assert pd.api.types.is_float_dtype(pd.read_csv(StringIO(text), sep=None, engine="python")["mu"])


def test_no_text_is_a_formula_in_a_workbook_and_numbers_are_numbers(tmp_path):
    import openpyxl

    labels = [*LIVE, *TAME, "#REF!"]
    variables = {"=1+1": ("material", np.linspace(-1, 1, len(labels)), {"units": "1"})}
    ds = xr.Dataset(variables, {"material": labels}, {"title": "=HYPERLINK(1)"})
    export.write_table(ds, tmp_path / "labels.xlsx")
    book = openpyxl.load_workbook(tmp_path / "labels.xlsx")
    cells = [cell for sheet in book for row in sheet.iter_rows() for cell in row if cell.value is not None]
    assert {cell.data_type for cell in cells} == {"s", "n"}
    assert [cell.value for cell in book["data"]["A"][1:]] == labels
    assert all(cell.quotePrefix for cell in book["data"]["A"][1 : 1 + len(LIVE)])


def test_tables_are_in_the_units_of_the_screen_with_nine_digits_and_the_mark_that_excel_needs(tmp_path):
    speed = ("belt_speed", [0.0123456789, 0.2], {"units": "m s-1", "display_units": "mm/s"})
    period = ("belt_speed", [0.0123456789, np.nan], {"units": "s"})
    times = np.arange(1000.0, 1001.0, 1e-4)
    export.write_table(xr.Dataset({"period": period}, {"belt_speed": speed}), tmp_path / "öl.csv")
    lines = (tmp_path / "öl.csv").read_bytes().decode("utf-8").splitlines()
    assert lines == ["\ufeffbelt_speed [mm/s],period [ms]", "12.3456789,12.3456789", "200,"]
    ds = xr.Dataset({"force": ("time", times)}, {"time": ("time", times, {"units": "s"})})
    export.write_table(ds, tmp_path / "long.csv")
    found = pd.read_csv(tmp_path / "long.csv")["time [s]"]
    assert np.allclose(np.diff(found), 1e-4, rtol=1e-2)  # samples stay apart
