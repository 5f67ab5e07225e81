"""The section `explain`: what was observed, which laws of friction may explain it, and how its draws are made."""

import math
import re
from typing import Annotated, Any

import numpy as np
from pydantic import Field, create_model

from stickslip.config.sections import Read, Section, StudySection, each_with_unit, list_of, one_of, refused, with_rows
from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.flags import DECIDED
from stickslip.vocabulary.models import WRITTEN_LAWS
from stickslip.vocabulary.parameter import Parameter, Variable, table
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import TRACE_VARIABLES, VARIABLES

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


def law_of(name: str) -> tuple[str, dict[str, float]]:
    """The law of friction of a name, and the parameters that it has then."""
    return NAMED_LAWS.get(name, (name, {}))


POINT = "friction_coefficient"  # of steady sliding at the speed of the belt, as a tribometer measures it
METRICS = {
    name: row for name, row in VARIABLES.items() if row.when != "full" and name not in ("regime", "status", "steps")
} | {POINT: TRACE_VARIABLES[POINT]}
_PLUS_MINUS = re.compile(r"\s*(?:\+-|\+/-|±)\s*")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_RESOLVED = 1e-3  # relative standard deviation: of features no more is known, since a record has samples
_FORMS = "a value above 0 with its standard deviation, such as '{} +- {}', or a list of repeats"


class Measured(Section):
    """A measured result, in SI: a value with its standard deviation, or repeats.

    discrepancy : relative standard deviation of what is systematic, besides the scatter of repeats. trials : of what is
    no result of a cell, the repeats that a simulation is the mean of, which scatter as well.
    """

    value: float | None = None
    scatter: float | None = None
    repeats: tuple[float, ...] | None = None
    discrepancy: float | None = None
    trials: int | None = None

    @property
    def log_mean(self) -> float:
        """The mean of the logarithm."""
        return float(np.mean(np.log(self.repeats or (self.value or 1.0,))))

    @property
    def log_std(self) -> float:
        """The standard deviation of the logarithm; of repeats that of their mean, as they scatter."""
        if self.repeats is None:
            return float(self.scatter or 0.0) / float(self.value or 1.0)
        count = len(self.repeats)
        spread = float(np.log(self.repeats).std(ddof=1)) if count > 1 else 0.0
        if self.trials is None:
            return spread / math.sqrt(count)
        return math.hypot(spread * math.sqrt(1.0 / count + 1.0 / self.trials), self.discrepancy or _RESOLVED)

    @property
    def freedom(self) -> float:
        """Degrees of freedom of Student's distribution; infinite for the normal one."""
        return math.inf if self.repeats is None or self.discrepancy else len(self.repeats) - 1


def _read_measured(row: Variable) -> Read:
    """How a measured result of this row is read."""
    unit, number = units.spelled(row.units), "0.5"
    forms = _FORMS.format(number, f"0.02 {unit}".rstrip())

    def si(text: Any) -> float:
        if isinstance(text, str) and _NUMBER.fullmatch(text.strip()):  # part of a text; alone it is in SI
            text = float(text)
        try:
            value = units.si_value(text, row.units)
        except QuantityError as error:
            raise refused(error.expected, error.hint, error.kind) from None
        if not 0.0 < value < math.inf:
            raise refused(forms, "its logarithm is what is compared")
        return value

    def read(given: Any) -> Any:
        if isinstance(given, Measured | dict):
            return given
        if isinstance(given, list | tuple):
            repeats = tuple(map(si, each_with_unit(row, given)))
            if len(set(repeats)) < 2:
                raise refused(f"{forms}; of repeats two at least, which differ", "their scatter is taken from them")
            return {"repeats": repeats}
        parts = _PLUS_MINUS.split(given) if isinstance(given, str) else []
        if len(parts) != 2:
            raise refused(forms, "without a scatter nothing agrees or disagrees with it" if given else None)
        value, scatter = (part.strip() for part in parts)
        if scatter.endswith("%") and _NUMBER.fullmatch(scatter[:-1].strip()):
            return {"value": si(value), "scatter": si(value) * float(scatter[:-1]) / 100}
        numbers = [float(part) if _NUMBER.fullmatch(part) else part for part in (value, scatter)]
        return dict(zip(("value", "scatter"), map(si, each_with_unit(row, numbers)), strict=True))  # 54 +- 2 ms

    text = {"type": "string", "pattern": r"(\+-|\+/-|±)", "examples": [f"{number} +- 0.02 {unit}".rstrip()]}
    plain = {"type": "object", "properties": {"value": {"type": "number"}, "scatter": {"type": "number"},
                                              "repeats": {"type": "array", "items": {"type": "number"}}}}  # fmt: skip
    return Read(read, {"anyOf": [text, {"type": "array", "minItems": 2}, plain]})


def _share(given: Any) -> Any:
    """`2 %`, or 0.02."""
    is_percent = isinstance(given, str) and given.strip().endswith("%")
    try:
        share = float(given.strip()[:-1]) / 100 if is_percent else given
    except ValueError:
        share = None
    if not isinstance(share, int | float) or not 0 <= share < 1:
        raise refused("a relative standard deviation, such as 2 %")
    return share


_SCATTER = Read(_share, {"anyOf": [{"type": "number", "minimum": 0, "exclusiveMaximum": 1},
                                   {"type": "string", "pattern": "%$", "examples": ["2 %"]}]})  # fmt: skip
_OF_METRICS: dict[str, Any] = {
    name: (Annotated[Measured | None, _read_measured(row)], Field(None, description=row.long_name))
    for name, row in METRICS.items()
}
_REGIMES = list_of(DECIDED, "a regime, or a list of those it may have been", unique=True, single=True)


class Observation(create_model("_Observed", __base__=with_rows(Section, PARAMETERS, varied=True), **_OF_METRICS)):  # type: ignore[misc]
    """One observation: the conditions, in which it differs from others, and what was seen: a regime, results, or both.

    A regime alone counts; several are those that it may have been.
    """

    regime: Annotated[tuple[Annotated[str, one_of(DECIDED, "a regime")], ...] | None, _REGIMES] = Field(
        None, description="regime that was seen, or a list of those it may have been"
    )
    record: str | None = Field(None, description="CSV file of a record of a rig, which is compared by its features")
    drive: dict[str, Any] | None = Field(None, description="configuration of the rig of the record, or its file")
    scatter: Annotated[float | None, _SCATTER] = Field(
        None, description="how far features may be off those of the simulated rig, besides the scatter of strokes"
    )
    features: dict[str, tuple[float, ...]] | None = Field(None, description="of each stroke that counts, in SI")
    known: tuple[str, ...] | None = Field(None, description="signals and conditions that the record has")

    @property
    def conditions(self) -> dict[str, float]:
        """The parameters of a cell that it was made at."""
        return {name: value for name, value in self if name in PARAMETERS and value is not None}

    @property
    def metrics(self) -> dict[str, Measured]:
        """The results that were measured."""
        return {name: value for name, value in self if name in METRICS and value is not None}

    @property
    def of_record(self) -> dict[str, Measured]:
        """The features of the record; one stroke is simulated."""
        return {name: Measured(repeats=values, discrepancy=self.scatter, trials=1)
                for name, values in (self.features or {}).items()}  # fmt: skip

    @property
    def words(self) -> str:
        """`belt_speed 0.02 m/s, normal_load 10 N: stick_slip, period 0.054 s`."""
        where = ", ".join(f"{name} {PARAMETERS[name].setting(value)}" for name, value in self.conditions.items())
        what = [" or ".join(self.regime or ())] + [
            f"{name} {math.exp(measured.log_mean):.4g} {units.spelled(METRICS[name].units)}".rstrip()
            for name, measured in self.metrics.items()
        ]
        if self.record is not None:
            motion = "stick-slip" if self.regime == ("stick_slip",) else "motion without stick-slip"
            return f"record {self.record}: {motion}, {len(self.of_record)} features"
        return f"{where or 'everywhere'}: {', '.join(filter(None, what))}"


class Explain(with_rows(StudySection, EXPLAIN)):  # type: ignore[misc]
    """Observations, and the draws of the uncertain quantities that explain them."""

    key = "explain"
    observed: tuple[Observation, ...] = Field(
        description="observations: conditions, and regime, results or both",
        json_schema_extra={"type": "array", "minItems": 1, "items": {"type": "object"}},
    )
    laws: Annotated[
        tuple[Annotated[str, one_of(EXPLAINING_LAWS, "a law of friction")], ...] | None,
        list_of(EXPLAINING_LAWS, "a law of friction, or a list of them", unique=True, single=True),
    ] = Field(
        None, description="laws of friction, as alternatives of the same probability; that of friction unless given"
    )

    @property
    def shared(self) -> dict[str, float]:
        """The conditions that all observations have in common, at which regimes are predicted."""
        first, *others = (observation.conditions for observation in self.observed)
        return {name: value for name, value in first.items() if all(other.get(name) == value for other in others)}
