"""The map of the article's pair with its exact borders: not a figure of the article, but where many of them lie."""

from __future__ import annotations

from stickslip.api import run
from stickslip.article.recipe import Made
from stickslip.config.examples import config_path
from stickslip.config.reader import load_config
from stickslip.dataset.contours import polylines
from stickslip.designing import contours
from stickslip.plots import plot_map
from stickslip.vocabulary.flags import REGIMES

CONFIG = "contours"  # stickslip run CONFIG follows the same borders


def map_with_borders() -> Made:
    """Regimes over mu_stop and belt speed, and the lines between them; findings say how far each of them runs."""
    config = load_config(config_path(CONFIG))
    assert config.contours is not None
    lines = contours(config, points=config.contours.points, scan=config.contours.scan)
    cells = run(config.model_copy(update={"contours": None}))
    findings: dict[str, float | str] = {"found": str(lines.attrs["contour_found"])}
    for number, line in enumerate(polylines(lines)):
        findings[f"line_{number}"] = f"{REGIMES[line.left]} | {REGIMES[line.right]}"
        findings[f"line_{number}_belt_speed_max"] = float(line.x.max())
    return Made(plot_map(cells, lines=lines), lines, findings)
