"""What ships, but for what asks for an extension of ours that is not installed.

With folders of extensions deleted the tests of the engine pass. Where all of them are there, nothing is left out.
"""

import tomllib
from pathlib import Path

import pytest

from helpers.commands import commands_of
from stickslip import extensions
from stickslip.config.reader import load_config
from stickslip.config.resolve import config_names, config_path
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
    """Names of the configurations that ship, and that can be read here."""
    return [name for name in config_names() if not MISSING or _is_read(name)]


def _is_read(name: str) -> bool:
    try:
        load_config(config_path(name))
    except ConfigError:
        return False
    return True
