"""What is done with the record of a stick-slip test rig, measured or simulated.

A record is a dataset over `time` (s): the force on the specimen and its acceleration, the motion of the drive where it
is known, and the conditions of the test as coordinates (`records.py`). From it come the stick phases (`sticks.py`), the
features (`features.py`), the model RPN, not the rig maker's (`risk.py`), and pictures (`drawing.py`); `calibrate.py`
fits the risk model to measured numbers, `identify.py` the parameters of a simulated rig to a measured record.
`quantities.FEATURES` says what each feature is.

What simulates rigs is loaded when first used, so that records are read without the compiler.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from stickslip.rig.calibrate import Calibration, calibrate
from stickslip.rig.features import feature_table, features
from stickslip.rig.identify import Identification, identify
from stickslip.rig.records import make_record, read_record
from stickslip.rig.risk import RPN_NAME, Risk
from stickslip.rig.settings import FeatureSettings, RecordSettings, Settings, load_settings
from stickslip.rig.sticks import Sticks, find_sticks

if TYPE_CHECKING:
    from stickslip.rig.config import RigConfig, load_rig, make_rig
    from stickslip.rig.matrix import run_matrix
    from stickslip.rig.parametric import simulator
    from stickslip.rig.simulation import RigTests

__all__ = [
    "Calibration", "FeatureSettings", "Identification", "RPN_NAME", "RecordSettings", "RigConfig", "RigTests", "Risk",
    "Settings", "Sticks", "calibrate", "feature_table", "features", "find_sticks", "identify", "load_rig",
    "load_settings", "make_record", "make_rig", "read_record", "run_matrix", "simulator",
]  # fmt: skip

_HOMES = {
    "RigConfig": "config", "load_rig": "config", "make_rig": "config", "RigTests": "simulation", "run_matrix": "matrix",
    "simulator": "parametric",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)
