"""A small configuration to write, run and break."""

from pathlib import Path

TEXT = """\
title: A small map
system: {{mass: 1, normal_load: 1}}
friction: {{a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}}
axes:
  stiffness: {{start: 0.001, stop: 10, num: {num}, spacing: log}}
  belt_speed: {{start: 0.05, stop: 1, num: {num}}}
execution: {{block: {block}}}
"""


def write_config(folder: Path, num: int = 12, block: int = 4096, more: str = "", name: str = "small.yaml") -> Path:
    path = folder / name
    path.write_text(TEXT.format(num=num, block=block) + more)
    return path
