"""Materials compared as a labelled dataset, the best first."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.build import NO_FILL, parameter_variable, shown_in, variable_of
from stickslip.vocabulary.models import FITTED
from stickslip_materials.fit import CurveFit, MaterialFit
from stickslip_materials.variables import MATERIAL_VARIABLES

Floats = NDArray[np.float64]
_CURVE_POINTS = 120
_NONE = np.zeros(0)


def material_dataset(
    fits: Sequence[MaterialFit], results: Mapping[str, Floats], reasons: Sequence[str], attributes: Mapping[str, Any],
    speeds: Sequence[float] = (),
) -> xr.Dataset:  # fmt: skip
    """Numbers and words over `material`, curves over `slip_speed`, measured points over `point`.

    fits : of curves, the best material first. results : by names of MATERIAL_VARIABLES, over materials, and over the
    belt speeds if there are several. reasons : why each is not ranked, beyond what the fit says of itself.
    """
    curves = [fit.curve for fit in fits if fit.curve is not None]
    names = np.array([fit.name for fit in fits], str)
    results = {**results, **_of_fits(curves)}
    points, of_points = _points([fit.points for fit in fits], names)
    grid, drawn = _drawn(curves)
    variables: dict[str, xr.Variable] = {}
    for name, declared in MATERIAL_VARIABLES.items():
        if name in results:
            variables[name] = variable_of(declared, ("material", "belt_speed")[: results[name].ndim], results[name])
    if np.isnan(results["rank"]).any():  # an integer cannot be absent
        variables["rank"] = xr.Variable("material", results["rank"], variables["rank"].attrs)
    fitted = (*FITTED, *(["mu_stop"] if "mu_stop" in results else []))
    for name in fitted:
        ends = np.array([curve.interval.get(name, (np.nan, np.nan)) for curve in curves]).T
        for (which, adjective), values in zip((("low", "lower"), ("high", "upper")), ends, strict=True):
            long_name = f"{adjective} end of the 95 % interval of {name}"
            about = {"units": variables[name].attrs["units"], "long_name": long_name}
            variables[f"{name}_{which}"] = xr.Variable("material", values, about)
    for name in (*fitted, "quiet_above"):
        if f"{name}_low" in variables:
            variables[name].attrs["ancillary_variables"] = f"{name}_low {name}_high"
    qualities = (f"{reason} {curve.quality}".strip() for reason, curve in zip(reasons, curves, strict=True))
    variables["fit_quality"] = _text(qualities, "quality of the fit")
    if any(fit.repeats for fit in fits):
        counts = np.array([max(len(fit.repeats), 1) for fit in fits], np.int32)
        variables["repeats"] = xr.Variable("material", counts, {"units": "1", "long_name": "repeats of the material"})
        repeats = ("; ".join(repeat.name for repeat in fit.repeats) for fit in fits)
        variables["repeat_names"] = _text(repeats, "names of the repeats")
    files = (dict.fromkeys(str(part.path) for part in fit.parts) for fit in fits)
    variables["file"] = _text(map("; ".join, files), "files of the measured points")
    coordinates = of_points | {
        "material": xr.Variable("material", names, {"long_name": "material"}),
        "slip_speed": xr.Variable("slip_speed", grid, {"units": "m s-1", "long_name": "slip speed"}, NO_FILL),
    }
    if any(variable.dims[-1:] == ("belt_speed",) for variable in variables.values()):
        coordinates["belt_speed"] = parameter_variable("belt_speed", ("belt_speed",), speeds)
    ds = xr.Dataset(variables | drawn | points, coordinates, dict(attributes))
    unit = next((fit.points.units["speed"] for fit in fits if "speed" in fit.points.units), None)
    for variable in ds.variables.values():
        if variable.attrs.get("units") == "m s-1":
            shown_in(variable, unit)  # that in which the first file has speeds
    return ds


def speeds_of(ds: xr.Dataset) -> list[float]:
    """The belt speeds (m/s) of a comparison; of a range its ends."""
    if "belt_speed" in ds.coords:
        return [float(speed) for speed in ds["belt_speed"].values]
    return [float(ds.attrs[n]) for n in ("belt_speed", "speed_range_from", "speed_range_to") if n in ds.attrs]


def _of_fits(curves: Sequence[CurveFit]) -> dict[str, Floats]:
    """The numbers of curves, by names of MATERIAL_VARIABLES."""
    columns = {name: [getattr(curve, name) for curve in curves] for name in (*FITTED, "residual_rms", "points")}
    slowest, fastest = zip(*(curve.speeds for curve in curves), strict=True)
    good = [curve.good for curve in curves]
    columns |= {"slowest_point": [*slowest], "fastest_point": [*fastest], "fit_good": good}
    if any("mu_stop" in curve.coefficients() for curve in curves):
        columns["mu_stop"] = [curve.mu_stop for curve in curves]
    return {name: np.array(values, np.float64) for name, values in columns.items()}


def _text(values: Iterable[str], long_name: str) -> xr.Variable:
    return xr.Variable("material", np.array([*values], object), {"long_name": long_name})  # Zarr has no other texts


def _drawn(curves: Sequence[CurveFit]) -> tuple[Floats, dict[str, xr.Variable]]:
    """A grid of speeds, and the curves over it, each between its slowest and its fastest point; NaN elsewhere."""
    ends = [speed for curve in curves for speed in curve.speeds]
    begin = min(speed for speed in [*ends, *(curve.searched[0] * 10 for curve in curves)] if speed > 0)
    grid = np.unique(np.concatenate([np.geomspace(begin, max(ends), _CURVE_POINTS), ends]))
    outside = np.array([(grid < curve.speeds[0]) | (grid > curve.speeds[1]) for curve in curves])
    rows = np.array([[curve.predict(grid), *curve.band(grid)] for curve in curves]).transpose(1, 0, 2)
    names = ("friction", "friction_low", "friction_high")
    return grid, {
        name: variable_of(MATERIAL_VARIABLES[name], ("material", "slip_speed"), np.where(outside, np.nan, values))
        for name, values in zip(names, rows, strict=True)
    }


def _points(
    points: Sequence[Mapping[str, Floats]], names: NDArray[np.str_]
) -> tuple[dict[str, xr.Variable], dict[str, xr.Variable]]:
    """The measured points, one material after the other, and their coordinates."""
    sizes = [table.get("mu", _NONE).size for table in points]
    columns = {"point_friction": [table.get("mu", _NONE) for table in points]}
    if any("sigma" in table for table in points):
        sigmas = [table.get("sigma", np.full(size, np.nan)) for table, size in zip(points, sizes, strict=True)]
        columns["point_sigma"] = sigmas
    speeds = np.concatenate([table.get("speed", _NONE) for table in points])
    owner = np.repeat(names, sizes).astype(object)
    return {
        name: variable_of(MATERIAL_VARIABLES[name], ("point",), np.concatenate(values))
        for name, values in columns.items()
    }, {
        "point_speed": xr.Variable("point", speeds, {"units": "m s-1", "long_name": "measured slip speed"}, NO_FILL),
        "point_material": xr.Variable("point", owner, {"long_name": "material of the point"}),
    }
