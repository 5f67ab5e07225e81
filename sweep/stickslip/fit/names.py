"""What materials are called: after their files and columns, no two alike."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path


def names_of(paths: Sequence[Path]) -> list[str]:
    """A name for each file: its stem, with as many folders before it as tell it from the others."""
    depth = 1
    parts = [(*path.parts[:-1], path.stem) for path in paths]
    names = [whole[-1] for whole in parts]
    while len(set(names)) < len(names) and depth < max(map(len, parts)):
        depth += 1
        twice = {name for name, count in Counter(names).items() if count > 1}
        names = ["/".join(w[-depth:]) if name in twice else name for name, w in zip(names, parts, strict=True)]
    return numbered(names)


def numbered(names: Sequence[str]) -> list[str]:
    """The names, those that occur again with a number."""
    seen: Counter[str] = Counter()
    found: list[str] = []
    for name in names:
        seen[name] += 1
        found.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return found
