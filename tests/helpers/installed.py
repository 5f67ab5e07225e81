"""What ships and what pages show, but for what asks for an extension of ours that is not installed.

With folders of extensions deleted the tests of the engine pass. Where all of them are there, nothing is left out.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

import stickslip
from helpers.commands import commands_of
from stickslip import extensions
from stickslip.accessor import StickslipAccessor
from stickslip.config.resolve import config_names, config_path
from stickslip.config.schema import json_schema
from stickslip.config.yaml import parse_yaml
from stickslip.errors import ConfigError

_PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DECLARED: dict[str, str] = _PROJECT["entry-points"][extensions.GROUP]
MISSING = sorted({*DECLARED} - {*extensions.named()})
all_installed = pytest.mark.skipif(
    bool(MISSING), reason=f"about all extensions together, of which are not installed: {', '.join(MISSING)}"
)


def is_command(name: str) -> bool:
    """Whether a command is there: any is expected where nothing is missing."""
    return not MISSING or name in commands_of()


def shipped() -> list[str]:
    """Names of the configurations that ship."""
    return [name for name in config_names() if not configuration_asks_for_more(config_path(name).read_text("utf-8"))]


def configuration_asks_for_more(text: str) -> bool:
    """Whether a YAML text has a section that nobody here knows, or names a file that nobody here reads."""
    if not MISSING:
        return False
    try:
        data = parse_yaml(text).data
    except ConfigError:
        return False
    return isinstance(data, dict) and (not {*data} <= {*json_schema()["properties"]} or _names_a_file(data))


def _names_a_file(value: object) -> bool:
    """Whether points or draws are read from files: `fit`, `explained`, and `table` unless the points are there."""
    if isinstance(value, list):
        return any(map(_names_a_file, value))
    if not isinstance(value, dict):
        return False
    table = value.get("table", {})
    return (
        not {"fit", "explained"}.isdisjoint(value)
        or isinstance(table, str)
        or "file" in table
        or any(map(_names_a_file, value.values()))
    )


def code_asks_for_more(text: str) -> bool:
    """Whether Python or a command line names a call, a command or a configuration that is not there."""
    if not MISSING:
        return False
    methods = {*dir(StickslipAccessor), *extensions.brought("methods")}
    called = re.findall(r"(\w+\.)?stickslip\.(\w+)(?:\.(\w+))?", text)
    imported = re.findall(r"from stickslip import ([\w, ]+)", text)
    commands = re.findall(r"^(?:\$ )?stickslip (?:help )?([a-z]+)", text, re.MULTILINE)
    configurations = re.findall(r"\bconfigs/([\w/]+)\.yaml", text)
    return (
        not all(name in methods if of else _offered(name, inner) for of, name, inner in called)
        or not all(_offered(name.strip()) for names in imported for name in names.split(","))
        or not all(map(is_command, commands))
        or any(name in config_names() and name not in shipped() for name in configurations)
    )


def _offered(name: str, inner: str = "") -> bool:
    return hasattr(stickslip, name) and (not inner or hasattr(getattr(stickslip, name), inner))
