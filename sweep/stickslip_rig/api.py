"""Records of a stick-slip test rig, measured or simulated, and their evaluation.

A record is a dataset over `time` (s): the force on the specimen and its acceleration, the motion of the drive where it
is known, and the conditions of the test as coordinates.

    quantities, settings, labels           shared by all: names and units, settings, words
    records, signals, drive                records read from files, or made; filters, slopes, gaps; motion of the drive
    sticks, hum, dropouts, defects, evaluation    stick phases, features, and what is wrong with a record
    calibration, pairs                     the model RPN fitted to records
    apparatus, simulation                  simulated rigs
    observation                            a record as an observation of `stickslip explain`
    plots, report                          plots, and the page about a test matrix

`quantities.FEATURES` declares each feature.

What simulates rigs is loaded when first used, so that records are read without the compiler. `run_matrix` is
`stickslip.run`, which computes the matrix of a configuration that `load_rig` gives, in memory or into a file.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from stickslip_rig.calibration import Calibration, calibrate
from stickslip_rig.evaluation import feature_table, features
from stickslip_rig.records import make_record, read_record
from stickslip_rig.risk import RPN_NAME, Risk
from stickslip_rig.sections import FeatureSettings
from stickslip_rig.settings import RecordSettings, Settings, load_settings
from stickslip_rig.sticks import Sticks, find_sticks

if TYPE_CHECKING:
    from stickslip_rig.observation import SimulatedRecords
    from stickslip_rig.simulation import RigTests, load_rig, make_rig

__all__ = [
    "Calibration", "FeatureSettings", "RPN_NAME", "RecordSettings", "RigTests", "Risk", "Settings",
    "SimulatedRecords", "Sticks", "calibrate", "feature_table", "features", "find_sticks", "load_rig",
    "load_settings", "make_record", "make_rig", "read_record", "run_matrix",  # noqa: F822
]  # fmt: skip

_SIMULATED = ("RigTests", "load_rig", "make_rig")


def __getattr__(name: str) -> Any:
    if name == "run_matrix":
        return import_module("stickslip.api.runs").run
    if name == "SimulatedRecords":
        return import_module("stickslip_rig.observation").SimulatedRecords
    if name not in _SIMULATED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("stickslip_rig.simulation"), name)
