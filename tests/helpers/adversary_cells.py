"""Random cells over decades, family by family: what the engine should get right and what it once got wrong.

Drawn in kernel units (m = k = N = 1) and carried to SI by random mass, stiffness and load.
"""

from dataclasses import dataclass

import numpy as np

from judge import DEFAULTS
from judge import layout as at
from judge.curve import slope_of_curve

NAN = float("nan")
LAWS = at.LAWS
CUBIC = LAWS.index("cubic")


def log_uniform(rng, low, high, n):
    return np.exp(rng.uniform(np.log(low), np.log(high), n))


def some(rng, share, n, values, otherwise=0.0):
    """`values` in a share of the cells."""
    return np.where(rng.random(n) < share, values, otherwise)


def article_like(rng, n):
    """Cells like the article's, in kernel units: which the families vary."""
    a3, a4 = log_uniform(rng, 1e-2, 1.0, n), log_uniform(rng, 1e-3, 1.0, n)
    return {name: np.full(n, value) for name, value in DEFAULTS.items()} | {
        "damping": some(rng, 0.5, n, log_uniform(rng, 1e-4, 0.2, n)), "belt_speed": log_uniform(rng, 1e-3, 3.0, n),
        "a1": rng.uniform(0.1, 1.0, n), "a2": some(rng, 0.7, n, log_uniform(rng, 1e-4, 0.3, n)), "a3": a3, "a4": a4,
    }  # fmt: skip


def mu_start(cells):
    return cells["a1"] + cells["a3"]


def exponents(rng, n, most):
    """Of the law that has one: from 1 to `most`, a third of them exactly 2, which is computed in another way."""
    return some(rng, 2.0 / 3.0, n, rng.uniform(1.0, most, n), 2.0)


def started_anywhere(rng, n, cells):
    """Initial states of every kind: at rest, displaced, sliding."""
    size = 1.0 + np.abs(cells["belt_speed"])
    cells["displacement"] = some(rng, 0.5, n, rng.normal(0.0, 1.5, n) * size)
    cells["velocity"] = some(rng, 0.4, n, rng.normal(0.0, 1.5, n) * size, NAN)


def wide(rng, n):
    """Everything over decades, everything allowed."""
    cells = article_like(rng, n)
    cells["damping"] = some(rng, 0.6, n, log_uniform(rng, 1e-5, 30.0, n))
    cells["belt_speed"] = log_uniform(rng, 1e-4, 20.0, n) * np.where(rng.random(n) < 0.15, -1.0, 1.0)
    cells["belt_speed"] = some(rng, 0.97, n, cells["belt_speed"])
    cells["a1"] = some(rng, 0.9, n, log_uniform(rng, 0.03, 2.0, n))
    cells["a2"] = some(rng, 0.8, n, log_uniform(rng, 1e-6, 10.0, n))
    cells["a3"] = np.where((rng.random(n) < 0.9) | (cells["a1"] == 0.0), log_uniform(rng, 1e-4, 3.0, n), 0.0)
    cells["a4"] = log_uniform(rng, 1e-3, 10.0, n)
    cells["delta"] = exponents(rng, n, 4.0)
    cells["mu_stop"] = some(rng, 0.25, n, mu_start(cells) * rng.uniform(0.0, 1.0, n), NAN)
    cells["mu_static"] = some(rng, 0.3, n, mu_start(cells) * (1.0 + log_uniform(rng, 1e-4, 2.0, n)), NAN)
    cells["ageing_rate"] = some(rng, 0.15, n, log_uniform(rng, 1e-4, 0.2, n))
    cells["ageing_time"] = log_uniform(rng, 1e-2, 1e3, n)
    cells["contact_time"] = some(rng, 0.3, n, log_uniform(rng, 1e-2, 1e3, n))
    started_anywhere(rng, n, cells)
    return cells


def steep(rng, n):
    """Belts 5 to 2000 times as fast as friction decays."""
    cells = article_like(rng, n)
    cells["belt_speed"] = log_uniform(rng, 0.01, 10.0, n)
    cells["a4"] = cells["belt_speed"] / log_uniform(rng, 5.0, 2000.0, n)
    cells["a2"] = some(rng, 0.7, n, log_uniform(rng, 1e-4, 0.05, n))
    cells["damping"] = some(rng, 0.5, n, log_uniform(rng, 1e-5, 0.1, n))
    cells["a3"] = log_uniform(rng, 1e-4, 3.0, n)
    cells["mu_static"] = some(rng, 0.3, n, mu_start(cells) * (1.0 + log_uniform(rng, 1e-3, 3.0, n)), NAN)
    cells["delta"] = exponents(rng, n, 3.0)
    return cells


def near_vh(rng, n):
    """Sliding that is about to lose its stability: damping + mu'(belt) is nearly zero."""
    cells = article_like(rng, n)
    cells["delta"] = exponents(rng, n, 3.0)
    cells["law"] = rng.integers(0, len(LAWS), n)
    cells["belt_speed"] = cells["a4"] * rng.uniform(0.2, np.where(cells["law"] == CUBIC, 1.0, 4.0))
    slope = np.array([slope_at_belt(cells, i) for i in range(n)])
    excess = log_uniform(rng, 1e-5, 0.5, n) * np.where(rng.random(n) < 0.5, -1.0, 1.0)
    cells["damping"] = np.maximum(-slope * (1.0 + excess), 0.0)
    cells["velocity"] = some(rng, 0.4, n, cells["belt_speed"] * rng.uniform(-0.5, 1.0, n), NAN)
    sliding = ~np.isnan(cells["velocity"])
    cells["displacement"] = np.where(sliding, mu_start(cells), 0.0)
    return cells


def slope_at_belt(cells, i):
    row = np.zeros(at.CELL_ROWS)
    for name in ("a1", "a2", "a3", "a4", "delta", "law"):
        row[getattr(at, name.upper())] = cells[name][i]
    return slope_of_curve(row, abs(cells["belt_speed"][i]))


def delta(rng, n):
    """The weakening with an exponent."""
    cells = article_like(rng, n)
    cells["delta"] = exponents(rng, n, 4.0)
    cells["belt_speed"] = cells["a4"] * log_uniform(rng, 0.05, 200.0, n)
    started = rng.random(n) < 0.3
    cells["velocity"] = np.where(started, rng.normal(0.0, 1.0, n), NAN)
    return cells


def ageing(rng, n):
    """Static friction that grows, slowly and fast against the load; a time in contact before the start."""
    cells = article_like(rng, n)
    cells["damping"] = some(rng, 0.6, n, log_uniform(rng, 1e-4, 3.0, n))
    cells["ageing_rate"] = log_uniform(rng, 1e-4, 1.0, n)
    cells["ageing_time"] = log_uniform(rng, 1e-3, 1e3, n)
    cells["contact_time"] = some(rng, 0.5, n, log_uniform(rng, 1e-2, 1e4, n))
    cells["mu_static"] = some(rng, 0.4, n, mu_start(cells) * (1.0 + log_uniform(rng, 1e-4, 1.0, n)), NAN)
    return cells


def hysteretic(rng, n):
    """The modified curve, from far below its minimum to above: lines, holds, loops of every scale."""
    cells = article_like(rng, n)
    a2a4 = cells["a3"] * np.exp(-rng.uniform(0.5, 8.0, n))
    cells["a2"] = some(rng, 0.85, n, a2a4 / cells["a4"])
    minimum = cells["a4"] * np.log(cells["a3"] / a2a4)
    cells["belt_speed"] = minimum * log_uniform(rng, 0.02, 3.0, n)
    cells["mu_stop"] = mu_start(cells) * some(rng, 0.8, n, rng.uniform(0.0, 1.0, n), 1.0)
    cells["damping"] = some(rng, 0.6, n, log_uniform(rng, 1e-4, 3.0, n))
    cells["law"] = rng.choice([0, 0, 0, 1, 2, 3], n)
    cells["delta"] = exponents(rng, n, 3.0)
    cells["velocity"] = some(rng, 0.3, n, cells["belt_speed"] * rng.uniform(-2.0, 2.0, n), NAN)
    sliding = ~np.isnan(cells["velocity"])
    cells["displacement"] = np.where(sliding, mu_start(cells) * rng.uniform(0.3, 1.2, n), 0.0)
    return cells


def asymmetric(rng, n):
    """Cycles far from a sine: static friction far above the curve, reverse slip, weak or strong damping."""
    cells = article_like(rng, n)
    cells["a1"] = rng.uniform(0.0, 0.3, n)
    cells["mu_static"] = mu_start(cells) * (1.0 + log_uniform(rng, 0.1, 20.0, n))
    cells["damping"] = some(rng, 0.6, n, log_uniform(rng, 1e-4, 2.0, n))
    cells["belt_speed"] *= np.where(rng.random(n) < 0.3, -1.0, 1.0)
    cells["law"] = rng.integers(0, len(LAWS), n)
    cells["delta"] = exponents(rng, n, 3.0)
    return cells


def strengthening(rng, n):
    """Slopes and drops of the other sign, friction staying positive at the speeds reached."""
    cells = article_like(rng, n)
    weaker = rng.random(n) < 0.5
    cells["a1"] = np.where(weaker, cells["a1"], 0.2 + cells["a3"] + cells["a1"])
    fastest = 10.0 * (1.0 + cells["belt_speed"] + mu_start(cells))
    cells["a2"] = np.where(weaker, -cells["a1"] / fastest * rng.uniform(0.01, 0.5, n), cells["a2"])
    cells["a3"] = np.where(weaker, cells["a3"], -cells["a3"])
    cells["damping"] = some(rng, 0.7, n, log_uniform(rng, 1e-3, 0.5, n))
    return cells


def both_ways(rng, n):
    """Negative damping at the speed of a belt that is far above friction: slip runs both ways."""
    cells = article_like(rng, n)
    cells["law"] = rng.integers(0, len(LAWS), n)
    z = rng.uniform(0.02, np.where(cells["law"] == CUBIC, 1.0, 4.0))  # within the falling part
    cells["a1"], cells["delta"] = log_uniform(rng, 1e-2, 1.0, n), exponents(rng, n, 3.0)
    cells["a4"] = log_uniform(rng, 0.3, 30.0, n) * mu_start(cells) / z
    cells["belt_speed"] = z * cells["a4"]
    slope = np.array([slope_at_belt(cells, i) for i in range(n)])
    cells["damping"] = np.maximum(-slope * (1.0 - log_uniform(rng, 1e-5, 0.9, n)), 0.0)
    return cells


FAMILIES = {
    f.__name__: f for f in (wide, steep, near_vh, delta, ageing, hysteretic, asymmetric, strengthening, both_ways)
}  # fmt: skip
LAWS_OF = {"wide": None, "steep": None, "delta": "stribeck_delta"}  # None: any


def draw(family, n, rng):
    """(laws, cells in SI): n cells of a family; laws (n,) of names, cells arrays by the names of `evaluate`."""
    cells = FAMILIES[family](rng, n)
    if "law" in cells:
        laws = np.array(LAWS)[cells.pop("law")]
    elif LAWS_OF.get(family, "stribeck") is None:
        laws = np.array(LAWS)[rng.integers(0, len(LAWS), n)]
    else:
        laws = np.full(n, LAWS_OF.get(family, "stribeck"))
    # The cubic law is meaningless far beyond its minimum, at a4: belts go up to 1.5 times that speed.
    least = np.abs(cells["belt_speed"]) / rng.uniform(0.3, 1.5, laws.size)
    cells["a4"] = np.where((laws == "cubic") & (cells["a4"] < least), least, cells["a4"])
    mass, stiffness, load = (log_uniform(rng, *ends, n) for ends in ((1e-3, 1e3), (1.0, 1e6), (0.1, 1e4)))
    time, length = np.sqrt(mass / stiffness), load / stiffness
    speed = length / time
    by = {
        "damping": np.sqrt(mass * stiffness), "belt_speed": speed, "a2": 1.0 / speed, "a4": speed, "velocity": speed,
        "displacement": length, "ageing_time": time, "contact_time": time,
    }  # fmt: skip
    si = {name: values * by.get(name, 1.0) for name, values in cells.items()}
    return laws, {"mass": mass, "stiffness": stiffness, "normal_load": load, **si}


def take(columns, chosen):
    """Some of the cells, or of what is known of them."""
    return {name: values[chosen] for name, values in columns.items()}


@dataclass
class Dispute:
    """A cell (arrays of one by name) on which engine and judge disagree."""

    family: str
    law: str
    rtol: float
    horizon: float | None
    cell: dict

    def line(self, what, ours, judged, error):
        """To paste into Python. error : of a number, in units of rtol."""
        given = ", ".join(f"{name}={float(value[0])!r}" for name, value in self.cell.items() if not np.isnan(value[0]))
        how = f", early_stop=False, horizon={self.horizon:.6g}" if self.horizon else ""
        call = f'stickslip.evaluate(dict({given}), rtol={self.rtol:g}, law="{self.law}"{how})'
        return f"{call}  # {self.family}: {what}: ours {ours}, judge {judged} ({error:.3g} rtol)"
