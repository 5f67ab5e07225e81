"""The section `solver` as options of the engine."""

from __future__ import annotations

from math import inf

from stickslip.config.model import Config
from stickslip.engine import Options


def options_of(config: Config) -> Options:
    """How a configuration wants to be integrated."""
    solver, execution = config.solver, config.execution
    return Options(
        law=config.friction.law,
        rtol=solver.rtol,
        horizon=inf if solver.horizon is None else solver.horizon,
        max_steps=solver.max_steps,
        early_stop=solver.early_stop,
        threads=execution.threads,
        block=execution.block,
    )
