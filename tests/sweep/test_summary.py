import pytest

from helpers.maps import axis, make_map, plane
from stickslip.dataset.summary import summary
from stickslip.vocabulary.flags import REGIMES


def test_regimes_that_occur_are_counted_and_their_shares_add_up():
    ds = plane(4, 5)
    ds["regime"][:] = REGIMES.index("stick_slip")
    ds["regime"][0] = REGIMES.index("creep")
    found = summary(ds)
    assert {name: share.cells for name, share in found.items()} == {"stick_slip": 15, "creep": 5}
    assert sum(share.fraction for share in found.values()) == pytest.approx(1.0)


def test_a_single_cell_is_counted():
    assert sum(share.cells for share in summary(make_map()).values()) == 1


def test_any_number_of_dimensions_is_counted():
    ds = make_map(axis("mass", [1.0, 2.0]), axis("stiffness", [1.0, 2.0, 3.0]), axis("belt_speed", [0.1, 0.2]))
    assert sum(share.cells for share in summary(ds).values()) == 12
