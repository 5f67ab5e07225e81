"""xarray imports no library of arrays by itself, and knows its arrays once somebody else has."""

import subprocess
import sys

SETUP = """
import sys
import numpy as np, xarray as xr
from stickslip.files.lazy_duck_arrays import wait_for_imports
wait_for_imports()
"""


def answers(code):
    return subprocess.run([sys.executable, "-c", SETUP + code], capture_output=True, text=True, check=True).stdout


def test_a_dataset_is_made_written_and_looked_into_without_dask_and_pint(tmp_path):
    code = f"""
from stickslip.files import reading, writing
from stickslip.dataset.build import cell_coordinates, evaluated_dataset
from stickslip.dataset.provenance import provenance
results = dict(regime=np.ones(5, np.int8), period=np.arange(5.0))
attributes = provenance("", title="t", action="a")
ds = evaluated_dataset(("cell",), (5,), cell_coordinates(dict(mass=1.0), 5), results, attributes)
with reading.look_into(writing.write(ds, {str(tmp_path / "a.nc")!r})) as back:
    print(back["period"].values[3], float(back["period"].isel(cell=slice(1, 3)).sum()))
print(sorted({{"dask", "pint", "numba", "scipy"}} & set(sys.modules)))
"""
    assert answers(code).split("\n")[:2] == ["3.0 3.0", "[]"]


def test_arrays_of_a_library_that_was_imported_are_known():
    code = """
one = xr.Variable("x", np.zeros(4))
import dask.array, pint
lazy = xr.Variable("x", dask.array.zeros(4, chunks=2))
print(isinstance(lazy.data, dask.array.Array), lazy.chunks, (lazy + one).chunks, float(lazy.sum()))
print(xr.Dataset({"a": lazy}).chunk(x=1)["a"].chunks, xr.Dataset({"a": one}).chunk(x=2)["a"].chunks)
metres = xr.Variable("x", pint.UnitRegistry().Quantity(np.ones(4), "m"))
print(metres.data.units, metres.to_numpy().sum())
"""
    assert answers(code).split("\n")[:3] == [
        "True ((2, 2),) ((2, 2),) 0.0", "((1, 1, 1, 1),) ((2, 2),)", "meter 4.0",
    ]  # fmt: skip
