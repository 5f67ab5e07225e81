"""Tables in `tests/data`."""

from functools import cache
from pathlib import Path

import pytest
from ruamel.yaml import YAML

DATA = Path(__file__).parents[1] / "data"


@cache
def rows(name):
    """What a YAML file there holds."""
    return YAML(typ="safe").load((DATA / name).read_text(encoding="utf-8"))


def cases(name):
    """A test runs for each row that such a file has under its module and its name, after the names of its arguments;
    rows may have names themselves, the first `arguments`."""

    def with_cases(test):
        table = rows(name)[test.__module__.rpartition(".")[2]][test.__name__]
        arguments, *values = table.values() if isinstance(table, dict) else table
        ids = list(table)[1:] if isinstance(table, dict) else None
        return pytest.mark.parametrize(arguments, values, ids=ids)(test)

    return with_cases
