"""`rig`: what concerns test rigs, simulated and measured; the spellings of earlier versions go on working."""

from __future__ import annotations

from stickslip.cli import rig as records
from stickslip.cli import rig_fits, rig_tests
from stickslip.cli.grouped import GroupWithDefault, renamed

rig = GroupWithDefault(
    "rig",
    default="run",
    sections={
        "Commands": (
            renamed(rig_tests.rig, "run"),
            renamed(records.rig_features, "features"),
            renamed(rig_fits.calibrate, "calibrate"),
            renamed(rig_fits.identify, "identify"),
        )
    },
    help="""Test rigs: simulated ones, records of measured ones, and the risk number.

    `stickslip rig my_rig.yaml` is short for `stickslip rig run my_rig.yaml`.""",
    short_help="Simulate a test rig, or evaluate records of one.",
    no_args_is_help=True,
)
OLD = (
    renamed(records.rig_features, "rig-features", hidden=True),
    renamed(rig_fits.calibrate, "calibrate", hidden=True),
)
