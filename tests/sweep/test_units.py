import os
import subprocess
import sys
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.units import si_value


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("10 mm/s", "m s-1", 0.01),
        ("10mm/s", "m s-1", 0.01),
        ("  -2.5e-3   km/h ", "m s-1", -2.5e-3 / 3.6),
        ("1 m s-1", "m s-1", 1.0),
        ("1 m*s^-1", "m s-1", 1.0),
        ("3 m s**-1", "m s-1", 3.0),
        ("5 N/mm", "N m-1", 5000.0),
        ("1 lbf/in", "N m-1", 175.12683524647636),  # 0.45359237 kg x 9.80665 m/s2 / 0.0254 m
        ("0.5 N s/m", "N s m-1", 0.5),
        ("0.5 kg/s", "N s m-1", 0.5),
        ("250 g", "kg", 0.25),
        ("2 kN", "N", 2000.0),
        ("7 µm", "m", 7e-6),
        ("7 μm", "m", 7e-6),
        ("1.5 h", "s", 5400.0),
        ("0.1 s/mm", "s m-1", 100.0),
    ],
)
def test_a_text_with_a_unit_becomes_si(text, unit, value):
    assert si_value(text, unit) == pytest.approx(value, rel=1e-15)


@given(st.integers(-10_000, 10_000), st.integers(0, 6))
def test_conversion_gives_the_double_nearest_to_what_was_written(digits, decimals):
    """0.7 mm is 0.0007, although 0.7 * 0.001 is not."""
    written = f"{digits}e-{decimals}"
    assert si_value(f"{written} mm", "m") == float(f"{digits}e-{decimals + 3}")


@pytest.mark.parametrize(
    ("value", "unit", "message"),
    [
        ("1,5 mm", "m", "a length such as '10 mm' or a number in m; write a decimal point, not a comma"),
        ("10 mm mm/s x", "m s-1", "a speed such as '10 mm/s' or a number in m/s; no unit is called 'x'"),
        ("1 nan", "kg", "a mass such as '250 g' or a number in kg; no unit is called 'nan'"),
        ("1 kg/inf", "kg", "a mass such as '250 g' or a number in kg; no unit is called 'inf'"),
        ("10", "m", "a length such as '10 mm' or a number in m; remove the quotes: 10"),
        ("1e-3", "kg", "a mass such as '250 g' or a number in kg; remove the quotes: 1e-3"),
        ("0.3", "1", "a number (without unit); remove the quotes: 0.3"),
        ("0,3", "1", "a number (without unit); write a decimal point, not a comma"),
        ("30 %", "1", "a number (without unit); write 0.3"),
        ("3 m", "1", "a number (without unit); leave the unit out: this quantity has none"),
        ("nan", "m", "a length such as '10 mm' or a number in m"),
        ("3 N/(mm)", "N m-1", "a stiffness such as '5 N/mm' or a number in N/m; 'N/(mm)' is not a unit"),
        ("1 000 mm", "m", "a length such as '10 mm' or a number in m; '000 mm' is not a unit"),
        ("1 m/s/", "m s-1", "a speed such as '10 mm/s' or a number in m/s; 'm/s/' is not a unit"),
        ("10 N degC/m/K", "N m-1", "a stiffness such as '5 N/mm' or a number in N/m; "
                                   "'N degC/m/K' is not a plain multiple of N/m"),
        (True, "m", "a length such as '10 mm' or a number in m"),
        (None, "m", "a length such as '10 mm' or a number in m"),
        ("", "m", "a length such as '10 mm' or a number in m"),
        ("mm", "m", "a length such as '10 mm' or a number in m; the number is missing: '1 mm'"),
        ("9" * 70 + " mm", "m", "a length such as '10 mm' or a number in m"),
        ("٣ mm", "m", "a length such as '10 mm' or a number in m"),
        (float("nan"), "m", "a finite number in m"),
        (float("inf"), "1", "a finite number"),
        (10**400, "m", "a finite number in m"),
        ("1e999 m", "m", "a finite number in m"),
    ],
)  # fmt: skip
def test_what_is_no_quantity_is_refused_with_a_way_out(value, unit, message):
    with pytest.raises(QuantityError) as caught:
        si_value(value, unit)
    assert str(caught.value) == f"expected {message}"


@pytest.mark.parametrize(
    ("text", "unit", "kind"),
    [
        ("10 mm", "m s-1", "length"),
        ("10 mm/s", "m", "speed"),
        ("2 m s-2", "m s-1", "acceleration"),
        ("20 degC", "N", "temperature"),
        ("3 dB", "s", "pure number"),
        ("3 A", "N", "[current]"),
        ("1 /s", "s", "frequency"),
    ],
)
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
