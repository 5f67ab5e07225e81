"""Friction on both branches from records of stick-slip: `rig friction`."""

from functools import cache

import numpy as np
import pytest
import xarray as xr

from helpers.commands import invoke
from rig_friction_coverage import NAMES, record_of, slip, trial
from stickslip import rig
from stickslip_materials.fit import fit_file
from stickslip_rig.commands.friction import write_points
from stickslip_rig.records import write_record

PAIR = {
    "mass": 0.1, "stiffness": 5000.0, "damping": 0.5, "normal_load": 10.0, "belt_speed": 0.01, "mu_start": 0.5,
    "mu_reversal": 0.35, "v_reversal": 0.1, "a4": 0.02, "mu_stop": 0.3, "rate": 1e4, "bandwidth": 3e3,
    "force_noise": 5e-3, "acceleration_noise": 0.05, "seed": 1,
}  # fmt: skip
TRUTH = slip(PAIR)


@cache
def record(**changed):
    """The record of the pair, with other numbers of it."""
    return record_of(PAIR | changed, slip(PAIR | changed))


def assert_held(ds, *names, truth=TRUTH):
    for name in names or NAMES:
        assert float(ds[f"{name}_low"]) <= truth[name] <= float(ds[f"{name}_high"]), name


def remarks(ds):
    return str(ds["remarks"].values)


def test_intervals_hold_the_friction_of_the_pair_and_are_narrow():
    ds = rig.friction(record())
    assert_held(ds)
    assert float(ds["mu_stop_high"] - ds["mu_stop_low"]) < 0.02 * (0.5 - 0.35)
    assert int(ds["slips_used"]) > 15 and remarks(ds) == ""
    points = ds.where(np.isfinite(ds["friction_sigma"]))
    speed, up = points["slip_speed"].sel(direction="rising").values, points["friction"].sel(direction="rising").values
    curve = 0.34384 + 0.05129 * speed + 0.15616 * np.exp(-speed / 0.02)  # of mu_start, mu_reversal, v_reversal, a4
    assert np.nanmax(np.abs(up - curve)) < 1.5e-3


@pytest.mark.parametrize(("count", "seed"), [(30, 3), pytest.param(300, 4, marks=pytest.mark.slow)])
def test_intervals_hold_the_truth_over_decades(count, seed):
    trials = [trial((seed, i), most=40_000) for i in range(count)]
    for name in NAMES:
        held = [one[name] for one in trials if np.isfinite(one[name])]
        assert len(held) > 0.4 * count
        assert np.mean(held) >= 0.95 - 3.0 * np.sqrt(0.95 * 0.05 / len(held)), name


def test_a_record_becomes_a_curve_in_two_steps(tmp_path):
    write_points(rig.friction_table({"felt": record()}), tmp_path / "friction.csv")
    curve = fit_file(tmp_path / "friction.csv")
    assert curve.good and curve.mu_stop == pytest.approx(0.3, abs=1e-3)
    assert curve.mu_start == pytest.approx(0.5, abs=2e-3) and curve.a4 == pytest.approx(0.02, rel=0.03)


def test_the_speed_of_the_drive_may_be_a_condition_and_what_rests_alone_tells_nothing():
    assert_held(rig.friction(record().drop_vars("drive_velocity")), "mu_start", "mu_reversal", "v_reversal")
    ds = rig.friction(record().isel(time=slice(0, 900)))  # the first loading
    assert int(ds["slips_used"]) == 0 and np.isnan(ds["tendency"]) and "0 slips" in remarks(ds)


def test_a_delay_of_the_acceleration_is_found_and_mended():
    late = record()
    late = late.assign(acceleration=late["acceleration"].copy(data=np.roll(late["acceleration"].values, 12)))
    ds = rig.friction(late)
    assert "1.2 ms" in remarks(ds)
    assert_held(ds, "mu_reversal", "mu_stop")


def test_a_wrong_stiffness_is_said_and_that_of_the_sticks_taken():
    ds = rig.friction(record().assign_coords(stiffness=7000.0))
    assert "7 N/mm" in remarks(ds) and float(ds["stiffness"]) == pytest.approx(5000.0, rel=0.01)
    assert_held(ds, "mu_start", "mu_reversal")
    assert float(rig.friction(record().drop_vars("stiffness"))["stiffness"]) == pytest.approx(5000.0, rel=0.01)


def test_a_mass_that_is_not_known_is_asked_for_or_taken_from_what_rings():
    bare = record().drop_vars("mass")
    with pytest.raises(ValueError, match="--mass"):
        rig.friction(bare)
    time, sticking = bare["time"].values, rig.find_sticks(bare)
    ringing = np.zeros(time.size)
    for start in sticking.starts:
        since = time[start:] - time[start]
        ringing[start:] += 3.0 * np.exp(-40.0 * since) * np.sin(np.sqrt(5000.0 / 0.1 - 40.0**2) * since)
    rings = bare.assign(acceleration=bare["acceleration"] + xr.DataArray(ringing, dims="time"))
    assert float(rig.friction(rings)["mass"]) == pytest.approx(0.1, rel=0.02)


def test_friction_at_break_away_above_the_curve_is_told_apart():
    p = {**PAIR, "mu_static": 0.6}
    config = rig.make_rig({
        "system": {name: p[name] for name in ("mass", "stiffness", "damping", "normal_load", "belt_speed")},
        "friction": {name: p[name] for name in ("mu_start", "mu_reversal", "v_reversal", "a4", "mu_stop", "mu_static")},
        "drive": {"stroke": 0.01, "strokes": 2}, "sensor": {"rate": 1e4, "force_noise": 5e-3},
    })  # fmt: skip
    ds = rig.friction(next(rig.RigTests(config).tests([0])).record)
    assert "break-away is at 0." in remarks(ds)
    assert_held(ds, "mu_start", truth={"mu_start": 0.6})


@pytest.mark.parametrize(
    ("changed", "nothing_of"),
    [({"rate": 300.0, "bandwidth": np.nan}, NAMES), ({"bandwidth": 150.0}, ("mu_reversal", "mu_stop", "tendency"))],
)
def test_what_sensors_are_too_slow_for_is_not_told(changed, nothing_of):
    ds = rig.friction(record(**changed))
    assert all(np.isnan(ds[name]) for name in nothing_of) and remarks(ds)


def test_without_acceleration_or_load_it_is_refused():
    with pytest.raises(ValueError, match="acceleration"):
        rig.friction(record().drop_vars("acceleration"))
    with pytest.raises(ValueError, match="0 throughout"):
        rig.friction(record().assign(acceleration=0.0 * record()["acceleration"]))
    with pytest.raises(ValueError, match="load"):
        rig.friction(record().drop_vars("normal_load"))


def test_a_command_makes_points_pictures_and_answers(tmp_path):
    files = [str(tmp_path / f"k{k}.csv") for k in (4, 8)]
    for file, k in zip(files, (4e3, 8e3), strict=True):
        write_record(record(stiffness=k), tmp_path / file)
    outputs = ("--plot", tmp_path / "k.png", "-o", tmp_path / "points.csv")
    made = invoke("rig", "friction", *files, *outputs, "--json")
    assert made.exit_code == 0, made.output
    assert (tmp_path / "k.png").stat().st_size > 5000
    assert (tmp_path / "points.csv").read_text().startswith("material,speed [mm/s],mu,sigma,direction")
    wrong = invoke("rig", "friction", *files, *(["--stiffness", "5 N/mm"] * 3))
    assert wrong.exit_code == 2 and "got 3 for 2 files" in wrong.output
