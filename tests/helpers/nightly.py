"""Cases of a test of which a few run everywhere and the others at night."""

from collections.abc import Iterable

import pytest


def few(cases: Iterable, everywhere: Iterable | int):
    """The cases; slow, but for the first so many, or those that are among these."""
    cases = list(cases)
    chosen = cases[:everywhere] if isinstance(everywhere, int) else list(everywhere)
    return [case if case in chosen else pytest.param(case, marks=pytest.mark.slow) for case in cases]
