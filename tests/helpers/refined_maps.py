"""A refined map held against its full grid, of which nothing but the regimes is kept."""

from dataclasses import dataclass
from time import perf_counter

import stickslip
from stickslip.config.model import Config
from stickslip.config.reader import make_config

CURVES = {"plain": None, "hysteretic": 1.1}  # mu_stop


def map_config(n: int, mu_stop: float | None, **refine: object) -> Config:
    """The article's map: stiffness by belt speed, up to speeds where stick-slip has ended."""
    friction = {"a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1} | ({} if mu_stop is None else {"mu_stop": mu_stop})
    axes = {
        "stiffness": {"start": 0.1, "stop": 100, "num": n, "spacing": "log"},
        "belt_speed": {"start": 0.02, "stop": 1.2, "num": n},
    }
    system = {"mass": 1, "normal_load": 1}
    return make_config({"system": system, "friction": friction, "axes": axes, "refine": dict(refine)})


@dataclass(frozen=True)
class Compared:
    """A refined map beside the full grid: cells, those computed for it, those wrong, its audit, and seconds of both."""

    cells: int
    computed: int
    wrong: int
    bound: float
    tried: int
    seconds: float
    seconds_full: float


def compared(config: Config) -> Compared:
    """Compute a refined map and its full grid on all threads."""
    stickslip.run(map_config(64, None), progress=False)  # kernels and imports
    given, seconds, maps = config.resolved(), [], []
    refine = {"refine": given.pop("refine"), "output": {"variables": ["regime"]}}
    for more in (refine, {"output": {"variables": ["regime", "period"]}}):  # the full grid with all that is computed
        began = perf_counter()
        maps.append(stickslip.run(make_config(given | more), progress=False))
        seconds.append(perf_counter() - began)
    refined, full = (ds["regime"].values for ds in maps)
    about = [maps[0].attrs[name] for name in ("refine_cells_computed", "audit_bound", "audit_points")]
    return Compared(full.size, about[0], int((refined != full).sum()), *about[1:], *seconds)
