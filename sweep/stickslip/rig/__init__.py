"""What is done with the record of a stick-slip test rig, measured or simulated.

A record is a dataset over `time` (s): the force on the specimen and its acceleration, the motion of the drive where it
is known, and the conditions of the test as coordinates (`records.py`). From it come the stick phases (`sticks.py`), the
features (`features.py`), the model RPN, not the rig maker's (`risk.py`), and pictures (`drawing.py`); `calibrate.py`
fits the risk model to measured numbers, `identify.py` the parameters of a simulated rig to a measured record.
Definitions are in docs/rig.md.
"""

from stickslip.rig.calibrate import Calibration, calibrate
from stickslip.rig.features import feature_table, features
from stickslip.rig.identify import Identification, identify
from stickslip.rig.records import make_record, read_record
from stickslip.rig.risk import RPN_NAME, Risk
from stickslip.rig.settings import FeatureSettings, RecordSettings, Settings, load_settings
from stickslip.rig.sticks import Sticks, find_sticks

__all__ = [
    "Calibration", "FeatureSettings", "Identification", "RPN_NAME", "RecordSettings", "Risk", "Settings", "Sticks",
    "calibrate", "feature_table", "features", "find_sticks", "identify", "load_settings", "make_record", "read_record",
]  # fmt: skip
