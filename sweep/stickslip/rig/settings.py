"""What a configuration says about records: how to read them, what to look for in them, and the risk model.

    record:
      columns: {force: Kraft}             # our name: the heading in the file
      units: {time: ms, acceleration: mm/s2}
      ignore: [temperature]
    conditions: {material: felt, normal_load: 10 N, drive_speed: 10 mm/s}
    features: {bandwidth: 2 kHz}
    risk: {weight_sticks: 1.5}

Every section and every key may be missing. Everything is checked at once, with lines and columns.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path as FilePath
from typing import Any

from stickslip.config.yaml import Document, read_yaml
from stickslip.errors import ConfigError, Path, Problem, QuantityError
from stickslip.rig.quantities import COLUMN_WORDS, CONDITION_WORDS, MATERIAL, SIGNALS, TIME
from stickslip.rig.risk import Risk
from stickslip.vocabulary import units
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.settings import CONDITIONS, FEATURE_SETTINGS, RISK
from stickslip.vocabulary.words import listed, nearest

Condition = str | float

_COLUMNS = (TIME.name, *SIGNALS)


@dataclass(frozen=True)
class RecordSettings:
    """How to read a file: `columns` (our name: heading), `units` (our name: unit), columns to `ignore`."""

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    ignore: tuple[str, ...] = ()


@dataclass(frozen=True)
class FeatureSettings:
    """What to look for: `FEATURE_SETTINGS`, in SI; None: chosen from the record, or not computed (bandwidth).

    subtract_offset : whether the median of the acceleration is taken for an offset of its sensor, and subtracted.
    """

    bandwidth: float | None = None
    smallest_drop: float | None = None
    window: float | None = None
    tolerance: float = 0.2
    subtract_offset: bool = False


@dataclass(frozen=True)
class Settings:
    """Everything a configuration says about records. conditions : by `CONDITIONS` and `material`, in SI."""

    record: RecordSettings = field(default_factory=RecordSettings)
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    features: FeatureSettings = field(default_factory=FeatureSettings)
    risk: Risk = field(default_factory=Risk)


def load_settings(path: FilePath) -> Settings:
    """The settings in a YAML file. Raises ConfigError, which lists everything that is wrong with it."""
    return _Reader(read_yaml(path)).settings()


def read_settings(document: Document) -> Settings:
    """The settings in a document. Raises ConfigError."""
    return _Reader(document).settings()


def condition(name: str, text: object) -> Condition:
    """A condition in SI, or the name of a material. Raises QuantityError."""
    if name == MATERIAL:
        if not isinstance(text, str) or not text.strip():
            raise QuantityError("the name of a material")
        return text.strip()
    return CONDITIONS[name].read(text)


def condition_name(word: str) -> str | None:
    """Which condition people mean by a word; None if none."""
    name = word.strip().lower().replace(" ", "_").replace("-", "_")
    name = CONDITION_WORDS.get(name, name)
    return name if name in CONDITIONS or name == MATERIAL else None


def column_name(word: str) -> str | None:
    """Which column people mean by a word; None if none."""
    name = word.strip().lower().replace(" ", "_").replace("-", "_")
    name = COLUMN_WORDS.get(name, name)
    return name if name in _COLUMNS else None


def as_text(settings: Settings) -> str:
    """The settings as YAML that gives them again."""
    sections: dict[str, dict[str, Any]] = {
        "record": {
            "columns": dict(settings.record.columns),
            "units": dict(settings.record.units),
            "ignore": list(settings.record.ignore),
        },
        "conditions": dict(settings.conditions),
        "features": {name: value for name, value in asdict(settings.features).items() if value is not None},
        "risk": asdict(settings.risk),
    }
    return json.dumps(sections, indent=2, ensure_ascii=False) + "\n"  # which YAML contains


class _Reader:
    """Reads one document and collects what is wrong with it."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._problems = list(document.problems)

    def settings(self) -> Settings:
        """The settings. Raises ConfigError."""
        sections = self._mapping((), ("record", "conditions", "features", "risk"))
        record = self._record() if "record" in sections else RecordSettings()
        conditions = self._conditions() if "conditions" in sections else {}
        features = self._quantities("features", FEATURE_SETTINGS, ("subtract_offset",))
        offset = self._at(("features", "subtract_offset"))
        if offset is not None and not isinstance(offset, bool):
            self._refuse(("features", "subtract_offset"), "true or false")
        risk = self._quantities("risk", RISK)
        if self._problems:
            raise ConfigError(self._document.name, self._problems)
        return Settings(record, conditions, FeatureSettings(subtract_offset=bool(offset), **features), Risk(**risk))

    # --- sections -----------------------------------------------------------------------------------------------------

    def _record(self) -> RecordSettings:
        self._mapping(("record",), ("columns", "units", "ignore"))
        columns = self._by_column("columns")
        found = self._by_column("units")
        for name, unit in found.items():
            declared = TIME.units if name == TIME.name else SIGNALS[name].units
            try:
                units.si_value(f"1 {unit}", declared)
            except QuantityError as error:
                path = self._path_of("units", name)
                self._refuse(path, f"the unit of {units.kind(declared)}", error.hint)
        ignore = self._at(("record", "ignore")) or []
        if not isinstance(ignore, list) or not all(isinstance(word, str) for word in ignore):
            self._refuse(("record", "ignore"), "a list of the names of columns")
            ignore = []
        return RecordSettings(columns, found, tuple(ignore))

    def _by_column(self, key: str) -> dict[str, str]:
        """A mapping from names of columns, as people write them, to texts."""
        found = {}
        for word, text in self._mapping(("record", key), None).items():
            name = column_name(word)
            if name is None:
                self._unknown(("record", key, word), _COLUMNS)
            elif not isinstance(text, str):
                self._refuse(("record", key, word), "a text")
            else:
                found[name] = text
        return found

    def _path_of(self, key: str, name: str) -> Path:
        words = self._mapping(("record", key), None)
        return ("record", key, next(word for word in words if column_name(word) == name))

    def _conditions(self) -> dict[str, Condition]:
        found: dict[str, Condition] = {}
        for word, text in self._mapping(("conditions",), None).items():
            path = ("conditions", word)
            name = condition_name(word)
            if name is None:
                self._unknown(path, (MATERIAL, *CONDITIONS))
                continue
            try:
                found[name] = condition(name, text)
            except QuantityError as error:
                self._refuse(path, error.expected, error.hint)
        return found

    def _quantities(self, key: str, known: Mapping[str, Parameter], others: Collection[str] = ()) -> dict[str, float]:
        """The quantities of a section by name, in SI."""
        found = {}
        for name, value in self._mapping((key,), (*known, *others)).items():
            if name in others:
                continue
            try:
                found[name] = known[name].read(value)
            except QuantityError as error:
                self._refuse((key, name), error.expected, error.hint)
        return found

    # --- problems -----------------------------------------------------------------------------------------------------

    def _at(self, path: Path) -> Any:
        value = self._document.data
        for key in path:
            value = value.get(key) if isinstance(value, dict) else None
        return value

    def _mapping(self, path: Path, known: Collection[str] | None) -> dict[str, Any]:
        """The mapping at `path` without keys that are not `known`, each of which is a problem; {} if there is none."""
        value = self._at(path)
        if value is None:
            return {}
        if not isinstance(value, dict):
            self._refuse(path, f"a mapping with the keys {listed(known)}" if known else "a mapping")
            return {}
        if known is not None:
            for key in value:
                if key not in known:
                    self._unknown((*path, key), known)
        return {key: item for key, item in value.items() if known is None or key in known}

    def _unknown(self, path: Path, known: Collection[str]) -> None:
        meant = nearest(str(path[-1]), known)
        hint = f"did you mean {meant}?" if meant else None
        place = self._document.keys.get(path)
        self._note(Problem(path, f"unknown key, expected {listed(known)}", place, hint))

    def _refuse(self, path: Path, expected: str, hint: str | None = None) -> None:
        got = self._document.texts.get(path, "a list or a mapping")
        self._note(Problem(path, f"got {got}, expected {expected}", self._document.values.get(path), hint))

    def _note(self, problem: Problem) -> None:
        if problem not in self._problems:  # a section is looked at more than once
            self._problems.append(problem)
