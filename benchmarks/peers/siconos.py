"""Siconos: listed, not tried yet."""

from __future__ import annotations

from peers import Peer


def solve(cells, horizon, rtol):
    raise NotImplementedError


PEERS = [
    Peer(
        "Siconos",
        "time-stepping",
        solve,
        {},
        lambda: "not tried yet: nobody has written this model for it here",
    )
]
