"""Records of a stick-slip test rig, measured or simulated, and their evaluation.

A record is a dataset over `time` (s): the force on the specimen and its acceleration, the motion of the drive where it
is known, and the conditions of the test as coordinates. `quantities.FEATURES` declares each feature.

What simulates rigs is loaded when first used, so that records are read without the compiler. The matrix of a rig's
configuration is computed by `stickslip.run`, which has the name run_matrix here too.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from stickslip_rig.calibration import Calibration, calibrate
from stickslip_rig.evaluation import feature_table, features
from stickslip_rig.friction import friction, friction_table
from stickslip_rig.quantities import RPN_NAME
from stickslip_rig.records import make_record, read_record, read_records
from stickslip_rig.risk import Risk
from stickslip_rig.sections import FeatureSettings
from stickslip_rig.settings import RecordSettings, Settings, load_settings
from stickslip_rig.sticks import Sticks, find_sticks

if TYPE_CHECKING:
    from stickslip.api.runs import run as run_matrix
    from stickslip_rig.observation import SimulatedRecords
    from stickslip_rig.simulation import RigTests, load_rig, make_rig

__all__ = [
    "Calibration", "FeatureSettings", "RPN_NAME", "RecordSettings", "RigTests", "Risk", "Settings",
    "SimulatedRecords", "Sticks", "calibrate", "feature_table", "features", "find_sticks", "friction",
    "friction_table", "load_rig", "load_settings", "make_record", "make_rig", "read_record", "read_records",
    "run_matrix",
]  # fmt: skip

_LATER = {
    "RigTests": "stickslip_rig.simulation:RigTests", "load_rig": "stickslip_rig.simulation:load_rig",
    "make_rig": "stickslip_rig.simulation:make_rig", "run_matrix": "stickslip.api.runs:run",
    "SimulatedRecords": "stickslip_rig.observation:SimulatedRecords",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, own = _LATER[name].partition(":")
    return getattr(import_module(module), own)
