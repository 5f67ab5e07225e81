"""Records at steps of speed and load become points of friction, known as well as their samples tell."""

import numpy as np
import pytest

from helpers.commands import call
from helpers.data import cases
from stickslip.theory import stribeck
from stickslip_materials.fit import CURVE_COLUMNS, read_points, step_points

CURVE = {"a1": 0.12, "a2": 0.2, "a3": 0.08, "a4": 0.01}
SPEEDS = np.array([1, 2, 5, 10, 20, 50, 100, 200, 50, 10]) / 1000  # m/s
RATE = 50  # samples a second


def record(speeds=SPEEDS, seconds=20.0, ramp=1.0, noise=0.01, memory=0.5, unrest=0.0, seed=1):
    """Time, friction and speed: ramps, running-in over a second, noise whose correlation is `memory` from sample to
    sample; unrest : noise of the measured speed, as a share of it."""
    random = np.random.default_rng(seed)
    time = np.arange(int((seconds + ramp) * RATE * len(speeds))) / RATE
    step = np.minimum((time / (seconds + ramp)).astype(int), len(speeds) - 1)
    since = time - step * (seconds + ramp)
    before = np.asarray(speeds)[np.maximum(step - 1, 0)]
    speed = before + (np.asarray(speeds)[step] - before) * np.minimum(since / max(ramp, 1e-9), 1.0)
    error = np.empty(time.size)
    error[0] = random.standard_normal()
    pushes = np.sqrt(1 - memory**2) * random.standard_normal(time.size)
    for i in range(1, time.size):
        error[i] = memory * error[i - 1] + pushes[i]
    friction = stribeck(speed, **CURVE) + 0.05 * np.exp(-since) + noise * error
    return time, friction, speed * (1 + unrest * random.standard_normal(time.size))


@pytest.mark.parametrize(
    "how", [{}, {"unrest": 0.02}, {"unrest": 0.1}, {"ramp": 0.0}, {"ramp": 5.0, "unrest": 0.02}, {"noise": 0.0}]
)
def test_each_step_is_a_point_and_a_speed_visited_again_another(how):
    found = step_points(*record(**how))
    assert found.speed == pytest.approx(SPEEDS, rel=0.01)
    assert found.mu == pytest.approx(stribeck(SPEEDS, **CURVE), rel=0.04)


def test_the_error_of_a_mean_counts_samples_that_follow_each_other_once():
    """Taken as independent, fifty samples a second of noise that remembers a fifth of one have errors four times
    too small; the means of 80 steps differ from the truth by theirs."""
    score, naive = [], []
    for seed in range(8):
        found = step_points(*record(memory=0.9, seconds=40, seed=seed))
        wrong = found.mu - stribeck(found.speed, **CURVE)
        score.append(wrong / found.sigma)
        naive.append(wrong / (found.scatter / np.sqrt((found.end - found.begin) * RATE)))
    assert 0.8 < np.sqrt(np.mean(np.concatenate(score) ** 2)) < 1.25
    assert np.sqrt(np.mean(np.concatenate(naive) ** 2)) > 3


@pytest.mark.parametrize("unrest", [0.0, 0.02])
def test_a_ramp_has_no_steps(unrest):
    time = np.arange(20000) / 100
    speed = np.linspace(0.001, 0.2, time.size) * (1 + unrest * np.random.default_rng(1).standard_normal(time.size))
    friction = stribeck(speed, **CURVE) + 0.001 * np.random.default_rng(2).standard_normal(time.size)
    with pytest.raises(ValueError, match="expected half or more"):
        step_points(time, friction, speed)


def test_steps_too_short_for_a_mean_are_left_out_and_named():
    found = step_points(*record(memory=0.995))
    assert found.speed.size + len(found.left_out) >= SPEEDS.size
    assert any("independent" in text or "settle" in text for text in found.left_out)
    time, friction, speed = record()
    rest = speed.copy()
    rest[: 20 * RATE] = 0.0
    assert any("at rest" in text for text in step_points(time, friction, rest).left_out)


def test_friction_below_zero_is_a_question_about_the_sensor():
    time, friction, speed = record()
    with pytest.raises(ValueError, match="sign"):
        step_points(time, -friction, speed)
    assert step_points(time, -friction, -speed).mu == pytest.approx(step_points(time, friction, speed).mu)


def written(folder, heading, *columns, name="disc.csv", comma=True):
    text = "\n".join(";".join(f"{value:.6g}" for value in row) for row in zip(*columns, strict=True))
    path = folder / name
    path.write_text(f"{heading}\n{text.replace('.', ',') if comma else text}\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("heading", [
    "Zeit [s];Drehzahl [U/min];Reibkraft [mN];Normalkraft [N];Temperatur [\u00b0C]",
    "Zeit;Drehzahl;Reibkraft;Normalkraft;Temperatur\ns;U/min;mN;N;\u00b0C",
])  # fmt: skip
def test_a_german_pin_on_disc_record_becomes_points_that_fit_reads(heading, tmp_path):
    time, friction, speed = record(noise=0.002)
    turns, load = speed / 0.02 / (2 * np.pi) * 60, np.full(time.size, 10.0)
    path = written(tmp_path, heading,
                   time, turns, 1e4 * friction, load, np.full(time.size, 21.5))  # fmt: skip
    said = call("points", path, "-o", tmp_path / "points.csv", "--radius", "20 mm")
    assert said.exit_code == 0, said.output
    points = read_points(tmp_path / "points.csv", CURVE_COLUMNS)
    assert points["speed"] == pytest.approx(SPEEDS, rel=0.01)
    assert points["mu"] == pytest.approx(stribeck(SPEEDS, **CURVE), rel=0.02)
    assert (points["sigma"] > 0).all()
    assert call("fit", tmp_path / "points.csv").exit_code == 0


def test_a_plan_says_what_was_set_and_when(tmp_path):
    time, friction, _ = record(noise=0.002)
    path = written(tmp_path, "time [s];COF", time, friction)
    begins = 21.0 * np.arange(SPEEDS.size) + 1
    plan = written(tmp_path, "begin [s];end [s];speed [mm/s];load [N]", begins, begins + 20, 1000 * SPEEDS,
                   np.full(SPEEDS.size, 10.0), name="plan.csv")  # fmt: skip
    said = call("points", path, "-o", tmp_path / "points.csv", "--plan", plan, "--settle", "5 s")
    assert said.exit_code == 0, said.output
    points = read_points(tmp_path / "points.csv", CURVE_COLUMNS)
    assert points["speed"] == pytest.approx(SPEEDS)
    assert points["mu"] == pytest.approx(stribeck(SPEEDS, **CURVE), rel=0.02)


@cases("materials.yaml")
def test_what_is_not_understood_of_a_record_is_refused(heading, options, words, tmp_path):
    columns = [np.arange(100), *[np.full(100, 0.5)] * heading.count(";")]
    said = call("points", written(tmp_path, heading, *columns), "-o", tmp_path / "points.csv", *options)
    assert said.exit_code == 2
    assert words in said.output
    assert not (tmp_path / "points.csv").exists()
