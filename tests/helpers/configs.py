"""Small configurations: one to write and run, others to break."""

from pathlib import Path

import pytest

from stickslip.config.grid import cell_of, config_at
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError

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


def cell_at(recipe, settings) -> dict[str, float]:
    """Parameters of one cell of a configuration or a result, in SI."""
    return cell_of(config_at(recipe, settings))


GOOD = """\
title: A map
system:
  mass: 1 kg
  stiffness: 10
  normal_load: 5 N
  belt_speed: 10 mm/s
friction:
  a1: 1
  a2: 0.1
  a3: 0.3
  a4: 0.1
"""
HOSTILE = r"""title: '$$\href{javascript:window.hit=1}{click}$$ </script><script>window.hit=2</script>'
system: {mass: 1, normal_load: 1, stiffness: 1}
friction: {a1: 1, a2: 0.1, a4: 0.1}
axes:
  grease:
    zip: {a3: [0.3, 0.2]}
    labels: ['$$\href{javascript:window.hit=3}{click}$$', '\(x^2\) <img src=x onerror="window.hit=4">']
  sleeve:
    zip: {damping: [0.0, 0.1, 0.2]}
    labels: ['$$\href{javascript:window.hit=5}{click}$$', '<img src=x>', '\[x\] </pre><a>']
  belt_speed: {start: 0.05, stop: 1, num: 8}
"""
MEASURED_FORM = (
    GOOD[: GOOD.index("friction")]
    + """\
friction:
  mu_start: 0.4
  mu_reversal: 0.3
  v_reversal: 0.2
  a4: 0.05
"""
)


def with_line(number: int, *lines: str, text: str = GOOD) -> str:
    """`text` with one line replaced by others."""
    all_lines = text.splitlines()
    all_lines[number - 1 : number] = lines
    return "\n".join(all_lines) + "\n"


def message(text: str) -> str:
    """What is wrong with a configuration, in full."""
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "map.yaml")
    return str(caught.value)
