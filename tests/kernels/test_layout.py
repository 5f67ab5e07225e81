"""Rows of lanes: files that work together have none in common, but on purpose."""

import ast
from itertools import combinations
from pathlib import Path

import pytest

from stickslip_kernels import contacts
from stickslip_kernels import layout as at

KERNELS = Path(at.__file__).parent
OF_REGIMES = {name for name, row in vars(at).items() if name.isupper() and isinstance(row, int)
              if at.STABLE_FROM <= row < at.GATHERED and row % at.WIDTH == 0} - {"GATHERED", "NODES"}  # fmt: skip
OF_RECURRENCE = ("recurrence", "return_map", "loops", "long_cycles", "irregular")
# What each machine is made of, where files take rows: any two of one line are at work together.
MACHINES = (
    ("contacts.explicit", "contacts.bristles", "contacts.lugre"),
    ("contacts.explicit", "contacts.rate_state_laws", "contacts.regularised"),
    tuple(f"observers.{name}" for name in OF_RECURRENCE),
)


def rows_taken(name):
    """The names at which a file unpacks rows of its own, and those rows."""
    contacts.files()  # all of them are loaded
    module = __import__(f"stickslip_kernels.{name}", fromlist=["_"])
    tree = ast.parse((KERNELS / f"{name.replace('.', '/')}.py").read_text(encoding="utf-8"))
    names = [
        each.id
        for node in tree.body
        if isinstance(node, ast.Assign) and ".take(" in ast.unparse(node.value)
        for each in ast.walk(node)
        if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store) and not each.id.startswith("_")
    ]
    return {each: getattr(module, each) for each in names if isinstance(getattr(module, each), int)}


@pytest.mark.parametrize("files", MACHINES)
def test_no_two_files_of_a_machine_take_a_row(files):
    taken = {name: rows_taken(name) for name in files}
    assert all(taken.values())
    rows = [row for own in taken.values() for row in own.values()]
    assert len(set(rows)) == len(rows), [
        (one, other) for one, other in combinations(taken, 2) if set(taken[one].values()) & set(taken[other].values())
    ]


def test_more_rows_than_there_are_are_refused():
    rows = at.Rows(at.CONTACT, at.SERIES)
    first = rows.take(at.CONTACT_ROWS - 2)
    assert set(first).isdisjoint(rows.beside().take(2))
    with pytest.raises(ValueError, match="3 rows of lanes, of 2 that are left"):
        rows.take(3)


def test_recurrence_names_no_row_that_it_has_for_something_else():
    for name in (*(f"observers/{name}" for name in OF_RECURRENCE), "contacts/smooth", "contacts/explicit",
                 "contacts/bristles", "contacts/lugre", "contacts/rate_and_state", "contacts/regularised"):  # fmt: skip
        tree = ast.parse((KERNELS / f"{name}.py").read_text(encoding="utf-8"))
        named = {
            node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "at"
        }
        assert named.isdisjoint(OF_REGIMES), name
