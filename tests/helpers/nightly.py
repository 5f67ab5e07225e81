"""Cases of a test of which a few run everywhere and the others at night."""

from __future__ import annotations

from collections.abc import Iterable

import pytest


def few(cases: Iterable, everywhere: Iterable | int):
    """The cases, of several arguments if they are tuples; slow, but for the first so many, or those among these."""
    cases = list(cases)
    chosen = cases[:everywhere] if isinstance(everywhere, int) else list(everywhere)
    arguments = [case if isinstance(case, tuple) else (case,) for case in cases]
    marks = [() if case in chosen else pytest.mark.slow for case in cases]
    return [pytest.param(*case, marks=mark) for case, mark in zip(arguments, marks, strict=True)]
