"""Where the blocks of a run are computed, as people write it."""

from __future__ import annotations

import re

HERE, LOCAL = "none", "local"  # threads of this process; worker processes of this machine
EXPECTED = f"an address such as tcp://host:8786, a scheduler file (.json), {LOCAL} or {HERE}"
PATTERN = rf"^({HERE}|{LOCAL}|[a-z]{{2,10}}://[^\s/]+:\d{{1,5}}|[^\0]+\.json)$"


def is_address(value: object) -> bool:
    """Whether this names a Dask scheduler: by URL, by its scheduler file, or by one of the two words."""
    return isinstance(value, str) and re.fullmatch(PATTERN, value) is not None
