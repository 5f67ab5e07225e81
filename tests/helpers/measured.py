"""Shipped tables of measured points and the system they are compared in."""

import numpy as np

from stickslip.config.resolve import points_path

FILES = [points_path(f"configs/measured/{name}.csv") for name in ("dry", "grease_a", "grease_b")]
SYSTEM = {"mass": "100 g", "stiffness": "5 N/mm", "normal_load": "10 N", "damping": "1 N s/m"}
SI = {"mass": 0.1, "stiffness": 5000.0, "normal_load": 10.0, "damping": 1.0}
OPTIONS = ["--mass", "100 g", "--stiffness", "5 N/mm", "--load", "10 N"]


def law(w, a1, a2, a3, a4):
    """Stribeck's curve."""
    return a1 + a2 * w + a3 * np.exp(-w / a4)
