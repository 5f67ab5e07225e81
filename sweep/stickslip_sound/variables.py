"""The variables of levels: how loud cells are."""

from stickslip.vocabulary.parameter import Variable
from stickslip.vocabulary.results import VARIABLES

LEVEL = Variable(
    "acceleration_level_a", "1", "time-average A-weighted level of the acceleration, dB re 1e-6 m/s2",
    comment="Of the limit cycle, from the Fourier series of one period, up to 20 kHz; IEC 61672-1, ISO 1683. No level "
    "of sound pressure: levels of cells can be compared with each other. NaN where there is no cycle; -inf where "
    "nothing of it is heard.",
)  # fmt: skip
LEVEL_VARIABLES: dict[str, Variable] = {
    name: VARIABLES[name] for name in ("regime", "status", "period", "frequency", "damping_ratio")
} | {LEVEL.name: LEVEL}
