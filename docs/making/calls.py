"""The page of all public calls: tables of their first lines, and for the site their whole docstrings, by autodoc."""

from importlib import import_module
from inspect import getdoc, isclass, isfunction

from making.markdown import code, table
from stickslip import extensions

MODULES = (
    "stickslip", "stickslip.plots", "stickslip.fit", "stickslip.theory", "stickslip.rig", "stickslip.sound",
    "stickslip.accessor",
)  # fmt: skip
HEAD = """# Every call of Python

Every public name, by module. `help(stickslip.run)` shows in a session what the site shows below each table; first
steps are on [python.md](python.md). All numbers are in SI, in and out.
"""


def page() -> str:
    """The whole page, in Markdown."""
    return "\n".join([HEAD, *map(_module, MODULES)])


def _module(module: str) -> str:
    found = import_module(module)
    brought = [name.removeprefix("plots.") for name in extensions.brought("calls")
               if name.startswith("plots.") == (module == "stickslip.plots")]  # fmt: skip
    names = sorted({*found.__all__, *(brought if module in ("stickslip", "stickslip.plots") else ())})
    rows = [(code(name), _first_line(getattr(found, name))) for name in names]
    details = f"```{{eval-rst}}\n.. automodule:: {module}\n   :members:\n   :exclude-members: model_config\n```\n"
    return f"## {module}\n\n{table(('name', 'what it is'), [row for row in rows if row[1]])}\n{details}"


def _first_line(thing: object) -> str:
    return (getdoc(thing) or "").partition("\n")[0] if isclass(thing) or isfunction(thing) else ""
