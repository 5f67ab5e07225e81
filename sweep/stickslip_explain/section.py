"""What a file says of explanations: the section `explain`, a file of observations alone, draws of an explanation."""

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from operator import getitem
from pathlib import Path as FilePath
from typing import Annotated, Any, cast

import numpy as np
from pydantic import Field, create_model

from stickslip.config.problems import ProblemCollector
from stickslip.config.resolve import varied_paths
from stickslip.config.sections import Read, Section, StudySection, each_with_unit, list_of, one_of, refused, with_rows
from stickslip.config.yaml import Document, parse_yaml
from stickslip.errors import Path, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.models import WRITTEN_LAWS
from stickslip.vocabulary.parameter import Parameter, Variable, table
from stickslip.vocabulary.quantities import DECIDED, PARAMETERS, QUANTITIES, TRACE_VARIABLES, VARIABLES, listed

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

_OF_RECORDS = table(
    Parameter("scatter", "1", "how far features may be off those of the simulated rig, besides the scatter of strokes",
              "explain", at_least=0, at_most=1),
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

    discrepancy : relative standard deviation of what is systematic, besides that of repeats. trials : of what is no
    result of a cell, the repeats that a simulation is the mean of, which scatter as well.
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
    return Read(read, {"anyOf": [text, {"type": "array", "minItems": 2}, {"type": "object"}]})


_OF_METRICS: dict[str, Any] = {
    name: (Annotated[Measured | None, _read_measured(row)], Field(None, description=row.long_name))
    for name, row in METRICS.items()
}
_REGIMES = list_of(DECIDED, "a regime, or a list of those it may have been", unique=True, single=True)


_CONDITIONS = with_rows(with_rows(Section, PARAMETERS, varied=True), _OF_RECORDS)


class Observation(create_model("_Observed", __base__=_CONDITIONS, **_OF_METRICS)):  # type: ignore[misc]
    """One observation: the conditions, in which it differs from others, and what was seen: a regime, results, or both.

    A regime alone counts; several are those that it may have been.
    """

    regime: Annotated[tuple[Annotated[str, one_of(DECIDED, "a regime")], ...] | None, _REGIMES] = Field(
        None, description="regime that was seen, or a list of those it may have been"
    )
    record: str | None = Field(None, description="CSV file of a record of a rig, which is compared by its features")
    drive: dict[str, Any] | None = Field(None, description="configuration of the rig of the record, or its file")
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


# --- a file of observations alone -------------------------------------------------------------------------------------


# Other words, as the call in Python takes them: `observed` and the settings stand for `explain`, what `prior` knows
# for `system` and `friction`, distributions for `uncertain`, laws for those of `explain`, the first for friction's.

_OF_PRIOR: dict[str, Path] = {name: (row.section,) for name, row in QUANTITIES.items()}
_OF_PRIOR |= {"correlation": ("uncertain",), "fit": ("uncertain",), "laws": ("explain",)}
_WORDS = ("observed", *EXPLAIN)  # at the top of the file
_SECTIONS = {("explain",): ("observed",)} | {(name,): ("prior",) for name in ("uncertain", "system", "friction")}


def with_observations(document: Document) -> Document:
    """The configuration that a file of observations stands for; any other as it is. Raises ConfigError."""
    data = document.data
    if not isinstance(data, dict) or not {"observed", "prior"} & data.keys():
        return document
    problems = ProblemCollector(document)
    for key in {"observed", "prior"} - data.keys():
        problems.add((key,), "missing, expected observed, and what is known before: prior")
    prior = problems.mapping(data.get("prior", {}), ("prior",), "quantities")
    problems.known_keys(prior, ("prior",), tuple(_OF_PRIOR))
    for key in {"uncertain", "explain"} & data.keys():
        problems.add((key,), "got it besides observed and prior, expected one of them", at_key=True)
    problems.raise_any()
    moved: dict[Path, Path] = _SECTIONS | {("explain", key): (key,) for key in _WORDS if key in data}
    for name, value in prior.items():
        is_drawn = isinstance(value, dict) and name in QUANTITIES
        moved[*(("uncertain", "quantities") if is_drawn else _OF_PRIOR[name]), name] = ("prior", name)
    whole: dict[str, Any] = {key: value for key, value in data.items() if key not in (*_WORDS, "prior")}
    for new, old in list(moved.items())[len(_SECTIONS) :]:
        inside: Any = reduce(lambda part, key: part.setdefault(key, {}), new[:-1], cast(Any, whole))
        inside[new[-1]] = reduce(getitem, old, data)
    laws = whole["explain"].get("laws")
    first = laws[0] if isinstance(laws, list) and laws else laws
    if isinstance(first, str):
        whole.setdefault("friction", {}).setdefault("law", law_of(first)[0])
    before: tuple[dict[Path, Any], ...] = (document.keys, document.values, document.texts)
    keys, values, texts = (
        places | {(*new, *path[len(old) :]): place for new, old in moved.items()
                  for path, place in places.items() if path[: len(old)] == old}
        for places in before
    )  # fmt: skip
    return replace(document, data=whole, keys=keys, values=values, texts=texts, moved=moved)


# --- draws of an explanation in place of distributions ----------------------------------------------------------------


_MOST, _DIGITS = 512, 9  # rows, evenly chosen: more would say more than the explanation knows; digits of values
_KEY = "explained"
_PATH = ("uncertain", _KEY)


def with_draws(document: Document) -> Document:
    """The document, with what the explanation that its section `uncertain` names has drawn.

    Its friction is that of the law of this configuration, or else of the most probable one; quantities that it gives
    itself are left to it. Where draws stand beside the name (a resolved configuration), nothing is read.
    """
    data = document.data if isinstance(document.data, dict) else {}
    uncertain, friction = data.get("uncertain"), data.get("friction") or {}
    if not isinstance(uncertain, dict) or not isinstance(uncertain.get(_KEY), str) or not isinstance(friction, dict):
        return document
    quantities = uncertain.get("quantities") or {}
    if not isinstance(quantities, dict) or any("drawn" in row for row in quantities.values() if isinstance(row, dict)):
        return document
    file = FilePath(document.name).parent / uncertain[_KEY]
    law, known, rows = _draws(document, file if file.exists() else FilePath(uncertain[_KEY]))
    axes = data.get("axes")
    given = {str(path[-1]) for path in varied_paths(axes if isinstance(axes, dict) else {})} | {*quantities, *friction}
    given |= {name for part in data.values() if isinstance(part, dict) for name in part}
    drawn = {name: {"drawn": values} for name, values in rows.items() if name not in given}
    if not drawn:
        raise document.refused(_PATH, f"nothing is left to draw: {listed(rows, 'and')} are given here")
    friction = {name: value for name, value in known.items() if name not in given} | friction | {"law": law}
    section = {**uncertain, "quantities": {**quantities, **drawn}}
    return replace(document, data={**data, "friction": friction, "uncertain": section})


def _draws(document: Document, file: FilePath) -> tuple[str, dict[str, Any], dict[str, list[float]]]:
    """The law of friction, what the explanation took as known of it, and the values of each quantity."""
    from stickslip.files.reading import open  # xarray takes its time

    law = (document.data.get("friction") or {}).get("law")
    with open(file) as ds:
        if "posterior_law" not in ds or "configuration" not in ds.attrs:
            raise document.refused(_PATH, f"{file} holds no draws, expected what `stickslip explain` wrote")
        names = [str(name) for name in ds["law"].values]
        likely = sorted(range(len(names)), key=lambda i: -float(ds["law_probability"][i]))
        alike = [i for i in likely if law in (None, law_of(names[i])[0])]
        if not alike:
            raise document.refused(_PATH, f"{file} explains by {listed(names)}, and the law here is {law}")
        chosen = np.flatnonzero(ds["posterior_law"].values == alike[0])
        if chosen.size < 2:
            raise document.refused(_PATH, f"{file} has no draws of {names[alike[0]]}, which explains too little")
        chosen = chosen[np.linspace(0, chosen.size - 1, min(_MOST, chosen.size)).astype(int)]
        values = {str(name): ds[f"posterior_{name}"].values[chosen] for name in ds["quantity"].values}
        own: Mapping[str, Any] = parse_yaml(str(ds.attrs["configuration"])).data
    law, fixed = law_of(names[alike[0]])
    known = {name: value for name, value in own.get("friction", {}).items() if name in QUANTITIES}
    rows = {name: [float(f"{value:.{_DIGITS}g}") for value in column] for name, column in values.items()}
    return law, known | fixed, rows
