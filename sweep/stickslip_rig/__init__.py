"""A stick-slip test rig, simulated or measured: an extension of `stickslip`.

`stickslip rig run` computes tests on a simulated rig, `stickslip rig features` evaluates records of a measured one,
`stickslip rig friction` measures friction in them, `stickslip rig calibrate` fits the risk number; `stickslip.rig` does
so in Python.

    extension.py   what the engine is told      api.py         the names in `stickslip.rig`
    commands/      `stickslip rig ...`          drive.py, quantities.py, sections.py, settings.py   configurations
    records.py, signals.py   records, read      plots.py       pictures and pages
    sticks.py, drive_motion.py, evaluation.py   stick phases, features, tables of them
    specimen.py, friction.py                    friction on both branches
    dropouts.py, hum.py, defects.py             what is wrong with a record
    simulation.py  simulated rigs               observation.py records as observations of `explain`
    risk.py, calibration.py                     the risk number
"""
