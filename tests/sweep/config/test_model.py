"""A configuration that was read: its defaults, and that it is written out as it is read back."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from helpers.configs import GOOD
from stickslip.config.reader import make_config, parse_config
from stickslip.config.sections import Friction, Start, System
from stickslip.vocabulary.models import CURVE_LAWS, STRIBECK
from stickslip.vocabulary.quantities import MEASURED, PARAMETERS_OF, QUANTITIES


def test_defaults_are_filled_in():
    config = parse_config(GOOD)
    assert config.system.damping == 0.0
    assert all(map(math.isnan, (config.friction.mu_stop, config.friction.mu_static, config.start.velocity)))
    assert config.start.displacement == 0.0
    assert (config.solver.rtol, config.solver.horizon, config.solver.early_stop) == (1e-6, None, True)
    assert (config.execution.threads, config.execution.block) == (None, 4096)
    assert config.axes == ()


def test_the_sections_own_all_quantities():
    for section, model in {"system": System, "friction": Friction, "start": Start}.items():
        assert set(model.model_fields) - {"law", "fit", "table"} == {
            n for n, q in QUANTITIES.items() if q.section == section
        }


above_zero = st.floats(1e-6, 1e6)
anything = st.floats(-1e6, 1e6)


def value_of(name):
    declared = QUANTITIES[name]
    if name in ("mu_stop", "mu_static"):
        return st.just({"mu_stop": "none", "mu_static": "mu_start"}[name])
    if name == "delta":
        return st.floats(1.0, 10.0)
    if declared.at_most is not None:
        return st.floats(0.5 * declared.at_most, declared.at_most)
    if name == "a3":
        return above_zero  # below zero it must fit to a1
    return anything if declared.above is None and declared.at_least is None else above_zero


@st.composite
def data(draw):
    """A configuration as plain data: some quantities fixed, some along axes, in any order."""
    measured = draw(st.booleans())
    law = "stribeck" if measured else draw(st.sampled_from(CURVE_LAWS))
    names = [n for n in PARAMETERS_OF[STRIBECK] if not (measured and n in ("a1", "a2", "a3"))]
    names += MEASURED if measured else ()
    if law != "stribeck_delta":
        names.remove("delta")
    varied = draw(st.lists(st.sampled_from(names), max_size=3, unique=True))
    if measured:  # values that make a curve
        varied = [n for n in varied if n != "a4" and n not in MEASURED]
    good = {"mu_start": 0.5, "mu_reversal": 0.4, "v_reversal": 0.7, "a4": 0.1} if measured else {}
    found = {"title": draw(st.text(min_size=1).filter(lambda t: t.strip() == t and t.isprintable())), "axes": {}}
    found["friction"] = {"law": law}
    for name in names:
        if name not in varied:
            value = good.get(name) or draw(value_of(name))
            found.setdefault(QUANTITIES[name].section, {})[name] = value
    for name in varied:
        found["axes"][name] = draw(axis(name))
    if draw(st.booleans()):
        found["solver"] = {"horizon": draw(above_zero), "early_stop": draw(st.booleans()), "rtol": 1e-12}
    return found


def axis(name):
    values = st.lists(value_of(name), min_size=1, max_size=4, unique=True).map(lambda v: sorted(v, key=str_last))
    ends = value_of(name) if name == "delta" or QUANTITIES[name].at_most is not None else above_zero
    start_stop = st.tuples(ends, ends).filter(lambda pair: pair[0] < pair[1] * (1 - 1e-9))
    ranges = st.builds(
        lambda ends, num, spacing: {"start": ends[0], "stop": ends[1], "num": num, "spacing": spacing},
        start_stop, st.integers(2, 100), st.sampled_from(["linear", "log"]),
    )  # fmt: skip
    return (
        values if name in ("mu_stop", "mu_static") else st.one_of(values, values.map(lambda v: {"values": v}), ranges)
    )


def str_last(value):
    return (isinstance(value, str), value)


@given(data())
@settings(max_examples=60, deadline=None)
def test_the_resolved_configuration_reads_back_as_an_equal_one(plain):
    config = make_config(plain)
    text = config.to_yaml()
    again = parse_config(text)
    assert again == config
    assert make_config(config.resolved()) == config
    assert again.to_yaml() == text
    assert [axis.name for axis in again.axes] == list(plain["axes"])
