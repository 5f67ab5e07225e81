"""A stick-slip test rig, simulated or measured: an extension of `stickslip`.

`stickslip rig run` computes tests on a simulated rig, `stickslip rig features` evaluates records of a measured one,
`stickslip rig calibrate` fits the risk number; `stickslip.rig` does so in Python.

    extension.py   what the engine is told      api.py         the names in `stickslip.rig`
    commands/      `stickslip rig ...`          sections.py, checks.py, drive.py, vocabulary.py   configurations
    records.py, settings.py, signals.py, quantities.py   records, read and named
    sticks.py, drive_motion.py, evaluation.py, tables.py   stick phases, features, tables of them
    dropouts.py, hum.py, defects.py   what is wrong with a record
    apparatus.py, simulation.py   simulated rigs     risk.py, calibration.py, pairs.py   the risk number
    observation.py, observed_records.py   records as observations      plots.py, report.py   pictures and pages
"""
