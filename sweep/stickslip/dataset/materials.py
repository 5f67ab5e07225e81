"""Materials compared as a labelled dataset, the best first."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.build import parameter_variable, variable_of
from stickslip.fit import MaterialFit
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import MATERIAL_VARIABLES

_CURVE_POINTS = 120
_NO_FILL = {"_FillValue": None}
_COEFFICIENTS = ("a1", "a2", "a3", "a4", "mu_start")


@dataclass(frozen=True)
class Material:
    """One material: its fit, and what was found, by names of MATERIAL_VARIABLES; an array at several belt speeds.

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
    rows = [one.values | _of_fit(one.fit) for one in materials]
    variables = {
        name: variable_of(declared, ("material", "belt_speed")[: array.ndim], array)
        for name, declared in MATERIAL_VARIABLES.items()
        if name in rows[0] and (array := np.array([row[name] for row in rows], np.float64)).ndim
    }
    if any(math.isnan(row["rank"]) for row in rows):  # an integer cannot be absent
        ranks = np.array([row["rank"] for row in rows])
        variables["rank"] = xr.Variable("material", ranks, variables["rank"].attrs)
    for name in (*_COEFFICIENTS, "quiet_above"):
        variables[name].attrs["ancillary_variables"] = f"{name}_low {name}_high"
    for name in _COEFFICIENTS:
        unit = variables[name].attrs["units"]
        for end, which in enumerate(("low", "high")):
            values = np.array([one.fit.curve.interval[name][end] for one in materials if one.fit.curve is not None])
            told = {"units": unit, "long_name": f"{('lower', 'upper')[end]} end of the 95 % interval of {name}"}
            variables[f"{name}_{which}"] = xr.Variable("material", values, told)
    if "quiet_above_low" not in variables:
        del variables["quiet_above"].attrs["ancillary_variables"]
    names = np.array([one.fit.name for one in materials], str)
    variables["fit_quality"] = _text(
        [f"{one.reason} {one.fit.curve.quality}".strip() for one in materials if one.fit.curve], "quality of the fit"
    )
    if any(one.fit.repeats for one in materials):
        counts = np.array([max(len(one.fit.repeats), 1) for one in materials], np.int32)
        variables["repeats"] = xr.Variable("material", counts, {"units": "1", "long_name": "repeats of the material"})
        texts = ["; ".join(each.name for each in one.fit.repeats) for one in materials]
        variables["repeat_names"] = _text(texts, "names of the repeats")
    files = [dict.fromkeys(str(each.path) for each in one.fit.repeats or (one.fit,)) for one in materials]
    variables["file"] = _text(["; ".join(paths) for paths in files], "files of the measured points")
    curves, grid = _curves(materials)
    points, coordinates = _points(materials, names)
    coordinates |= {
        "material": xr.Variable("material", names, {"long_name": "material"}),
        "slip_speed": xr.Variable("slip_speed", grid, {"units": "m s-1", "long_name": "slip speed"}, _NO_FILL),
    }
    if any(one.dims[-1:] == ("belt_speed",) for one in variables.values()):
        coordinates["belt_speed"] = parameter_variable("belt_speed", ("belt_speed",), speeds)
    for name, (places, borders) in (over or {}).items():
        variables[f"quiet_above_over_{name}"] = variable_of(
            MATERIAL_VARIABLES[f"quiet_above_over_{name}"], ("material", name), borders
        )
        coordinates[name] = (
            parameter_variable(name, (name,), places)
            if name in PARAMETERS
            else xr.Variable(name, np.array(places), {"units": "1", "long_name": "scale of friction"}, _NO_FILL)
        )
    ds = xr.Dataset(variables | curves | points, coordinates, dict(attributes))
    return _with_display_units(ds, materials)


def speeds_of(ds: xr.Dataset) -> list[float]:
    """The belt speeds (m/s) that a comparison was asked about; of a range its ends."""
    if "belt_speed" in ds.coords:
        return [float(speed) for speed in ds["belt_speed"].values]
    return [float(ds.attrs[n]) for n in ("belt_speed", "speed_range_from", "speed_range_to") if n in ds.attrs]


def _of_fit(fit: MaterialFit) -> dict[str, float]:
    curve = fit.curve
    assert curve is not None
    found = {name: float(getattr(curve, name)) for name in _COEFFICIENTS}
    slowest, fastest = curve.speeds
    return found | {
        "residual_rms": curve.residual_rms, "points": curve.points, "slowest_point": slowest, "fastest_point": fastest,
        "fit_good": float(curve.good),
    }  # fmt: skip


def _text(values: Sequence[str], long_name: str) -> xr.Variable:
    return xr.Variable("material", np.array(values, object), {"long_name": long_name})  # Zarr has no other texts


def _curves(materials: Sequence[Material]) -> tuple[dict[str, xr.Variable], NDArray[np.float64]]:
    """The fitted curves over a common grid, each between its slowest and its fastest point; NaN elsewhere."""
    curves = [one.fit.curve for one in materials if one.fit.curve is not None]
    slowest, fastest = min(one.speeds[0] for one in curves), max(one.speeds[1] for one in curves)
    ends = [speed for one in curves for speed in one.speeds]
    begin = min(speed for speed in [*ends, *(one.searched[0] * 10 for one in curves)] if speed > 0)
    grid = np.unique(np.concatenate([np.geomspace(begin, fastest, _CURVE_POINTS), ends, [slowest]]))
    found = {}
    bands = [one.band(grid) for one in curves]
    columns = {
        "friction": [one.predict(grid) for one in curves], "friction_low": [band[0] for band in bands],
        "friction_high": [band[1] for band in bands],
    }  # fmt: skip
    outside = np.array([(grid < one.speeds[0]) | (grid > one.speeds[1]) for one in curves])
    for name, values in columns.items():
        shown = np.where(outside, np.nan, np.array(values))
        found[name] = variable_of(MATERIAL_VARIABLES[name], ("material", "slip_speed"), shown)
    return found, grid


def _points(
    materials: Sequence[Material], names: NDArray[np.str_]
) -> tuple[dict[str, xr.Variable], dict[str, xr.Variable]]:
    """What was measured, one material after the other."""
    points = [one.fit.points for one in materials]
    sizes = [one["mu"].size if "mu" in one else 0 for one in points]
    nothing = np.zeros(0)
    sigma = [one.get("sigma", np.full(size, np.nan)) for one, size in zip(points, sizes, strict=True)]
    friction = np.concatenate([one.get("mu", nothing) for one in points])
    variables = {"point_friction": variable_of(MATERIAL_VARIABLES["point_friction"], ("point",), friction)}
    if any("sigma" in one for one in points):
        variables["point_sigma"] = variable_of(MATERIAL_VARIABLES["point_sigma"], ("point",), np.concatenate(sigma))
    speeds = np.concatenate([one.get("speed", nothing) for one in points])
    owner = np.repeat(names, sizes).astype(object)
    coordinates = {
        "point_speed": xr.Variable("point", speeds, {"units": "m s-1", "long_name": "measured slip speed"}, _NO_FILL),
        "point_material": xr.Variable("point", owner, {"long_name": "material of the point"}),
    }
    return variables, coordinates


def _with_display_units(ds: xr.Dataset, materials: Sequence[Material]) -> xr.Dataset:
    """The dataset; speeds know the unit in which the first file wrote them."""
    written = next((one.fit.points.units["speed"] for one in materials if "speed" in one.fit.points.units), None)
    if written is not None:
        for variable in ds.variables.values():
            if variable.attrs.get("units") == "m s-1":
                variable.attrs["display_units"] = written
    return ds
