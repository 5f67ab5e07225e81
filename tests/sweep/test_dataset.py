import subprocess
from datetime import datetime

import numpy as np
import pytest

from helpers.maps import axis, make_grid, make_results, plane
from stickslip.dataset import build as made_by
from stickslip.dataset.build import map_dataset, provenance, trace_dataset
from stickslip.vocabulary.quantities import FLAGS, MODES, PARAMETERS, REGIMES, STATUSES, TRACE_VARIABLES, VARIABLES


def test_every_variable_carries_units_and_long_name():
    ds = plane()
    for name, variable in ds.variables.items():
        declared = PARAMETERS.get(name) or VARIABLES[name]
        assert (variable.attrs["units"], variable.attrs["long_name"]) == (declared.units, declared.long_name)


@pytest.mark.parametrize("flag", ["regime", "status"])
def test_flags_are_int8_with_their_meanings_beside_them(flag):
    variable = plane()[flag]
    assert variable.dtype == np.int8
    assert variable.attrs["flag_values"].dtype == np.int8
    meanings = dict(zip(variable.attrs["flag_meanings"].split(), variable.attrs["flag_values"], strict=True))
    assert tuple(meanings) == {"regime": REGIMES, "status": STATUSES}[flag]
    assert list(meanings.values()) == list(range(len(meanings)))
    for name, message in FLAGS[flag].items():
        assert f"{name}: {message}" in variable.attrs["comment"]


def test_cells_nobody_computed_are_flagged_zero_and_counted_zero():
    grid = make_grid(axis("belt_speed", [0.1, 0.2]))
    ds = map_dataset(grid, {name: np.full(2, np.nan) for name in make_results(grid)}, {})
    assert (ds["regime"] == REGIMES.index("not_computed")).all()
    assert (ds["status"] == STATUSES.index("not_run")).all()
    assert (ds["steps"] == 0).all() and ds["steps"].dtype == np.int32
    assert ds["equilibrium_crossings"].isnull().all(), "a count that was not made is undefined, not zero"


def test_a_trajectory_keeps_the_state_at_the_start_under_names_of_its_own():
    samples = {name: np.zeros(3) for name in TRACE_VARIABLES}
    ds = trace_dataset(
        [0.0, 0.1, 0.2], samples, {"mass": 2.0, "displacement": 0.5}, {"Conventions": "CF-1.11", "title": "t"}
    )
    assert ds["displacement"].dims == ("time",) and ds["displacement_start"] == 0.5
    assert ds["mode"].dtype == np.int8 and ds["mode"].attrs["flag_meanings"] == " ".join(MODES)
    assert ds["time"].attrs["units"] == "s"
    assert "Conventions" not in ds.attrs, "CF would want a date in a coordinate called time"


# --- provenance -------------------------------------------------------------------------------------------------------


def test_provenance_names_source_configuration_and_time():
    found = provenance("title: felt\n", title="Felt", action="run felt.yaml")
    assert found["title"] == "Felt" and found["configuration"] == "title: felt\n"
    assert found["source"].startswith("stickslip ")
    assert found["history"].endswith("run felt.yaml")
    assert datetime.fromisoformat(found["history"].split()[0]) == datetime.fromisoformat(found["date_created"])
    assert "numpy" in found["software"] and "numba" in found["software"]
    assert all(isinstance(value, str) for value in found.values())


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A git repository with one commit, in which build.py seems to lie."""

    def git(*arguments):
        command = ["git", "-c", "user.name=t", "-c", "user.email=t@example.org", *arguments]
        return subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True).stdout.strip()

    file = tmp_path / "sweep/stickslip/dataset/build.py"
    file.parent.mkdir(parents=True)
    file.write_text("")
    try:
        git("init", "-q")
    except FileNotFoundError:
        pytest.skip("git is not installed")
    git("add", ".")
    git("commit", "-q", "-m", "first")
    monkeypatch.setattr(made_by, "__file__", str(file))
    return tmp_path, git("rev-parse", "HEAD")


def test_source_names_the_commit_and_whether_files_differ_from_it_and_needs_no_git(checkout, monkeypatch):
    root, commit = checkout
    assert provenance("", title="")["source"].endswith(f"git {commit}")
    (root / "sweep/stickslip/dataset/build.py").write_text("edited")
    made_by._revision.cache_clear()
    assert made_by.git_revision() == f"{commit}-dirty"
    made_by._revision.cache_clear()
    monkeypatch.setenv("PATH", "")
    assert made_by.git_revision() is None and "git" not in provenance("", title="")["source"]
    inside = root / ".venv/lib/python3.11/site-packages/stickslip/dataset/build.py"  # of a package that is installed
    monkeypatch.undo()
    monkeypatch.setattr(made_by, "__file__", str(inside))
    assert made_by.git_revision() is None
