"""From what was measured back to what causes it: draws of unknown quantities given observations, and what decides.

`smc.py` draws from any posterior over standard normal deviates; `likelihood.py` says how well cells explain
observations; `study.py` puts both together as a study, and `summary.py` reduces draws to what people read.
"""

from stickslip.studies.explain.section import Explain, Observation
from stickslip.studies.explain.study import ExplainStudy

__all__ = ["Explain", "ExplainStudy", "Observation"]
