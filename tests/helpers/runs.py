"""Runs stopped on the way, and results compared to the bit."""

import os
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr

import stickslip

DATES = ("history", "date_created")


def same(found, expected):
    """Identical, but for when it was made."""
    xr.testing.assert_identical(*(ds.drop_attrs(deep=False).assign_attrs(
        {k: v for k, v in ds.attrs.items() if k not in DATES}) for ds in (found.load(), expected)))  # fmt: skip
    for name, values in expected.variables.items():
        assert found[name].dtype == values.dtype, name
        if values.dtype.kind == "f":
            np.testing.assert_array_equal(found[name].values.view("i8"), values.values.view("i8"), err_msg=name)


def interrupted_after(count):
    """Progress that presses Ctrl-C once so many cells are done."""

    def progress(done, of):
        if done >= count:
            raise KeyboardInterrupt

    return progress


def until(condition, patience=60.0):
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.01)


def block_files(folder):
    return sorted(name for name in os.listdir(folder) if name.startswith("block-"))


def opened(path):
    with stickslip.open(path) as ds:
        return ds.load()


def stop_early(config, output, cells=200, **options):
    with pytest.raises(stickslip.Interrupted) as caught:
        stickslip.run(config, output, progress=interrupted_after(cells), **options)
    return caught.value


def with_axes(path, stiffness, speeds):
    path.write_text(
        "system: {mass: 1, normal_load: 1}\nfriction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}\n"
        f"axes:\n  stiffness: {stiffness}\n  belt_speed: {speeds}\n"
    )
    return path


FEW, MANY = [1.0, 2.0, 5.0], [0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 9.0]


# --- in processes of their own ----------------------------------------------------------------------------------------


def environment(**more):
    return os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "PYTHONWARNINGS": "ignore"} | more


def started(*arguments, **options):
    """The command, under way."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment()}
    return subprocess.Popen([sys.executable, "-m", "stickslip", *map(str, arguments)], **pipes | options)


def called(*arguments, **options):
    """Its exit code, and what it wrote to both channels."""
    process = started(*arguments, **options)
    out, errors = process.communicate(timeout=120)
    assert "Traceback" not in errors, errors
    return process.returncode, out, errors
