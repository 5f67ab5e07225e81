"""Where a friction contact sticks and slips: regime maps of a mass on a moving belt.

The names below are loaded when first used, so that the command line answers at once.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._version import __version__

if TYPE_CHECKING:
    from .api import Interrupted, evaluate, open, run, simulate
    from .config import Config, ConfigError, load_config
    from .engine import Options

__all__ = [
    "Config", "ConfigError", "Interrupted", "Options", "__version__",
    "evaluate", "load_config", "open", "run", "simulate",
]  # fmt: skip

_HOMES = {
    "Config": "config", "ConfigError": "config", "load_config": "config", "Options": "engine",
    "Interrupted": "api", "evaluate": "api", "open": "api", "run": "api", "simulate": "api",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
