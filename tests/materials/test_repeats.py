"""Repeats of one material are one material, whose intervals hold what differs between them."""

import numpy as np
import pytest

import stickslip
from helpers.commands import call
from helpers.nightly import few
from stickslip.errors import ConfigError
from stickslip.theory import loss_of_stability, stribeck
from stickslip_materials.fit import draw_curves, fit_curve, fit_materials, fit_repeats

SPEEDS = np.geomspace(5e-4, 0.2, 12)
TRUE = {"a1": 0.12, "a2": 0.2, "a3": 0.08, "a4": 0.01}
DAMPING, LOAD = 0.5, 10.0
SYSTEM = {"mass": 0.1, "stiffness": 5000.0, "normal_load": LOAD, "damping": DAMPING}


def border(a2, a3, a4, **_):
    """Where steady sliding loses its stability, m/s; 0 where it never does."""
    with np.errstate(all="ignore"):
        return np.nan_to_num(np.asarray(loss_of_stability(a2, a3, a4, DAMPING, LOAD), float), nan=0.0, posinf=1e3)


def specimens(random, count, between=0.08, noise=0.02):
    """Friction of as many specimens at SPEEDS: levels, falls and decay speeds differ from one to the next."""
    found = []
    for _ in range(count):
        level, fall, decay = 1 + between * random.standard_normal(3) * [1, 1.5, 1.5]
        curve = TRUE | {"a3": TRUE["a3"] * fall, "a4": TRUE["a4"] * decay}
        found.append(level * stribeck(SPEEDS, **curve) * (1 + noise * random.standard_normal(SPEEDS.size)))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 5])
def test_the_border_of_the_material_is_covered_as_often_as_its_interval_says(count):
    random, true = np.random.default_rng(count), float(border(**TRUE))
    hits = []
    for trial in range(16):
        fit = fit_repeats([SPEEDS] * count, specimens(random, count))
        drawn = draw_curves(fit, 400, trial, falling=True)
        low, high = np.quantile(border(**drawn.coefficients), (0.025, 0.975))
        hits.append(low <= true <= high)
    assert np.mean(hits) >= 0.8  # 95 %, of 16; docs/materials.md has 300


def test_intervals_of_repeats_that_differ_are_wider_than_those_of_their_points():
    frictions = [level * stribeck(SPEEDS, **TRUE) for level in (0.8, 1.0, 1.2)]
    apart = fit_repeats([SPEEDS] * 3, frictions)
    low, high = apart.interval["mu_start"]
    assert low < 0.8 * 0.2 < 1.2 * 0.2 < high  # t of two degrees of freedom: 4.3 standard errors
    band = apart.band(SPEEDS)
    assert (band[0] < frictions[0]).all()
    assert (band[1] > frictions[2]).all()


def test_repeats_that_agree_are_known_as_one():
    random = np.random.default_rng(3)
    frictions = [stribeck(SPEEDS, **TRUE) * (1 + 0.01 * random.standard_normal(12)) for _ in range(6)]
    alike, pooled = fit_repeats([SPEEDS] * 6, frictions), fit_curve(np.tile(SPEEDS, 6), np.concatenate(frictions))
    assert alike.coefficients() == pooled.coefficients()
    for name in ("a1", "a3", "a4"):
        width, other = (np.ptp(one.interval[name]) for one in (alike, pooled))
        assert 0.3 < width / other < 3


def test_repeats_may_have_been_measured_at_other_speeds():
    """One slow, one fast, one of all: none tells the curve alone but the last."""
    random = np.random.default_rng(4)
    speeds = [SPEEDS[:5], SPEEDS[7:], SPEEDS]
    frictions = [stribeck(one, **TRUE) * (1 + 0.003 * random.standard_normal(one.size)) for one in speeds]
    assert fit_repeats(speeds, frictions).mu_start == pytest.approx(0.2, rel=0.1)


def test_too_few_repeats_are_refused():
    with pytest.raises(ValueError, match="at least 2"):
        fit_repeats([SPEEDS], [SPEEDS])
    with pytest.raises(ValueError, match="without b"):
        fit_repeats([SPEEDS[:3], SPEEDS], [SPEEDS[:3], SPEEDS + 0.1], ["a", "b"])


@pytest.fixture
def files(tmp_path):
    random = np.random.default_rng(5)
    for i, friction in enumerate([*specimens(random, 3), *specimens(random, 1)]):
        name = f"Fett_A{i + 1}" if i < 3 else "Fett_B"
        rows = "\n".join(f"{1000 * v}, {m}" for v, m in zip(SPEEDS, friction, strict=True))
        (tmp_path / f"{name}.csv").write_text(f"speed [mm/s], mu\n{rows}\n")
    return sorted(tmp_path.glob("Fett_*.csv"))


def test_repeats_are_one_row_of_a_comparison(files):
    ds = stickslip.compare(files, **SYSTEM, same="fett_a*", draws=200, threads=1)
    assert sorted(ds["material"].values) == ["Fett_B", "fett_a"]
    row = ds.sel(material="fett_a")
    assert int(row["repeats"]) == 3
    assert str(row["repeat_names"].item()).split("; ") == ["Fett_A1", "Fett_A2", "Fett_A3"]
    assert int((ds["point_material"] == "fett_a").sum()) == 36
    assert all(str(path) in ds.attrs["files"] for path in files)
    assert float(row["quiet_above_low"]) < float(row["quiet_above"]) < float(row["quiet_above_high"])


def test_fit_names_the_repeats_on_screen(files):
    said = call("fit", *files, "--same", "Fett_A*")
    assert said.exit_code == 0, said.output
    assert "3 repeats (Fett_A1, Fett_A2, Fett_A3)" in " ".join(said.output.split())


@pytest.mark.parametrize("same", few([["Fett_C*"], ["Fett_B"], ["Fett_A*", "*1"]], 1))
def test_a_pattern_without_two_materials_of_its_own_is_refused(same, files):
    with pytest.raises(ConfigError, match="expected two or more"):
        fit_materials(files, same=same)
    options = [option for one in same for option in ("--same", one)]
    assert call("fit", *files, *options).exit_code == 2


def test_columns_of_a_table_may_be_repeats(tmp_path):
    a, b, c = specimens(np.random.default_rng(6), 3)
    rows = "\n".join(f"{1000 * v}; {x}; {y}; {z}" for v, x, y, z in zip(SPEEDS, a, b, c, strict=True))
    (tmp_path / "table.csv").write_text(f"speed [mm/s]; oil 1; oil 2; paste\n{rows}\n")
    fits = fit_materials([tmp_path / "table.csv"], same=["oil *"])
    assert [one.name for one in fits] == ["oil", "paste"]
    assert fits[0].curve.points == 24


def test_ageing_has_no_repeats(tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.csv").write_text("time [s], mu\n1, 0.1\n10, 0.12\n100, 0.14\n1000, 0.16\n")
    with pytest.raises(ConfigError, match="friction over speed"):
        fit_materials(sorted(tmp_path.glob("*.csv")), same=["*"])
