"""The numbers that an explanation is asked with, and the laws of friction that may explain."""

from stickslip.vocabulary.models import WRITTEN_LAWS
from stickslip.vocabulary.parameter import Parameter, table

EXPLAIN: dict[str, Parameter] = table(
    Parameter("mislabelled", "1", "probability that the regime of an observation was noted wrongly", "explain",
              default=0.01, above=0, at_most=0.5),
    Parameter("particles", "1", "draws of each population", "explain",
              default=500, at_least=20, at_most=1_000_000, whole=True),
    Parameter("repetitions", "1", "independent populations of each law, whose spread is the standard error", "explain",
              default=4, at_least=2, at_most=1000, whole=True),
    Parameter("draws", "1", "draws of each population that regimes over the axes are predicted from", "explain",
              default=64, at_least=1, at_most=1_000_000, whole=True),
    Parameter("seed", "1", "seed of the populations: the same seed, the same draws", "explain",
              default=1, at_least=0, at_most=2**32 - 1, whole=True),
)  # fmt: skip

# Names that explanations have for laws with a certain parameter: the law, and that parameter.
NAMED_LAWS: dict[str, tuple[str, dict[str, float]]] = {"gaussian": ("stribeck_delta", {"delta": 2.0})}
EXPLAINING_LAWS = (*WRITTEN_LAWS, *NAMED_LAWS)
OF_PRIOR = ("correlation", "fit")  # keys of `prior` beside quantities and laws, words of `uncertain`


def law_of(name: str) -> tuple[str, dict[str, float]]:
    """The law of friction of a name, and the parameters that it has then."""
    return NAMED_LAWS.get(name, (name, {}))
