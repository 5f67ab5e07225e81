"""Files of observations in the words of a configuration: `observed`, `prior` and `predict` stand for other sections.

    observed: [...]              explain: {observed: [...]}
    prior: {mass: 100 g}         system: {mass: 100 g}
    prior: {a1: {uniform: ...}}  uncertain: {quantities: {a1: {uniform: ...}}}
    prior: {laws: [...]}         explain: {laws: [...]}, and friction: {law: ...} of the first
    predict: {axes: ...}         axes: ...

so that priors are read, checked and drawn as all uncertain quantities are. Places in the file stay what they were.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from stickslip.config.yaml import Document
from stickslip.errors import ConfigError, Path, Problem
from stickslip.vocabulary.explained import OF_PRIOR, SETTINGS, law_of
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.suggest import did_you_mean, listed

OWN_WORDS = ("observed", "prior", "predict", *SETTINGS)  # at the top of a file of observations
_WORDS_OF_PREDICT = ("axes", "draws")


def with_observations(document: Document) -> Document:
    """The document of a configuration that a file of observations stands for; any other as it is.

    Raises ConfigError for what has no place in one.
    """
    data = document.data
    if not isinstance(data, dict) or not {"observed", "prior"} & data.keys():
        return document
    problems = [_problem(document, path, text, hint) for path, text, hint in _wrong(data)]
    if problems:
        raise ConfigError(document.name, problems)
    moves = dict(_moves(data))
    whole: dict[str, Any] = {key: value for key, value in data.items() if key not in OWN_WORDS}
    for old, new in moves.items():
        inside: Any = whole
        value: Any = data
        for key in old:
            value = value[key]
        for key in new[:-1]:
            inside = inside.setdefault(key, {})
        inside[new[-1]] = value
    laws = whole["explain"].get("laws")
    first = laws[0] if isinstance(laws, list) and laws else laws
    if isinstance(first, str):
        whole.setdefault("friction", {}).setdefault("law", law_of(first)[0])
    keys, values, texts = (_moved(places, moves) for places in (document.keys, document.values, document.texts))
    return replace(document, data=whole, keys=keys, values=values, texts=texts)


def _wrong(data: dict[str, Any]) -> Iterator[tuple[Path, str, str | None]]:
    """Path, message and hint of what is wrong with the words themselves."""
    if not isinstance(data.get("observed"), list) or not data["observed"]:
        text = "no observation, expected a list of what was seen"
        yield ("observed",), text, "observed: [{belt_speed: 20 mm/s, normal_load: 10 N, regime: stick_slip}]"
    for key in ("prior", "predict"):
        if key in data and not isinstance(data[key], dict):
            yield (key,), "expected a mapping", None
    if "prior" not in data:
        yield ("prior",), "missing, expected what is known before: values and distributions of quantities", None
    prior = data.get("prior")
    for name in prior if isinstance(prior, dict) else ():
        if name not in QUANTITIES and name not in (*OF_PRIOR, "laws"):
            hint = did_you_mean(name, [*QUANTITIES, *OF_PRIOR, "laws"])
            yield ("prior", name), f"unknown quantity, expected one of a cell, or {listed((*OF_PRIOR, 'laws'))}", hint
    predict = data.get("predict")
    for name in predict if isinstance(predict, dict) else ():
        if name not in _WORDS_OF_PREDICT:
            yield ("predict", name), f"unknown key, expected {listed(_WORDS_OF_PREDICT)}", None
    for key in ("uncertain", "axes", "explain"):
        if key in data:
            yield (key,), "got it besides observed and prior, expected one of them", None


def _moves(data: dict[str, Any]) -> Iterator[tuple[Path, Path]]:
    """Where things stand in a file of observations, and where in a configuration."""
    for key in ("observed", *SETTINGS):
        if key in data:
            yield (key,), ("explain", key)
    for name, value in data["prior"].items():
        if name == "laws":
            yield ("prior", name), ("explain", name)
        elif name in OF_PRIOR:
            yield ("prior", name), ("uncertain", name)
        elif isinstance(value, dict):
            yield ("prior", name), ("uncertain", "quantities", name)
        else:
            yield ("prior", name), (QUANTITIES[name].section, name)
    for name in data.get("predict", {}):
        yield ("predict", name), ("axes",) if name == "axes" else ("explain", name)


def _moved(places: dict[Path, Any], moves: dict[Path, Path]) -> dict[Path, Any]:
    """Places by the paths in the configuration; what stands for several sections is where each of them is."""
    moved = {path: place for path, place in places.items() if not path or path[0] not in OWN_WORDS}
    for old, new in moves.items():
        for path, place in places.items():
            if path[: len(old)] == old:
                moved[(*new, *path[len(old) :])] = place
        for length in range(1, len(new)):
            if old[:1] in places:
                moved.setdefault(new[:length], places[old[:1]])
    return moved


def _problem(document: Document, path: Path, text: str, hint: str | None) -> Problem:
    place = document.keys.get(path) or document.values.get(path) or document.values.get(())
    return Problem(path, text, place, hint)
