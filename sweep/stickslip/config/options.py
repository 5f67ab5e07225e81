"""The sections `solver` and `output` as options of the engine."""

from dataclasses import replace
from math import inf

from stickslip.config.model import Config
from stickslip.engine import Options


def options_of(config: Config) -> Options:
    """The options with which cells of a configuration are integrated."""
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


def map_options_of(config: Config) -> Options:
    """The options of a map, of which some variables may be all that is kept."""
    return replace(options_of(config), variables=config.output.variables)
