"""Materials compared as a labelled dataset, the best first."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.build import NO_FILL, parameter_variable, variable_of
from stickslip.fit import CurveFit, MaterialFit
from stickslip.vocabulary.display_units import DISPLAY
from stickslip.vocabulary.models import FITTED
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import MATERIAL_VARIABLES

_CURVE_POINTS = 120


@dataclass(frozen=True)
class Material:
    """One material: its fit, and its results by names of MATERIAL_VARIABLES; arrays at several belt speeds.

    reason : why it is not ranked, beyond what the fit says of itself.
    """

    fit: MaterialFit
    values: dict[str, Any]
    reason: str = ""


def material_dataset(
    materials: Sequence[Material],
    attributes: Mapping[str, Any],
    speeds: Sequence[float] = (),
    over: Mapping[str, tuple[Sequence[float], NDArray[np.float64]]] | None = None,
) -> xr.Dataset:
    """Numbers and words over `material`, curves over `slip_speed`, measured points over `point`.

    speeds : the belt speeds at which numbers are told, a dimension if there are several. over : by quantity its values,
    and quiet_above (material, values) there.
    """
    rows = [material.values | _of_fit(material.fit) for material in materials]
    fits = [material.fit for material in materials]
    known = [fit.curve for fit in fits if fit.curve is not None]
    variables = {
        name: variable_of(declared, ("material", "belt_speed")[: array.ndim], array)
        for name, declared in MATERIAL_VARIABLES.items()
        if name in rows[0] and (array := np.array([row[name] for row in rows], np.float64)).ndim
    }
    if any(math.isnan(row["rank"]) for row in rows):  # an integer cannot be absent
        ranks = np.array([row["rank"] for row in rows])
        variables["rank"] = xr.Variable("material", ranks, variables["rank"].attrs)
    for name in (*FITTED, "quiet_above"):
        variables[name].attrs["ancillary_variables"] = f"{name}_low {name}_high"
    for name in FITTED:
        for end, (which, adjective) in enumerate({"low": "lower", "high": "upper"}.items()):
            about = {
                "units": variables[name].attrs["units"],
                "long_name": f"{adjective} end of the 95 % interval of {name}",
            }
            variables[f"{name}_{which}"] = xr.Variable("material", [c.interval[name][end] for c in known], about)
    if "quiet_above_low" not in variables:
        del variables["quiet_above"].attrs["ancillary_variables"]
    names = np.array([fit.name for fit in fits], str)
    qualities = [f"{material.reason} {curve.quality}".strip() for material, curve in zip(materials, known, strict=True)]
    variables["fit_quality"] = _text(qualities, "quality of the fit")
    if any(fit.repeats for fit in fits):
        counts = np.array([max(len(fit.repeats), 1) for fit in fits], np.int32)
        variables["repeats"] = xr.Variable("material", counts, {"units": "1", "long_name": "repeats of the material"})
        texts = ["; ".join(repeat.name for repeat in fit.repeats) for fit in fits]
        variables["repeat_names"] = _text(texts, "names of the repeats")
    files = [dict.fromkeys(str(repeat.path) for repeat in fit.repeats or (fit,)) for fit in fits]
    variables["file"] = _text(["; ".join(paths) for paths in files], "files of the measured points")
    curves, grid = _curves(known)
    points, coordinates = _points([fit.points for fit in fits], names)
    coordinates |= {
        "material": xr.Variable("material", names, {"long_name": "material"}),
        "slip_speed": xr.Variable("slip_speed", grid, {"units": "m s-1", "long_name": "slip speed"}, NO_FILL),
    }
    if any(variable.dims[-1:] == ("belt_speed",) for variable in variables.values()):
        coordinates["belt_speed"] = parameter_variable("belt_speed", ("belt_speed",), speeds)
    for name, (places, borders) in (over or {}).items():
        variables[f"quiet_above_over_{name}"] = variable_of(
            MATERIAL_VARIABLES[f"quiet_above_over_{name}"], ("material", name), borders
        )
        coordinates[name] = (
            parameter_variable(name, (name,), places)
            if name in PARAMETERS
            else xr.Variable(name, np.array(places), {"units": "1", "long_name": "scale of friction"}, NO_FILL)
        )
    ds = xr.Dataset(variables | curves | points, coordinates, dict(attributes))
    unit = next((fit.points.units["speed"] for fit in fits if "speed" in fit.points.units), None)
    if unit is not None:  # that in which the first file has speeds
        for variable in ds.variables.values():
            if variable.attrs.get("units") == "m s-1":
                variable.attrs[DISPLAY] = unit
    return ds


def speeds_of(ds: xr.Dataset) -> list[float]:
    """The belt speeds (m/s) of a comparison; of a range its ends."""
    if "belt_speed" in ds.coords:
        return [float(speed) for speed in ds["belt_speed"].values]
    return [float(ds.attrs[n]) for n in ("belt_speed", "speed_range_from", "speed_range_to") if n in ds.attrs]


def _of_fit(fit: MaterialFit) -> dict[str, float]:
    curve = fit.curve
    assert curve is not None
    slowest, fastest = curve.speeds
    return {name: float(getattr(curve, name)) for name in FITTED} | {
        "residual_rms": curve.residual_rms, "points": curve.points, "slowest_point": slowest, "fastest_point": fastest,
        "fit_good": float(curve.good),
    }  # fmt: skip


def _text(values: Sequence[str], long_name: str) -> xr.Variable:
    return xr.Variable("material", np.array(values, object), {"long_name": long_name})  # Zarr has no other texts


def _curves(curves: Sequence[CurveFit]) -> tuple[dict[str, xr.Variable], NDArray[np.float64]]:
    """The fitted curves over a common grid, each between its slowest and its fastest point; NaN elsewhere."""
    ends = [speed for curve in curves for speed in curve.speeds]
    begin = min(speed for speed in [*ends, *(curve.searched[0] * 10 for curve in curves)] if speed > 0)
    grid = np.unique(np.concatenate([np.geomspace(begin, max(ends), _CURVE_POINTS), ends]))
    outside = np.array([(grid < curve.speeds[0]) | (grid > curve.speeds[1]) for curve in curves])
    low, high = zip(*(curve.band(grid) for curve in curves), strict=True)
    columns = {"friction": [c.predict(grid) for c in curves], "friction_low": low, "friction_high": high}
    return {
        name: variable_of(
            MATERIAL_VARIABLES[name], ("material", "slip_speed"), np.where(outside, np.nan, np.array(values))
        )
        for name, values in columns.items()
    }, grid


def _points(
    points: Sequence[Mapping[str, NDArray[np.float64]]], names: NDArray[np.str_]
) -> tuple[dict[str, xr.Variable], dict[str, xr.Variable]]:
    """The measured points, one material after the other, and their coordinates."""
    nothing = np.zeros(0)
    sizes = [table.get("mu", nothing).size for table in points]
    sigma = [table.get("sigma", np.full(size, np.nan)) for table, size in zip(points, sizes, strict=True)]
    friction = np.concatenate([table.get("mu", nothing) for table in points])
    variables = {"point_friction": variable_of(MATERIAL_VARIABLES["point_friction"], ("point",), friction)}
    if any("sigma" in table for table in points):
        variables["point_sigma"] = variable_of(MATERIAL_VARIABLES["point_sigma"], ("point",), np.concatenate(sigma))
    speeds = np.concatenate([table.get("speed", nothing) for table in points])
    owner = np.repeat(names, sizes).astype(object)
    coordinates = {
        "point_speed": xr.Variable("point", speeds, {"units": "m s-1", "long_name": "measured slip speed"}, NO_FILL),
        "point_material": xr.Variable("point", owner, {"long_name": "material of the point"}),
    }
    return variables, coordinates
