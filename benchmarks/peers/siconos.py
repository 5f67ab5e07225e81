"""Siconos: listed, not run. Its strength is time-stepping of many contacts with Coulomb friction."""

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
        lambda: "not modelled: no wheel on PyPI, and its cones know no Stribeck curve",
    )
]
