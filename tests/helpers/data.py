"""Tables in `tests/data`."""

from pathlib import Path

from ruamel.yaml import YAML

DATA = Path(__file__).parents[1] / "data"


def rows(name):
    """What a YAML file there holds."""
    return YAML(typ="safe").load((DATA / name).read_text(encoding="utf-8"))
