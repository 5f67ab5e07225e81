"""Every number that is set but is no parameter of a cell: of the solver, of what is uncertain.

By section of the configuration; what is no number (a law, a file) is declared where it is read.
"""

from stickslip.vocabulary.parameter import NAN, Parameter, table

SOLVER: dict[str, Parameter] = table(
    Parameter("rtol", "1", "relative tolerance of a step", "solver", default=1e-6, at_least=1e-12, at_most=1e-2),
    Parameter("horizon", "s", "longest time simulated per cell; no limit unless given", "solver", above=0,
              absent="no limit"),
    Parameter(
        "max_steps", "1", "step budget of a cell; when it runs out the cell is unresolved", "solver",
        default=100_000, at_least=1, at_most=2_000_000_000, whole=True,  # steps are counted in 32 bits
    ),
)  # fmt: skip
EXECUTION: dict[str, Parameter] = table(
    Parameter(
        "threads", "1", "threads; auto takes the processors of this machine", "execution",
        default=NAN, at_least=1, at_most=4096, whole=True, word="auto",
    ),
    Parameter("block", "1", "cells computed together", "execution",
              default=4096, at_least=1, at_most=1_000_000, whole=True),
)  # fmt: skip
AXIS: dict[str, Parameter] = table(  # the values of axes are held in memory, those of cells are not
    Parameter("num", "1", "number of points", "axes", at_least=2, at_most=10_000_000, whole=True)
)
UNCERTAIN: dict[str, Parameter] = table(
    Parameter(
        "draws", "1", "draws per scrambling, a power of two; with Sobol indices, quantities + 2 times as many",
        "uncertain", default=1024, at_least=2, at_most=2**30, whole=True,
    ),
    Parameter("scramblings", "1", "independent scramblings, whose spread is the standard error", "uncertain",
              default=8, at_least=2, at_most=1000, whole=True),
    Parameter("seed", "1", "seed of the scramblings: the same seed, the same draws", "uncertain",
              default=1, at_least=0, at_most=2**32 - 1, whole=True),
)  # fmt: skip
SUBSET: dict[str, Parameter] = table(
    Parameter("samples", "1", "samples of each level of a subset simulation, a multiple of 10", "uncertain",
              default=2000, at_least=100, at_most=10_000_000, whole=True),
    Parameter("repetitions", "1", "independent subset simulations, whose spread is the standard error", "uncertain",
              default=8, at_least=2, at_most=1000, whole=True),
    Parameter("seed", "1", "seed of the simulations: the same seed, the same samples", "uncertain",
              default=1, at_least=0, at_most=2**32 - 1, whole=True),
)  # fmt: skip


# --- columns of measured points ---------------------------------------------------------------------------------------

_MU = Parameter("mu", "1", "friction coefficient", "points", at_least=0)
CURVE_COLUMNS = (
    Parameter("speed", "m s-1", "slip speed", "points", at_least=0),
    _MU,
    Parameter("sigma", "1", "standard deviation of mu", "points", default=NAN, above=0),
)
AGEING_COLUMNS = (Parameter("time", "s", "waiting time", "points", at_least=0), _MU)

# All numbers of a configuration that are neither quantities nor of a study, by section.
SETTINGS: dict[str, dict[str, Parameter]] = {
    "solver": SOLVER, "execution": EXECUTION,
}  # fmt: skip
