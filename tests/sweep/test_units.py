import os
import subprocess
import sys
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.data import rows
from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.units import si_value

TABLES = rows("quantities.yaml")


@pytest.mark.parametrize(("text", "unit", "value"), TABLES["read"])
def test_a_text_with_a_unit_becomes_si(text, unit, value):
    assert si_value(text, unit) == pytest.approx(value, rel=1e-15)


@given(st.integers(-10_000, 10_000), st.integers(0, 6))
def test_conversion_gives_the_double_nearest_to_what_was_written(digits, decimals):
    """0.7 mm is 0.0007, although 0.7 * 0.001 is not."""
    written = f"{digits}e-{decimals}"
    assert si_value(f"{written} mm", "m") == float(f"{digits}e-{decimals + 3}")


@pytest.mark.parametrize(("value", "unit", "message"), TABLES["refused"])
def test_what_is_no_quantity_is_refused_with_a_way_out(value, unit, message):
    with pytest.raises(QuantityError) as caught:
        si_value(value, unit)
    assert str(caught.value) == f"expected {message}"


@pytest.mark.parametrize(("text", "unit", "kind"), TABLES["kinds"])
def test_a_wrong_dimension_is_named(text, unit, kind):
    with pytest.raises(QuantityError) as caught:
        si_value(text, unit)
    assert caught.value.kind == kind


@given(st.text(alphabet="0123456789.,+-eE mMsNk/*^°%x() _\t", max_size=20))
def test_any_text_is_a_finite_number_or_refused(text):
    try:
        value = si_value(text, "m s-1")
    except QuantityError as error:
        assert error.expected
    else:
        assert abs(value) < float("inf")
        assert "," not in text and "_" not in text


@pytest.mark.parametrize("name", QUANTITIES)
def test_every_quantity_knows_how_it_is_written(name):
    unit = QUANTITIES[name].units
    assert units.kind(unit) in units.expected(unit)
    if unit != "1":
        assert si_value(units.example(unit), unit) > 0


def test_units_are_spelled_for_people():
    assert [units.spelled(u) for u in ("1", "m s-1", "N s m-1", "s-1", "m s-2")] == ["", "m/s", "N s/m", "1/s", "m/s2"]


def test_pint_is_not_imported_before_a_text_is_met():
    code = "import sys, stickslip.config.reader, stickslip.vocabulary.units as u; u.si_value(1.0, 'm'); "
    code += "sys.exit('pint' in sys.modules)"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    assert subprocess.run([sys.executable, "-c", code], env=environment).returncode == 0


@pytest.mark.parametrize("name", units._PLAIN)
def test_plain_units_are_those_of_pint(name):
    factor, powers = units._PLAIN[name]
    registry = units._all_units()
    base = units._product(registry, list(zip(("m", "kg", "s"), powers, strict=True)))
    assert registry.Quantity(Fraction(1), name).to(base).magnitude == factor


@given(
    st.lists(st.tuples(st.sampled_from(sorted(units._PLAIN)), st.integers(-3, 3)), min_size=1, max_size=4),
    st.sampled_from(sorted(set(units._KINDS))),
)
def test_products_of_plain_units_are_those_of_pint(powers, si):
    found, asked = units._plain_product(powers), units._plain_product(units._factors(si))
    registry = units._all_units()
    written, wanted = (units._product(registry, one) for one in (powers, units._factors(si)))
    assert (found[1] == asked[1]) == (written.dimensionality == wanted.dimensionality)
    if found[1] == asked[1]:
        assert Fraction(registry.Quantity(Fraction(1), written).to(wanted).magnitude) == found[0] / asked[0]
