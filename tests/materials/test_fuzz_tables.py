"""Odd tables of points: an error for people, or what was meant."""

import warnings

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from helpers.fuzzing import EXAMPLES
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError
from stickslip_materials.fit import fit_materials
from stickslip_materials.fit.files import as_yaml, describe, describe_columns

CSV = [
    "# felt\nspeed [mm/s], mu\n0.5, 0.61\n1, 0.58\n10, 0.5\n20, 0.45\n100, 0.4\n300, 0.41\n500, 0.43\n",
    "time [s], mu\n1, 0.61\n10, 0.68\n100, 0.74\n1000, 0.81\n",
    "v;dry;oil;Temp [°C]\nmm/s;-;-;°C\n0,5;0,4;0,1;20\n1;0,38;;20\n10;0,3;0,09;21\n50;0,25;0,1;21\n90;0,26;0,11;22\n",
    "mu, speed, sigma\n0.6, 0.1, 0.01\n0.5, 0.2, 0.01\n0.45, 0.4, 0.02\n0.46, 0.8, 0.02\n0.5, 1.2, 0.02\n0.5, 2, 0.1\n",
]
PIECES = st.one_of(
    st.text(max_size=6),
    st.sampled_from(["nan", "inf", "1e308", "1e-320", "-1", "0", "0, 0\n", "1,5; 2", "\t", '"', '""', "\x00", "[km/h]"])
    | st.sampled_from(["[kg]", "speed", "time", "mu", "sigma", "\ufeff", "\r", "\x85", "\u2028", "1e99999", "٣", "#"]),
    st.floats().map(repr),
)


def load_config_text(yaml):
    """What is printed to be pasted is YAML of a configuration."""
    rest = "\nsystem: {mass: 1, stiffness: 1, normal_load: 1, belt_speed: 1}\n"
    return parse_config(yaml + rest)


@st.composite
def tables(draw) -> str:
    """A table of points with pieces cut out and glued in."""
    text = draw(st.sampled_from(CSV))
    for _ in range(draw(st.integers(0, 4))):
        start = draw(st.integers(0, len(text)))
        text = text[:start] + draw(PIECES) + text[start + draw(st.integers(0, 12)) :]
    return text


@settings(max_examples=min(EXAMPLES, 5000) or 60, deadline=None, database=None, suppress_health_check=list(HealthCheck))
@given(text=tables())
def test_any_table_of_points_is_a_fit_or_a_config_error(text, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "points.csv"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            found = fit_materials([path])
        except ConfigError as error:
            assert str(error).startswith(str(path))
            return
    assert found and all(describe(one) for one in found) and describe_columns(found)
    if found[0].curve:
        assert load_config_text(as_yaml(found))
