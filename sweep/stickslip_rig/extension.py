"""What the engine is told of test rigs."""

from stickslip.extensions import Extension, StudyEntry

EXTENSION = Extension(
    commands={"Test rigs": {"rig": "stickslip_rig.commands.rig"}},
    calls={"rig": "stickslip_rig.api"},
    quantities={"drive": "stickslip_rig.drive:DRIVE"},
    studies={
        "drive": StudyEntry(
            "stickslip_rig.simulation:RigTests",
            beside={
                "sensor": "stickslip_rig.sections:Sensor",
                "features": "stickslip_rig.sections:FeatureSettings",
                "risk": "stickslip_rig.risk:Risk",
            },
            apart="rig",
        )
    },
    marks={"model_rpn": "drive"},
    resolvers={"explain.observed.*.record": "stickslip_rig.observation:with_records",
               "explain.observed.*.drive": "stickslip_rig.observation:with_records"},
)  # fmt: skip
