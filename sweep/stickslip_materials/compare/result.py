"""Materials compared, as a kind of result: the dataset, and what is told of it on screen, to programs and in tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.studies import ReportTable, Result
from stickslip.dataset.build import NO_FILL, parameter_variable, shown_in, variable_of
from stickslip.vocabulary.display_units import DISPLAY
from stickslip.vocabulary.models import FITTED
from stickslip.vocabulary.parameter import Variable, table
from stickslip.vocabulary.quantities import FLAGS, QUIET_STATES, SEARCHABLE, VARIABLES
from stickslip_materials.fit import CurveFit, MaterialFit

Floats = NDArray[np.float64]
_CURVE_POINTS = 120

MATERIAL_VARIABLES: dict[str, Variable] = table(
    Variable("rank", "1", "rank of the material, 1 for the one that is quiet from the lowest speed on",
             comment="NaN: not determined, see quiet_state and fit_quality"),
    Variable("quiet_above", "m s-1", "belt speed above which the pair is quiet",
             comment="no stick-slip and no other lasting vibration that began in stick; see quiet_state"),
    Variable("quiet_state", "1", "what the speed above which the pair is quiet is"),
    Variable("quiet_above_low", "m s-1", "lower end of the confidence interval of quiet_above",
             comment="0: no vibration at any speed searched; NaN: the points do not determine it"),
    Variable("quiet_above_high", "m s-1", "upper end of the confidence interval of quiet_above",
             comment="inf: vibration up to the fastest speed searched; NaN: the points do not determine it"),
    Variable("margin", "1", "belt speed over quiet_above",
             comment="above 1: quiet; of a range of belt speeds that of its slowest"),
    Variable("worst_speed", "m s-1", "belt speed of a range at which the vibration is largest",
             comment="its slowest where it is quiet throughout"),
    Variable("quiet_probability", "1", "probability of being quiet at the belt speed and above",
             comment="as far as the scatter of the points goes; draws without a verdict do not count as quiet"),
    *(VARIABLES[name] for name in ("regime", "frequency", "stick_fraction")),
    *(Variable(name, SEARCHABLE[name].units, SEARCHABLE[name].long_name) for name in (*FITTED, "mu_stop")),
    Variable("residual_rms", "1", "residual of the fit, root mean square"),
    Variable("points", "1", "measured points"),
    Variable("slowest_point", "m s-1", "slowest measured speed"),
    Variable("fastest_point", "m s-1", "fastest measured speed"),
    Variable("fit_good", "1", "whether the points determine the curve"),
    Variable("friction", "1", "friction coefficient of the fitted curve"),
    Variable("friction_low", "1", "lower end of the 95 % band of the fitted curve"),
    Variable("friction_high", "1", "upper end of the 95 % band of the fitted curve"),
    Variable("point_friction", "1", "measured friction coefficient"),
    Variable("point_sigma", "1", "standard deviation of the measured friction coefficient"),
)  # fmt: skip


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
    variables = {name: variable_of(declared, ("material", "belt_speed")[: results[name].ndim], results[name])
                 for name, declared in MATERIAL_VARIABLES.items() if name in results}  # fmt: skip
    if np.isnan(results["rank"]).any():  # an integer cannot be absent
        variables["rank"] = xr.Variable("material", results["rank"], variables["rank"].attrs)
    for name in (*FITTED, *(["mu_stop"] if "mu_stop" in results else [])):
        ends = np.array([curve.interval.get(name, (np.nan, np.nan)) for curve in curves]).T
        for (which, adjective), values in zip((("low", "lower"), ("high", "upper")), ends, strict=True):
            long_name = f"{adjective} end of the 95 % interval of {name}"
            about = {"units": variables[name].attrs["units"], "long_name": long_name}
            variables[f"{name}_{which}"] = xr.Variable("material", values, about)
    for name, variable in variables.items():
        if f"{name}_low" in variables:
            variable.attrs["ancillary_variables"] = f"{name}_low {name}_high"
    qualities = (f"{reason} {curve.quality}".strip() for reason, curve in zip(reasons, curves, strict=True))
    variables["fit_quality"] = _text("material", qualities, "quality of the fit")
    variables["file"] = _text("material", (str(fit.path) for fit in fits), "files of the measured points")
    coordinates = {"material": xr.Variable("material", names, {"long_name": "material"})}
    if any(variable.dims[-1:] == ("belt_speed",) for variable in variables.values()):
        coordinates["belt_speed"] = parameter_variable("belt_speed", ("belt_speed",), speeds)
    ds = xr.Dataset(variables, coordinates, dict(attributes)).merge(_drawn(curves)).merge(_points(fits))
    unit = next((fit.points.units["speed"] for fit in fits if "speed" in fit.points.units), None)
    for variable in ds.variables.values():
        if variable.attrs.get("units") == "m s-1":
            shown_in(variable, unit)  # that in which the first file has speeds
    return ds


def _of_fits(curves: Sequence[CurveFit]) -> dict[str, Floats]:
    """The numbers of curves, by names of MATERIAL_VARIABLES."""
    columns: dict[str, Sequence[float]] = {
        name: [getattr(curve, name) for curve in curves] for name in (*FITTED, "residual_rms", "points")
    }
    slowest, fastest = zip(*(curve.speeds for curve in curves), strict=True)
    columns |= {"slowest_point": slowest, "fastest_point": fastest, "fit_good": [curve.good for curve in curves]}
    if any("mu_stop" in curve.coefficients() for curve in curves):
        columns["mu_stop"] = [curve.mu_stop for curve in curves]
    return {name: np.array(values, np.float64) for name, values in columns.items()}


def _text(dim: str, values: Iterable[str], long_name: str) -> xr.Variable:
    return xr.Variable(dim, np.array([*values], object), {"long_name": long_name})  # Zarr has no other texts


def _drawn(curves: Sequence[CurveFit]) -> xr.Dataset:
    """The curves over a grid of speeds, each between its slowest and its fastest point; NaN elsewhere."""
    ends = [speed for curve in curves for speed in curve.speeds]
    begin = min(speed for speed in [*ends, *(curve.searched[0] * 10 for curve in curves)] if speed > 0)
    grid = np.unique(np.concatenate([np.geomspace(begin, max(ends), _CURVE_POINTS), ends]))
    outside = np.array([(grid < curve.speeds[0]) | (grid > curve.speeds[1]) for curve in curves])
    rows = np.array([[curve.predict(grid), *curve.band(grid)] for curve in curves]).transpose(1, 0, 2)
    about = {"units": "m s-1", "long_name": "slip speed"}
    names = ("friction", "friction_low", "friction_high")
    return xr.Dataset({
        name: variable_of(MATERIAL_VARIABLES[name], ("material", "slip_speed"), np.where(outside, np.nan, values))
        for name, values in zip(names, rows, strict=True)
    }, {"slip_speed": xr.Variable("slip_speed", grid, about, NO_FILL)})  # fmt: skip


def _points(fits: Sequence[MaterialFit]) -> xr.Dataset:
    """The measured points, one material after the other."""
    tables = [fit.points for fit in fits]
    none = np.zeros(0)
    sizes = [points.get("mu", none).size for points in tables]
    columns = {"point_friction": [points.get("mu", none) for points in tables]}
    if any("sigma" in points for points in tables):
        columns["point_sigma"] = [p.get("sigma", np.full(size, np.nan)) for p, size in zip(tables, sizes, strict=True)]
    speeds = np.concatenate([points.get("speed", none) for points in tables])
    owner = np.repeat(np.array([fit.name for fit in fits], object), sizes)
    about = {"units": "m s-1", "long_name": "measured slip speed"}
    return xr.Dataset(
        {name: variable_of(MATERIAL_VARIABLES[name], ("point",), np.concatenate(values))
         for name, values in columns.items()},
        {"point_speed": xr.Variable("point", speeds, about, NO_FILL),
         "point_material": _text("point", owner, "material of the point")},
    )  # fmt: skip


class Comparison(Result):
    """Materials compared."""

    variables, subject, places = MATERIAL_VARIABLES, "quiet_above", "materials"

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | ReportTable]:
        """The ranks, the answer, and what is to be known of them."""
        from stickslip_materials.compare.table import RankTable

        ranking = RankTable(ds)
        yield f"system   {', '.join(f'{name} {value}' for name, value in ranking.conditions())}\n"
        yield ranking.table()
        if ranking.speeds:
            yield ranking.answer()
        yield from (f"note     {remark}" for remark in ranking.remarks())

    @classmethod
    def answer(cls, ds: xr.Dataset) -> Mapping[str, Any]:
        """The comparison for programs, in SI."""
        from stickslip_materials.compare.table import RankTable

        ranking, shown, materials = RankTable(ds), cls.tabular(ds, False), []
        at_speeds = [name for name in shown.data_vars if "belt_speed" in shown[name].dims]
        for i, name in enumerate(ranking.names):
            one = shown.isel(material=i)
            row = {"name": name, **_words(one.drop_vars(at_speeds))}
            if at_speeds:
                row["at"] = [_words(one[at_speeds].isel(belt_speed=j)) | {"belt_speed": speed}
                             for j, speed in enumerate(ranking.speeds)]  # fmt: skip
            materials.append(row)
        settings = ("belt_speed", "speed_range_from", "speed_range_to", "searched_from", "searched_to", "confidence",
                 "draws", "seed")  # fmt: skip
        return {
            "materials": materials,
            "units": {str(name): v.attrs["units"] for name, v in shown.variables.items() if "units" in v.attrs},
            "system": {name.removeprefix("system_"): ds.attrs[name] for name in ds.attrs if name.startswith("system_")},
            **{name: ds.attrs[name] for name in settings if name in ds.attrs},
            "remarks": ranking.remarks(),
            "written": {},
        }

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Any:
        """The curves, and where each material becomes quiet. Raises PlotError."""
        from stickslip.plots import check_plain
        from stickslip_materials.plots import plot_materials

        if variable is not None:
            return None
        check_plain(look, "a comparison of materials")
        return plot_materials(ds, title=title)

    @classmethod
    def page(cls, ds: xr.Dataset, title: str | None) -> str:
        """The report of a comparison."""
        from stickslip_materials.compare.table import material_page

        return material_page(ds, title=title)

    @classmethod
    def tabular(cls, ds: xr.Dataset, whole: bool) -> xr.Dataset:
        """A row a material, or one for each of several belt speeds.

        A bound of a border that does not stand for one is empty, beside its state, and the ends of the range that was
        searched have columns of their own. Ends of intervals that are open are empty too.
        """
        speed = {name: ds["quiet_above"].attrs[name] for name in ("units", DISPLAY) if name in ds["quiet_above"].attrs}
        known = ds["quiet_state"] == QUIET_STATES.index("border")
        changed = {str(name): v.where(np.isfinite(v)) for name, v in ds.data_vars.items()
                   if v.dtype.kind == "f" and v.dims[:1] == ("material",)}  # fmt: skip
        for name in FITTED if f"{FITTED[0]}_low" in ds else ():  # from 0 to inf: not determined
            changed[f"{name}_low"] = ds[f"{name}_low"].where(np.isfinite(ds[f"{name}_high"]))
        changed |= {name: ds[name].where(known) for name in ("quiet_above", "margin") if name in ds}
        for name, end in (("searched_from", "slowest"), ("searched_to", "fastest")):
            ends = np.full(ds.sizes["material"], float(ds.attrs[name]))
            about = speed | {"long_name": f"{end} belt speed searched"}
            changed[name] = xr.DataArray(ends, dims="material", attrs=about)
        ds = ds.assign(changed)
        beside = [] if whole else [name for name in ds.data_vars if ds[name].dims[:1] != ("material",)
                                   or not {*ds[name].dims} <= {"material", "belt_speed"}]  # fmt: skip
        return ds.drop_vars(beside)


def speeds_of(ds: xr.Dataset) -> list[float]:
    """The belt speeds (m/s) of a comparison; of a range its ends."""
    if "belt_speed" in ds.coords:
        return [float(speed) for speed in ds["belt_speed"].values]
    return [float(ds.attrs[n]) for n in ("belt_speed", "speed_range_from", "speed_range_to") if n in ds.attrs]


def _words(one: xr.Dataset) -> dict[str, Any]:
    """The numbers of a material by name, flags as words."""
    values = {str(name): v.item() for name, v in one.data_vars.items()}
    return {name: [*FLAGS[name]][int(value)] if name in FLAGS else value for name, value in values.items()}
