"""Tables of features: of several records, of a test matrix, for people; with the model RPN beside them."""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from stickslip.config.studies import Table
from stickslip.dataset.build import NO_FILL, attributes_of
from stickslip.dataset.display import MapAxis
from stickslip.vocabulary.display_units import number
from stickslip.vocabulary.flags import STATUS_MESSAGES, STATUSES
from stickslip_rig.evaluation import features
from stickslip_rig.quantities import PER_PEAK, RATINGS
from stickslip_rig.risk import BANDS, INPUTS, Risk, band_of, number_of, rpn_text
from stickslip_rig.settings import Settings
from stickslip_rig.signals import Floats


def feature_table(records: Mapping[str, xr.Dataset], settings: Settings | None = None) -> xr.Dataset:
    """Compute features and model RPN of several records.

    Parameters
    ----------
    records
        By name.
    settings
        Of features and risk.

    Returns
    -------
    Dataset
        Along the dimension `record`, whose index are the names. A condition that only some records know is NaN, or an
        empty text, for the others.
    """
    settings = settings or Settings()
    rows = [rate(features(record, settings.features), settings.risk) for record in records.values()]
    shared = list(dict.fromkeys(str(name) for row in rows for name in row.coords))
    names = xr.Variable("record", np.asarray(list(records), str), {"long_name": "record"})
    coordinates: dict[str, Any] = {"record": names, **{name: _column(rows, name) for name in shared}}
    return xr.Dataset({name: _column(rows, str(name)) for name in rows[0].data_vars}, coordinates)


def _column(rows: Sequence[xr.Dataset], name: str) -> xr.Variable:
    """One quantity of all records, with the attributes it has where it is known."""
    known = next(row[name].variable for row in rows if name in row.variables)
    gap = "" if known.dtype.kind == "U" else np.nan
    values = [row[name].values if name in row.variables else gap for row in rows]
    encoding = NO_FILL if known.dtype.kind in "iu" or name in rows[0].coords else {}
    return xr.Variable(("record", *known.dims), np.stack([np.asarray(v) for v in values]), known.attrs, encoding)


def as_columns(table: xr.Dataset) -> xr.Dataset:
    """Features with a variable of its own for each peak of the spectrum: a row of a table for each record."""
    peaks = {f"{name}_{i + 1}": table[name].isel(peak=i) for name in PER_PEAK for i in range(table.sizes["peak"])}
    return table.drop_dims("peak").assign(peaks)


def rate(table: xr.Dataset, risk: Risk) -> xr.Dataset:
    """The features with the model RPN, its level before rounding and its band beside them; and, of a calibrated model,
    whether a feature lies outside the range of its pairs."""
    inputs, meanings = risk_inputs(table), ("unknown", *BANDS)
    level = risk.level(inputs)
    rpn = number_of(level)
    band = [meanings.index(band_of(n)) for n in rpn.ravel().tolist()]
    ratings: dict[str, Any] = {"model_rpn_level": level, "model_rpn": rpn}
    ratings["model_rpn_band"] = np.asarray(band, np.int8).reshape(rpn.shape)
    if risk.is_calibrated:
        ratings["model_rpn_extrapolated"] = np.any([*risk.outside(inputs).values()], axis=0).astype(np.int8)
    dims = table["sticks"].dims
    return table.assign({
        name: xr.Variable(dims, values, attributes_of(RATINGS[name], meanings if name == "model_rpn_band" else ()),
                          NO_FILL if values.dtype == np.int8 else None)
        for name, values in ratings.items()
    })  # fmt: skip


def risk_inputs(table: xr.Dataset) -> dict[str, Floats]:
    """The inputs of the risk model: band-limited accelerations where there are any, else sampled ones."""
    return {name: rated(table, name) for name in INPUTS}


def rated(table: xr.Dataset, feature: str) -> Floats:
    """A feature, band-limited where the risk model uses that."""
    plain = table[feature].values.astype(np.float64)
    name = f"{feature}_limited"
    return np.where(np.isnan(table[name].values), plain, table[name].values) if name in table else plain


# --- for people -------------------------------------------------------------------------------------------------------


_MOST_NAMES = 5


class FeatureColumn(NamedTuple):
    """A column of tables for people: a feature, its heading with the unit, and the `size` of that unit in SI."""

    feature: str
    heading: str
    size: float = 1.0


SHOWN = (
    FeatureColumn("sticks", "sticks"),
    FeatureColumn("acceleration_max", "|a| m/s2"),
    FeatureColumn("acceleration_integral", "int m/s"),
    FeatureColumn("drops", "drops"),
    FeatureColumn("drop_mean", "drop N"),
    FeatureColumn("impulse_rate", "slips/mm", 1e3),
    FeatureColumn("static_friction_first", "first mu_s"),
    FeatureColumn("static_friction", "mu_s"),
    FeatureColumn("dynamic_friction", "mu_d"),
)


def shown_table(ds: xr.Dataset) -> Table:
    """The features of records or of the tests of a matrix as people read them; a dash where one is not defined."""
    table = as_records(ds)
    columns = [[number(value, 3) for value in rated(table, column.feature) / column.size] for column in SHOWN]
    rpn = [rpn_text(value) for value in table["model_rpn"].values.tolist()]
    rows = list(zip(map(str, table["record"].values.tolist()), rpn, *columns, strict=True))
    return Table("All tests", ("record",), ("RPN", *(column.heading for column in SHOWN)), rows)


def unfinished(matrix: xr.Dataset) -> Iterator[str]:
    """A sentence for each reason why tests of a matrix were not integrated to their end, with the first of them."""
    status, names = matrix["status"].values.ravel(), as_records(matrix)["record"].values
    for code in np.unique(status[status != STATUSES.index("horizon_reached")]).tolist():
        lost = names[status == code].tolist()
        yield f"{len(lost):,} not integrated to the end ({first_of(lost)}): {STATUS_MESSAGES[STATUSES[code]]}"


def first_of(names: Sequence[str]) -> str:
    """The first of some names, and how many more there are."""
    more = f" and {len(names) - _MOST_NAMES:,} more" * (len(names) > _MOST_NAMES)
    return ", ".join(names[:_MOST_NAMES]) + more


def as_records(matrix: xr.Dataset) -> xr.Dataset:
    """The tests of a matrix as records: along the dimension `record`, whose index are their names."""
    if "record" in matrix.dims:
        return matrix
    dims = matrix["sticks"].dims
    table = matrix.drop_vars(matrix.coords)
    table = table.stack(record=dims, create_index=False) if dims else table.expand_dims("record")
    return table.transpose("record", ...).assign_coords(record=test_names(matrix, dims))


def test_names(ds: xr.Dataset, dims: Sequence[Any]) -> list[str]:
    """The points that distinguish each test of a matrix from the others, pure numbers with the name of what they are;
    the title where there is only one."""
    axes = [MapAxis(ds, dim, plain=True) for dim in dims]
    points = [[axis.heading(i) if re.fullmatch(r"[-+.e0-9]+", axis.text(i)) else axis.text(i)
               for i in range(axis.length)] for axis in axes]  # fmt: skip
    return [", ".join(at) or str(ds.attrs.get("title", "")) for at in product(*points)]
