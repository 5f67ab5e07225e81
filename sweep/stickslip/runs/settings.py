"""The identity of a run: which keys of a configuration decide its results, and how two configurations differ in them.

The title, the execution section, and of the output section all but `variables` do not; nor does the file a curve was
fitted to, since the fitted coefficients do. A result without some variables is another one: of it they can neither be
taken, nor may they be lost where it replaces one that holds them.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from typing import Any

from stickslip.config.model import Config
from stickslip.config.options import options_of
from stickslip.engine import columns

_LONGEST = 60  # characters of a value that is shown
_NOTHING = "nothing"
_VARIABLES = "output.variables"


def settings(config: Config) -> dict[str, Any]:
    """The settings that numbers depend on, as plain data; axes as a list, since their order is that of the cells."""
    plain = {key: value for key, value in config.resolved().items() if key not in ("title", "output", "execution")}
    plain["friction"] = {key: value for key, value in plain["friction"].items() if key != "fit"}
    variables = kept_variables(config)
    chosen = {} if variables is None else {"output": {"variables": variables}}
    return {**plain, **chosen, "axes": [[name, axis] for name, axis in plain["axes"].items()]}


def kept_variables(config: Config) -> list[str] | None:
    """The variables of a map that are variables; None for all there are, whether they were named or not."""
    variables = config.output.variables
    if variables is None or not config.is_map or set(variables) == set(columns(options_of(config))):
        return None
    return list(variables)


def fingerprint(config: Config) -> str:
    """Equal for configurations of equal results, and only for those."""
    return hashlib.sha256(json.dumps(settings(config), sort_keys=True).encode()).hexdigest()[:32]


def differences(there: Config, here: Config) -> dict[str, tuple[str, str]]:
    """The keys in which two configurations differ, with both values as text, first that of `there`."""
    flat = [dict(_flat(settings(config))) for config in (there, here)]
    names = dict.fromkeys([*flat[0], *flat[1]])
    absent = {name: "all" if name == _VARIABLES else _NOTHING for name in names}
    pairs = {name: (flat[0].get(name, absent[name]), flat[1].get(name, absent[name])) for name in names}
    return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}


def described(differing: dict[str, tuple[str, str]]) -> str:
    """Differences for people, one a line."""
    pairs = differing.items()
    return "\n".join(f"  {name}: {_short(there)} there, {_short(here)} here" for name, (there, here) in pairs)


def _flat(plain: dict[str, Any], path: str = "") -> Iterator[tuple[str, str]]:
    """`solver.rtol`, `1e-06` and so on for nested mappings."""
    for key, value in plain.items():
        if not path and key == "axes":
            yield "order of axes", ", ".join(name for name, _ in value)
            value = dict(value)
        if isinstance(value, dict):
            yield from _flat(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", json.dumps(value, ensure_ascii=False)


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
