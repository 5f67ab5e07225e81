"""The starting states of a configuration that asks for attractors."""

from __future__ import annotations

from collections.abc import Iterator

from stickslip.config.model import Config, Group
from stickslip.config.rules import members
from stickslip.errors import Path

_STATE = ("displacement", "velocity")
STATES_IN_BOX = "expected no axis: the starting states are those of the box (attractors)"


def state_axes(config: Config) -> Iterator[Path]:
    """The axes along which a starting state varies."""
    for axis in config.axes:
        for member in members(axis):
            if member.name in _STATE:
                yield ("axes", axis.name, "zip", member.name) if isinstance(axis, Group) else ("axes", axis.name)
