"""What the words of a file of observations stand for.

    observed: [...]              explain: {observed: [...]}
    prior: {mass: 100 g}         system: {mass: 100 g}
    prior: {a1: {uniform: ...}}  uncertain: {quantities: {a1: {uniform: ...}}}
    prior: {laws: [...]}         explain: {laws: [...]}, and friction: {law: ...} of the first
    predict: {axes: ...}         axes: ...

so that priors are read, checked and drawn as all uncertain quantities are. Places in the file stay what they were.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import reduce
from operator import getitem
from typing import Any

from stickslip.config.problems import ProblemCollector
from stickslip.config.yaml import Document
from stickslip.errors import Path
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip_explain.section import EXPLAIN, law_of

_OF_PRIOR = ("correlation", "fit")  # keys of `prior` beside quantities and laws, words of `uncertain`
OWN_WORDS = ("observed", "prior", "predict", *EXPLAIN)  # at the top of a file of observations


def with_observations(document: Document) -> Document:
    """The document of a configuration that a file of observations stands for; any other as it is.

    Raises ConfigError for what has no place in one.
    """
    data = document.data
    if not isinstance(data, dict) or not {"observed", "prior"} & data.keys():
        return document
    _check_words(document)
    whole: dict[str, Any] = {key: value for key, value in data.items() if key not in OWN_WORDS}
    before: tuple[dict[Path, Any], ...] = (document.keys, document.values, document.texts)
    after = [{p: place for p, place in places.items() if not p or p[0] not in OWN_WORDS} for places in before]
    moves = list(_moves(data))
    for old, new in moves:
        inside: Any = whole
        for key in new[:-1]:
            inside = inside.setdefault(key, {})
        inside[new[-1]] = reduce(getitem, old, data)
        for places, moved in zip(before, after, strict=True):
            moved |= {(*new, *p[len(old) :]): place for p, place in places.items() if p[: len(old)] == old}
            for length in range(1, len(new)) if old[:1] in places else ():  # one word stands for several sections
                moved.setdefault(new[:length], places[old[:1]])
    laws = whole["explain"].get("laws")
    first = laws[0] if isinstance(laws, list) and laws else laws
    if isinstance(first, str):
        whole.setdefault("friction", {}).setdefault("law", law_of(first)[0])
    keys, values, texts = after
    return replace(document, data=whole, keys=keys, values=values, texts=texts, moved={new: old for old, new in moves})


def _check_words(document: Document) -> None:
    """Raise ConfigError for what is wrong with the words themselves."""
    data, problems = document.data, ProblemCollector(document)
    if not isinstance(data.get("observed"), list) or not data["observed"]:
        example = "observed: [{belt_speed: 20 mm/s, normal_load: 10 N, regime: stick_slip}]"
        problems.add(("observed",), "no observation, expected a list of what was seen", example, at_key=True)
    if "prior" not in data:
        problems.add(("prior",), "missing, expected what is known before: values and distributions of quantities")
    prior = problems.mapping(data.get("prior"), ("prior",), "quantities")
    problems.known_keys(prior, ("prior",), (*QUANTITIES, *_OF_PRIOR, "laws"))
    problems.keys_of(data.get("predict"), ("predict",), ("axes", "draws"))
    for key in {"uncertain", "axes", "explain"} & data.keys():
        problems.add((key,), "got it besides observed and prior, expected one of them", at_key=True)
    problems.raise_any()


def _moves(data: dict[str, Any]) -> Iterator[tuple[Path, Path]]:
    """Where things stand in a file of observations, and where in a configuration."""
    for key in ("observed", *EXPLAIN):
        if key in data:
            yield (key,), ("explain", key)
    for name, value in data["prior"].items():
        if name == "laws":
            yield ("prior", name), ("explain", name)
        elif name in _OF_PRIOR:
            yield ("prior", name), ("uncertain", name)
        elif isinstance(value, dict):
            yield ("prior", name), ("uncertain", "quantities", name)
        else:
            yield ("prior", name), (QUANTITIES[name].section, name)
    for name in data.get("predict", {}):
        yield ("predict", name), ("axes",) if name == "axes" else ("explain", name)
