import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import stickslip
from helpers.maps import plane
from stickslip.dataset.coarse import summary
from stickslip.errors import StoreError
from stickslip.files import reading, writing
from stickslip.files.chunks import SEAL
from stickslip.plots import maps

KINDS = ["nc", "zarr"]
TESTS = Path(__file__).parents[1]


@pytest.fixture(params=KINDS)
def kind(request):
    return request.param


@pytest.fixture
def small_chunks(monkeypatch):
    """Files in many chunks without many cells."""
    monkeypatch.setattr(writing, "_CHUNK_VALUES", 64)
    monkeypatch.setattr(writing, "_LARGER", 1)


def damaged_chunk(path: Path, name: str) -> None:
    """Flip a bit in a chunk of a variable, and nowhere else."""
    file = path if path.is_file() else sorted(p for p in (path / name / "c").rglob("*") if p.is_file())[0]
    good = file.read_bytes()
    for place in range(len(good) // 3, len(good), len(good) // 7):
        file.write_bytes(good[:place] + bytes([good[place] ^ 1]) + good[place + 1 :])
        try:
            with reading.open(path) as ds:
                others = ds.drop_vars(name).load()
                ds[name].load()
        except StoreError as error:
            if f"damaged, {name}[" in str(error):
                assert "regime" in others
                return
    pytest.fail("no chunk was hit")


# --- lazy -------------------------------------------------------------------------------------------------------------


def test_values_wait_in_the_file_in_its_chunks(kind, small_chunks, tmp_path):
    ds = plane(20, 30)
    with stickslip.open(writing.write(ds, tmp_path / f"map.{kind}")) as back:
        assert all(variable.chunks for variable in back.data_vars.values())
        assert back["period"].chunks == ((2,) * 10, (30,))
        assert not any(coordinate.chunks for coordinate in back.coords.values())
        xr.testing.assert_identical(back, ds)


@pytest.mark.parametrize(
    "part",
    [{"stiffness": slice(3, 17, 4)}, {"stiffness": slice(None, None, -3)}, {"stiffness": 5, "belt_speed": slice(2, 2)}]
    + [{"stiffness": [7, 2, 2]}, {"belt_speed": -1}],
)
def test_any_part_can_be_taken(kind, part, small_chunks, tmp_path):
    ds = plane(20, 30)
    with stickslip.open(writing.write(ds, tmp_path / f"map.{kind}")) as back:
        xr.testing.assert_identical(back.isel(part).load(), ds.isel(part))


def test_opened_results_do_whatever_results_in_memory_do(kind, small_chunks, tmp_path):
    ds = plane(20, 30)
    with stickslip.open(writing.write(ds, tmp_path / f"map.{kind}")) as back:
        assert summary(back) == summary(ds)
        mesh, expected = (maps.plot_map(one, "period").axes[0].collections[0].get_array() for one in (back, ds))
        np.testing.assert_array_equal(mesh, expected)
        few = back.isel(stiffness=slice(0, 2), belt_speed=slice(0, 2))
        assert stickslip.evaluate(few.drop_vars(["breakaway_time", "period"]))["regime"].size == 4


def test_nobody_pays_for_dask_or_h5py_who_opens_and_writes_no_file():
    code = "import sys, stickslip.api.runs, stickslip.plots.maps, stickslip.runs.session, stickslip.files.writing\n"
    code += "sys.exit(bool({'dask', 'h5py'} & set(sys.modules)))"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    assert subprocess.run([sys.executable, "-c", code], env=environment).returncode == 0


MEMORY = """
import sys
from stickslip import plots
from stickslip.dataset.coarse import survey
from stickslip.dataset.coarse import summary
from stickslip.files import reading
from helpers.maps import plane

def peak():
    lines = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return int(lines["VmHWM"].split()[0]) / 1024  # MB; ru_maxrss would begin with that of the parent

small = reading.open(sys.argv[2])
summary(small), survey(small), plots.save(plots.plot_map(small), sys.argv[2] + ".png")  # libraries, fonts
before = peak()
ds = reading.open(sys.argv[1])
found = summary(ds)
assert sum(share.cells for share in found.values()) == ds["regime"].size, found
assert sum(survey(ds).counts.values()) == ds["regime"].size
after = peak()
plots.save(plots.plot_map(ds), sys.argv[1] + ".png")
plots.save(plots.plot_map(ds, "period"), sys.argv[1] + ".png")
print(after - before, peak() - before)
"""


def large_file(path: Path, rows: int, columns: int) -> None:
    """A map of which every row repeats one cell, so that it is quickly written."""
    ds = plane(rows, 8)[["regime", "status", "period"]].isel(belt_speed=[3] * columns)
    writing.write(ds.assign_coords(belt_speed=np.linspace(0.02, 0.6, columns)), path)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="peak memory is read from /proc")
@pytest.mark.slow
def test_a_map_of_ten_million_cells_is_counted_listed_and_drawn_in_little_memory(tmp_path):
    large_file(tmp_path / "large.nc", 2500, 4000)
    writing.write(plane(), tmp_path / "small.nc")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path])}
    command = [sys.executable, "-c", MEMORY, str(tmp_path / "large.nc"), str(tmp_path / "small.nc")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    counting, drawing = map(float, done.stdout.split())
    assert counting < 80, "MB; the flags alone are 20, one number of every cell 80"
    assert drawing < 250, "MB; the period alone would be 80, with what is computed from it 300"


# --- damaged ----------------------------------------------------------------------------------------------------------


def test_a_flipped_bit_in_a_chunk_is_found_when_the_chunk_is_read(kind, tmp_path):
    ds = plane(100, 100)[["regime", "status", "period"]]
    ds["period"][:] = np.random.default_rng(1).random((100, 100))  # nothing to compress: most of the file is of it
    path = writing.write(ds, tmp_path / f"map.{kind}")
    damaged_chunk(path, "period")
    with stickslip.open(path) as ds:
        assert summary(ds)
        with pytest.raises(StoreError, match=r"map\.\w+: damaged, period\[0:100, 0:100\] cannot be read \(.*\)\nhint"):
            ds["period"].load()
        with pytest.raises(StoreError, match="damaged, period"):
            maps.plot_map(ds, "period")


@pytest.mark.parametrize("name", ["regime", "steps", "period"])
def test_a_chunk_that_is_lost_is_not_taken_for_undefined_values(name, tmp_path):
    """A flipped bit in the table of chunks makes HDF5 answer with fill values."""
    ds = plane(20, 30).chunk()
    path = writing.write(ds, tmp_path / "map.nc", lambda file: None)  # nobody writes a chunk
    with stickslip.open(path) as back, pytest.raises(StoreError, match=rf"damaged, {name}\[0:20, 0:30\] is not there"):
        back[name].load()


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_file_without_its_end_is_refused(share, tmp_path):
    path = writing.write(plane(60, 60), tmp_path / "map.nc")
    os.truncate(path, int(share * path.stat().st_size))
    with pytest.raises(StoreError, match="map.nc: cannot be read as netCDF"):
        stickslip.open(path)


@pytest.mark.parametrize(
    "piece", ["zarr.json", "regime/c/0/0", "steps/c/0/0", "period/c/0/0", "mass/c", "stiffness/c/0"]
)
def test_a_store_that_lacks_a_piece_is_refused(piece, tmp_path):
    path = writing.write(plane(), tmp_path / "map.zarr")
    (path / piece).unlink()
    with pytest.raises(StoreError, match="map.zarr: "), stickslip.open(path) as ds:
        ds.load()


def test_a_changed_parameter_is_refused_and_what_may_be_edited_is_not(tmp_path):
    import netCDF4

    path = writing.write(plane(), tmp_path / "map.nc")
    with netCDF4.Dataset(path, "a") as file:
        file.history = f"cut out with a knife\n{file.history}"
    stickslip.open(path).close()
    with netCDF4.Dataset(path, "a") as file:
        file["mass"][...] = 2.0
    with pytest.raises(StoreError, match=rf"damaged or changed, .*\nhint: .* remove the global attribute {SEAL}"):
        stickslip.open(path)
    with netCDF4.Dataset(path, "a") as file:
        file.delncattr(SEAL)
    assert float(stickslip.open(path)["mass"]) == 2.0


def test_part_of_a_result_that_xarray_wrote_is_read(kind, tmp_path):
    ds = stickslip.open(writing.write(plane(20, 30), tmp_path / f"map.{kind}"))
    part = ds.isel(stiffness=slice(0, 3))
    part.to_netcdf(tmp_path / "part.nc")
    xr.testing.assert_equal(stickslip.open(tmp_path / "part.nc"), part)
