"""What the engine is told of the explorer: its command."""

from stickslip.extensions import Extension

EXTENSION = Extension(commands={"Maps": {"explore": "stickslip_explore.command"}})
