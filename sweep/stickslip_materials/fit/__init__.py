"""Fits to measured points: friction over slip speed (`fit_curve`), static friction over waiting time (`fit_ageing`).

Every fit comes with 95 % confidence intervals and with `quality`, a plain sentence on what the points do not determine.
"""

from stickslip.vocabulary.quantities import AGEING_COLUMNS, CURVE_COLUMNS
from stickslip_materials.fit.ageing import AgeingFit, Rank, Ranking, fit_ageing, rank
from stickslip_materials.fit.curve import CurveFit, Drawn, draw_curves
from stickslip_materials.fit.files import MaterialFit, fit_ageing_file, fit_file, fit_materials
from stickslip_materials.fit.fitting import fit_curve
from stickslip_materials.fit.points import read_materials, read_points
from stickslip_materials.fit.roles import Wanted
from stickslip_materials.fit.steps import StepPoints, read_steps, step_points, write_points

__all__ = [
    "AGEING_COLUMNS", "AgeingFit", "CURVE_COLUMNS", "CurveFit", "Drawn", "MaterialFit", "Rank", "Ranking", "StepPoints",
    "Wanted", "draw_curves", "fit_ageing", "fit_ageing_file", "fit_curve", "fit_file", "fit_materials", "rank",
    "read_materials", "read_points", "read_steps", "step_points", "write_points",
]  # fmt: skip
