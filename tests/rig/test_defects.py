"""Records with defects: each is said, mended or left without a number, and a clean record stays as it is."""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from helpers.rig_signals import record, saw_tooth, times
from stickslip import rig
from stickslip.cli import main
from stickslip_rig.api import FeatureSettings, feature_table, features
from stickslip_rig.hum import subtract_hum
from stickslip_rig.records import force_of, write_record
from stickslip_rig.signals import evenly
from stickslip_rig.sticks import _Rates

ROOT = Path(__file__).parents[2]
SHOWN = ("sticks", "static_friction_first", "acceleration_max", "acceleration_integral")
DIGITS = (".0f", ".3f", ".3g", ".3g")


@cache
def simulated(number, lacking=("stick", "friction_force", "drive_velocity", "drive_displacement")):
    """One test of configs/rig/materials.yaml; as an instrument records it, without what it does not measure."""
    tests = rig.RigTests(rig.load_rig(ROOT / "configs" / "rig" / "materials.yaml"))
    test = next(tests.tests([number]))
    return test.record.drop_vars(lacking), test.exact


@pytest.fixture
def dry(kernels):
    return simulated(0)[0]


def changed(rec, force=None, acceleration=None):
    """A record with other signals, functions of time and the signal."""
    time = rec["time"].values
    for name, change in (("spring_force", force), ("acceleration", acceleration)):
        if change is not None:
            rec = rec.assign({name: ("time", change(time, rec[name].values))})
    return rec


def lost(value):
    """Twenty samples of a value, or of the last one before them."""

    def change(_, values):
        return np.concatenate([values[:200], np.full(20, values[199] if value is None else value), values[220:]])

    return change


def hum(frequency, amplitude, drift=0.0):
    def change(time, values):
        phase = 2 * np.pi * frequency * time + 2 * np.pi * drift * 5 * np.sin(time / 5)
        return values + amplitude * np.sin(phase + 1)

    return change


CASES = {
    "none": (lambda rec: rec, ""),
    "hum in the force, 20 mN at 50 Hz": (lambda rec: changed(rec, hum(50, 0.02)), "hum"),
    "hum in the force, 0.1 N at 60 Hz, drifting": (lambda rec: changed(rec, hum(60, 0.1, 0.05)), "hum"),
    "hum in the acceleration, 1 m/s2 at 50 Hz": (lambda rec: changed(rec, None, hum(50, 1.0)), "hum"),
    "a gap of 40 %": (lambda rec: rec.isel(time=~((rec.time > 3) & (rec.time < 8.4)).values), "gap"),
    "20 samples of zeros": (lambda rec: changed(rec, lost(0.0), lost(0.0)), "dropout, gap"),
    "20 samples of the last value": (lambda rec: changed(rec, lost(None), lost(None)), "dropout, gap"),
    "20 samples of -9999": (lambda rec: changed(rec, lost(-9999.0), lost(-9999.0)), "dropout, gap"),
    "force cut off at 6 N": (lambda rec: changed(rec, lambda _, f: np.clip(f, -6, 6)), "saturation"),
    "acceleration cut off at 25 m/s2": (lambda rec: changed(rec, None, lambda _, a: np.clip(a, -25, 25)), "saturation"),
    "mN read as N": (lambda rec: changed(rec, lambda _, f: 1000 * f), "loading rate"),
    "N read as mN": (lambda rec: changed(rec, lambda _, f: f / 1000), "loading rate"),
    "mm/s2 read as m/s2": (lambda rec: changed(rec, None, lambda _, a: 1000 * a), "unit"),
    "stiffness twice as high": (lambda rec: rec.assign_coords(stiffness=2 * rec.stiffness), "loading rate"),
    "half the stiffness": (lambda rec: rec.assign_coords(stiffness=rec.stiffness / 2), "loading rate"),
    "force 1 N too high": (lambda rec: changed(rec, lambda _, f: f + 1.0), "zero"),
    "force drifting by 3 N": (lambda rec: changed(rec, lambda t, f: f + 3 * t / t[-1]), "zero"),
    "acceleration dead": (lambda rec: changed(rec, None, lambda _, a: 0 * a), "dead channel"),
    "clock 1 % slower at the end": (lambda rec: rec.assign_coords(time=rec.time * (1 + rec.time / 2700)), "clock"),
}  # fmt: skip


def unguarded(rec):
    """What the samples give by themselves: sticks, the first static friction, and the acceleration."""
    even = evenly(rec)
    _, ends, *_ = _Rates(even, FeatureSettings()).phases()
    first = abs(force_of(even)[ends[0]]) / float(rec["normal_load"]) if ends.size else np.nan
    size = np.abs(rec["acceleration"].values)
    return ends.size, first, size.max(), np.trapezoid(size, rec["time"].values)


def written(numbers):
    return ", ".join(format(float(x), f) if np.isfinite(x) else "-" for x, f in zip(numbers, DIGITS, strict=True))


def names(remarks):
    """The names of the defects that remarks are about."""
    facts = [line.split(":")[0] for line in remarks.splitlines()[1:]]
    return ", ".join(dict.fromkeys(name for name in facts if name != "not determined"))


@pytest.mark.parametrize("case", CASES)
def test_the_table_of_defects_in_the_docs_is_what_comes_out(dry, case):
    broken = CASES[case][0](dry)
    found = features(broken)
    assert names(str(found["remarks"].values)) == CASES[case][1]
    row = f"| {case} | {written(unguarded(broken))} | {written([found[n] for n in SHOWN])} | {CASES[case][1]} |"
    assert row in (ROOT / "docs" / "rig.md").read_text(encoding="utf-8"), row


def test_numbers_that_survive_a_defect_are_those_of_the_clean_record(dry):
    clean = features(dry)
    for case, (make, _) in CASES.items():
        found = features(make(dry))
        for name, tolerance in (("sticks", 0.0), ("static_friction_first", 0.003), ("acceleration_max", 1e-3),
                                ("acceleration_integral", 0.011)):  # fmt: skip
            if np.isfinite(found[name]):
                assert float(found[name]) == pytest.approx(float(clean[name]), rel=tolerance), (case, name)


@pytest.mark.parametrize("number", range(4))
def test_a_clean_record_is_not_touched(kernels, number):
    rec, exact = simulated(number)
    assert str(features(rec)["remarks"].values) == ""
    force, acceleration = rec["spring_force"].values, rec["acceleration"].values
    same = subtract_hum(force, acceleration, 5e-4)
    assert same[0] is force and same[1] is acceleration and not same[2]
    if number == 0:
        assert abs(float(features(rec)["sticks"]) - exact["sticks_exact"]) <= 1


@pytest.mark.parametrize("rate", [400, 1000, 5000])
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_stick_slip_of_fifty_hertz_is_no_hum(rate, noise):
    """A steady saw-tooth, and the acceleration of a mass on that spring."""
    time = times(8.0, rate)
    force = saw_tooth(time, 4.0, 5.0, 0.014, 0.006) + np.random.default_rng(1).normal(0, noise, time.size)
    phase = np.mod(time, 0.02)
    bent = -np.cos(np.pi * (phase - 0.014) / 0.006) * 0.5 * (np.pi / 0.006) ** 2 / 5000.0
    found = features(record(time, force, np.where(phase < 0.014, 0.0, bent)))
    assert "hum" not in names(str(found["remarks"].values))


@pytest.mark.parametrize("frequency", [47.3, 50.0, 60.0])
@pytest.mark.parametrize("share", [5e-4, pytest.param(2e-3, marks=pytest.mark.slow), 1e-2])
@pytest.mark.parametrize("number", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_hum_with_harmonics_leaves_the_features(kernels, number, frequency, share):
    rec, _ = simulated(number)
    clean, top = features(rec), float(np.abs(rec["spring_force"]).max())
    loud = rec
    for multiple, part in ((1, 1.0), (2, 0.3), (3, 0.3)):
        loud = changed(loud, hum(multiple * frequency, part * share * top, 0.05 * multiple))
    found = features(loud)
    for name in ("sticks", "static_friction_first", "static_friction", "dynamic_friction"):
        assert float(found[name]) == pytest.approx(float(clean[name]), rel=0.01), name


def test_hum_that_cannot_be_subtracted_leaves_no_number(dry):
    """A hum of a fifth of the force whose amplitude comes and goes."""

    def wild(time, force):
        return force + 2 * np.sin(2 * np.pi * 50 * time) * (1 + 0.4 * np.sin(2 * np.pi * time / 1.7))

    found = feature_table({"dry": changed(dry, wild)})
    assert np.isnan(found["sticks"][0]) and np.isnan(found["model_rpn"][0])
    assert "hum" in str(found["remarks"].values[0])


@pytest.mark.parametrize("every", [4, 5, 8])
def test_samples_too_few_for_the_sticks_are_said(kernels, every):
    """A cycle of 30 ms in 7 to 15 samples, of which the last hardly show a stick."""
    found = features(simulated(2)[0].isel(time=slice(None, None, every)))
    assert np.isnan(found["sticks"]) and "sampling" in names(str(found["remarks"].values))


def test_a_force_of_the_wrong_sign_is_turned(kernels):
    whole = simulated(0, ())[0].drop_vars(["stick", "friction_force"])
    found = features(changed(whole, lambda _, f: -f))
    assert names(str(found["remarks"].values)) == "sign"
    assert float(found["sticks"]) == float(features(whole)["sticks"]) and float(found["energy_per_stroke"]) > 0


def test_a_drive_that_contradicts_itself_is_said(kernels):
    whole = simulated(0, ())[0]
    fast = whole.assign(drive_velocity=2 * whole.drive_velocity)
    assert "speed" in names(str(features(fast)["remarks"].values)).split(", ")


def test_remarks_are_on_the_screen_and_in_the_file(dry, tmp_path):
    write_record(CASES["20 samples of zeros"][0](dry), tmp_path / "dry.csv")
    arguments = ["rig", "features", str(tmp_path / "dry.csv"), "-o", str(tmp_path / "f.nc")]
    out = CliRunner().invoke(main, arguments, catch_exceptions=False).output
    assert re.search(r"dropout: .* 0\.1", out) and "gap: " in out
    with xr.open_dataset(tmp_path / "f.nc") as found:
        assert "dropout" in str(found["remarks"].values[0])
