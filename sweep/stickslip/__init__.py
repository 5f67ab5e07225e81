"""Where a friction contact sticks and slips: regime maps of a mass on a moving belt.

The names below are loaded when first used, so that the command line answers at once.
"""

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

from . import extensions
from ._version import __version__

if TYPE_CHECKING:
    from . import plots as plots
    from . import theory as theory
    from .api.cells import evaluate, simulate
    from .api.runs import collect, retry_failed, run, run_shard, status, sweep
    from .api.studies import attractors, border, contours, margins, ramp
    from .config.model import Config
    from .config.reader import load_config
    from .engine import Options
    from .errors import ClusterError, ConfigError, ContradictionError, IncompleteError, Interrupted
    from .files.reading import open
    from .vocabulary.own_laws import Table, register_law

__all__ = [
    "ClusterError", "Config", "ConfigError", "ContradictionError", "IncompleteError", "Interrupted", "Options", "Table",
    "__version__", "attractors", "border", "collect", "contours", "evaluate",
    "load_config", "margins", "open", "ramp", "register_law", "retry_failed", "run", "run_shard",
    "simulate", "status", "sweep",
]  # fmt: skip

_HOMES = {
    "Config": "config.model", "load_config": "config.reader", "Options": "engine",
    "ClusterError": "errors", "ConfigError": "errors", "ContradictionError": "errors", "IncompleteError": "errors",
    "Interrupted": "errors", "open": "files.reading",
    "collect": "api.runs", "retry_failed": "api.runs", "run": "api.runs", "run_shard": "api.runs", "status": "api.runs",
    "sweep": "api.runs", "evaluate": "api.cells", "simulate": "api.cells",
    "attractors": "api.studies", "border": "api.studies", "contours": "api.studies", "margins": "api.studies",
    "ramp": "api.studies",
    "Table": "vocabulary.own_laws", "register_law": "vocabulary.own_laws",
}  # fmt: skip
_MODULES = ("plots", "theory")


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return import_module(f".{name}", __name__)
    if name in _HOMES:
        value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    else:
        value = extensions.call(name, __name__)
    _add_accessor()
    return value


def _add_accessor() -> None:
    """Give datasets `ds.stickslip`, if there are any; where xarray comes later, it loads `backend.py` itself."""
    if "xarray" in sys.modules:
        import_module(".accessor", __name__)


def __dir__() -> list[str]:
    return sorted((*__all__, *_MODULES, *extensions.brought("calls")))


_add_accessor()
