"""Settings for records: how to read them, how to evaluate them, and the risk model.

    record:
      columns: {force: Kraft}             # our name: the heading in the file
      units: {time: ms, acceleration: mm/s2}
      ignore: [temperature]
    conditions: {material: felt, normal_load: 10 N, drive_speed: 10 mm/s}
    features: {bandwidth: 2 kHz}
    risk: {weight_sticks: 1.5}

Every section and every key is optional. Everything is checked at once, with lines and columns.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path as FilePath
from typing import Any

from stickslip.config.problems import ProblemCollector
from stickslip.config.yaml import Document, read_yaml
from stickslip.errors import Path, QuantityError
from stickslip.fit.headings import RECORD, Heading, heading
from stickslip.rig.quantities import CONDITION_WORDS, MATERIAL, SIGNAL_OF, SIGNALS, TIME
from stickslip.rig.risk import Risk
from stickslip.vocabulary.column_units import column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.settings import CONDITIONS, FEATURE_SETTINGS, RISK
from stickslip.vocabulary.suggest import listed

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
    return signal_of(heading(word, RECORD, (TIME.name, *SIGNALS)))


def signal_of(one: Heading) -> str | None:
    """Which column of a record a heading is; None if none: of friction, a record holds the force."""
    if one.kind in _COLUMNS and not one.label:
        return one.kind
    if one.label or one.kind == "mu" and (not one.may_be_force() or one.unit in ("1", "-", "%")):
        return None
    return "friction_force" if one.kind == "mu" else SIGNAL_OF.get(one.kind)


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
        "risk": settings.risk.known,
    }
    return json.dumps(sections, indent=2, ensure_ascii=False) + "\n"  # which YAML contains


class _Reader(ProblemCollector):
    """Reads one document and collects what is wrong with it."""

    def settings(self) -> Settings:
        """The settings. Raises ConfigError."""
        sections = ("record", "conditions", "features", "risk")
        whole = {} if self.document.data is None else self.document.data
        data = self.known_keys(self.mapping(whole, (), f"the keys {listed(sections)}"), (), sections)
        record = self._record(data.get("record"))
        conditions = self._conditions(data.get("conditions"))
        features = self._section("features", data.get("features"), (*FEATURE_SETTINGS, "subtract_offset"))
        if not isinstance(offset := features.pop("subtract_offset", False), bool):
            self.refuse(("features", "subtract_offset"), "true or false")
        found = FeatureSettings(subtract_offset=bool(offset), **self._numbers("features", features, FEATURE_SETTINGS))
        risk = self._numbers("risk", self._section("risk", data.get("risk"), RISK), RISK)
        self.raise_any()
        return Settings(record, conditions, found, Risk(**risk))

    def _section(self, key: str, value: object, known: Collection[str]) -> dict[str, Any]:
        return self.known_keys(self.mapping(value, (key,), f"the keys {listed(known)}"), (key,), known)

    def _record(self, value: object) -> RecordSettings:
        data = self._section("record", value, ("columns", "units", "ignore"))
        found = self._by_column("units", data.get("units"))
        for name, (path, unit) in found.items():
            try:
                column_unit(unit, TIME.units if name == TIME.name else SIGNALS[name].units)
            except QuantityError as error:
                self.refuse(path, error.expected, error.hint, error.found)
        ignore = data.get("ignore") or []
        if not isinstance(ignore, list) or not all(isinstance(word, str) for word in ignore):
            self.refuse(("record", "ignore"), "a list of the names of columns")
            ignore = []
        columns = self._by_column("columns", data.get("columns"))
        return RecordSettings(
            {name: heading for name, (_, heading) in columns.items()},
            {name: unit for name, (_, unit) in found.items()},
            tuple(ignore),
        )

    def _by_column(self, key: str, value: object) -> dict[str, tuple[Path, str]]:
        """A mapping from names of columns, as people write them, to texts and their positions."""
        found: dict[str, tuple[Path, str]] = {}
        for word, text in self.mapping(value, ("record", key), "names of columns").items():
            path, name = ("record", key, word), column_name(word)
            if name is None:
                self.unknown_key(path, _COLUMNS)
            elif not isinstance(text, str):
                self.refuse(path, "a text")
            else:
                found[name] = path, text
        return found

    def _conditions(self, value: object) -> dict[str, Condition]:
        found: dict[str, Condition] = {}
        for word, text in self.mapping(value, ("conditions",), "names of conditions").items():
            name = condition_name(word)
            if name is None:
                self.unknown_key(("conditions", word), (MATERIAL, *CONDITIONS))
                continue
            try:
                found[name] = condition(name, text)
            except QuantityError as error:
                self.refuse(("conditions", word), error.expected, error.hint, error.found)
        return found

    def _numbers(self, key: str, data: Mapping[str, Any], known: Mapping[str, Parameter]) -> dict[str, float]:
        """The numbers of a section by name, in SI."""
        found = {}
        for name, value in data.items():
            try:
                found[name] = known[name].read(value)
            except QuantityError as error:
                self.refuse((key, name), error.expected, error.hint, error.found)
        return found
