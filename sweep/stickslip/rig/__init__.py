"""Records of a stick-slip test rig, measured or simulated, and their evaluation.

A record is a dataset over `time` (s): the force on the specimen and its acceleration, the motion of the drive where it
is known, and the conditions of the test as coordinates.

    records/     records read from files, or made            quantities, settings, words   what all of them share
    analysis/    their stick phases and features             risk       the model RPN, not the rig maker's
    simulate/    records of simulated rigs, and parameters identified from a measured record
    report/      plots, and the page about a test matrix

`quantities.FEATURES` declares each feature.

What simulates rigs is loaded when first used, so that records are read without the compiler.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from stickslip.rig.analysis.calibrate import Calibration, calibrate
from stickslip.rig.analysis.sticks import Sticks, find_sticks
from stickslip.rig.analysis.table import feature_table, features
from stickslip.rig.records.record import make_record, read_record
from stickslip.rig.risk import RPN_NAME, Risk
from stickslip.rig.settings import FeatureSettings, RecordSettings, Settings, load_settings
from stickslip.rig.simulate.identify import Identification, identify

if TYPE_CHECKING:
    from stickslip.rig.simulate.config import RigConfig, load_rig, make_rig
    from stickslip.rig.simulate.matrix import run_matrix
    from stickslip.rig.simulate.parametric import simulator
    from stickslip.rig.simulate.simulation import RigTests

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
    return getattr(import_module(f".simulate.{_HOMES[name]}", __name__), name)
