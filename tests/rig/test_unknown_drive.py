"""Records without the motion of the drive: dwells, ramps and reversals are no sliding."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from stickslip_rig.api import RigTests, features, make_rig

CONFIG = Path(__file__).parents[2] / "configs" / "rig" / "materials.yaml"
SPEEDS = ["10 mm/s", "100 mm/s"]
UNKNOWN = ("stick", "drive_velocity", "drive_displacement", "friction_force", "stiffness", "mass")
STICK_SLIP = ("dry", "felt")  # fluids are damped enough to slide steadily at some speeds


@pytest.fixture(scope="module", params=["trapezoid", "sine"])
def records(request, kernels):
    """Of the four pairs at two speeds, by name: features with and without what is known of the drive."""
    plain = yaml.safe_load(CONFIG.read_text())
    del plain["output"], plain["system"]["belt_speed"]
    plain["axes"]["belt_speed"] = SPEEDS
    plain["drive"]["strokes"] = 3
    if request.param == "sine":
        plain["drive"]["profile"] = "sine"
        del plain["drive"]["ramp"]
    tests = RigTests(make_rig(plain))
    records = {test.name: test.record for test in tests.tests(range(tests.grid.size))}
    return {n: (features(r.drop_vars("stick")), features(r.drop_vars(UNKNOWN))) for n, r in records.items()}


def test_dynamic_friction_is_that_of_a_known_drive_or_not_determined(records):
    lost = 0
    for name, (known, found) in records.items():
        value = float(found["dynamic_friction"])
        if np.isnan(value):
            lost += 1
            assert "drive: the sliding force is" in str(found["remarks"].values), name
            assert not name.startswith(STICK_SLIP) or "100" in name, name
        else:
            assert value == pytest.approx(float(known["dynamic_friction"]), rel=0.05), name
    assert lost <= len(records) // 2


def test_slips_of_dry_and_felt_pairs_are_the_drops_of_the_force(records):
    for name, (known, found) in records.items():
        if name.startswith(STICK_SLIP) and "100" not in name:
            assert abs(found["slips"] - found["drops"]) <= max(1, 0.05 * found["drops"]), name
            assert abs(found["sticks"] - known["sticks"]) <= max(1, 0.05 * known["sticks"]), name
            assert float(found["travel"]) == pytest.approx(float(known["travel"]), rel=0.25), name


def test_the_last_stick_before_the_drive_stops_does_not_break_away(records):
    found = next(found for name, (_, found) in records.items() if name.startswith("dry"))
    assert found["slips"] == found["sticks"] - 1
