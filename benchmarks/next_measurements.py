"""Two more points where `compare` proposes them: how far the interval of the border shrinks, and how far it was to.

python benchmarks/next_measurements.py 40
"""

import sys

import numpy as np

import stickslip

SYSTEM = {"mass": 0.1, "stiffness": 5000.0, "normal_load": 10.0, "damping": 1.0}
REPEATS = 3  # of the two new points
OPTIONS = {"draws": 600, "scan": 40, "tolerance": 1e-6}


def main(cases: int) -> None:
    """Print the mean width, over that without more points: as expected, as found, and with two speeds at random."""
    random = np.random.default_rng(7)
    truth, points = {}, {}
    for i in range(cases):
        a4, a1 = 10 ** random.uniform(-2.2, -1.3), random.uniform(0.1, 0.4)
        a3 = a1 * random.uniform(0.3, 0.9)
        curve, scatter = (a1, a3 / a4 * 10 ** random.uniform(-2.5, -1), a3, a4), a3 * 10 ** random.uniform(-2, -1.3)
        speed = np.geomspace(a4 * random.uniform(0.02, 0.2), a4 * random.uniform(8, 25), random.integers(8, 25))
        truth[f"m{i:03d}"] = curve, scatter
        points[f"m{i:03d}"] = speed, measured(random, speed, curve, scatter)
    ds = stickslip.compare(points, **SYSTEM, **OPTIONS).sortby("material")
    width = (ds["quiet_above_high"] - ds["quiet_above_low"]).where(np.isfinite(ds["quiet_above_high"])).values
    expected = (ds["next_high"] - ds["next_low"]).values / width
    ends = np.log(ds["slowest_point"].values), np.log(ds["fastest_point"].values)
    proposed = np.stack([ds["next_speed_1"], ds["next_speed_2"]], axis=1)
    anywhere = np.exp(random.uniform(*(end[:, None] for end in ends), (cases, 2)))
    found = [again(random, truth, points, speeds) / width for speeds in (proposed, anywhere)]
    known = np.isfinite(expected) & np.isfinite(found).all(axis=0)
    print(f"{known.sum()} of {cases} with a closed interval: expected {expected[known].mean():.2f}, "
          f"found {found[0][known].mean():.2f}, two speeds at random {found[1][known].mean():.2f}")  # fmt: skip


def measured(random, speed, curve, scatter):
    """Friction of a curve with noise."""
    a1, a2, a3, a4 = curve
    return np.maximum(a1 + a2 * speed + a3 * np.exp(-speed / a4) + random.normal(0, scatter, speed.size), 0)


def again(random, truth, points, speeds):
    """The mean width of the intervals with two more points at these speeds (cases, 2)."""
    more = {
        f"{name}_{repeat}": tuple(map(np.append, points[name], (two, measured(random, two, *truth[name]))))
        for name, two in zip(points, np.nan_to_num(speeds, nan=0.01), strict=True)
        for repeat in range(REPEATS)
    }
    ds = stickslip.compare(more, **SYSTEM, **OPTIONS).sortby("material")
    return (ds["quiet_above_high"] - ds["quiet_above_low"]).values.reshape(-1, REPEATS).mean(axis=1)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
