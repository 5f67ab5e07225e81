import pytest

from helpers.maps import plane
from stickslip.dataset.coarse import summary
from stickslip.vocabulary.quantities import REGIMES


def test_regimes_that_occur_are_counted_and_their_shares_add_up():
    ds = plane(4, 5)
    ds["regime"][:] = REGIMES.index("stick_slip")
    ds["regime"][0] = REGIMES.index("creep")
    found = summary(ds)
    assert {name: share.cells for name, share in found.items()} == {"stick_slip": 15, "creep": 5}
    assert sum(share.fraction for share in found.values()) == pytest.approx(1.0)
