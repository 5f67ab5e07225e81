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
from collections.abc import Callable, Collection, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path as FilePath
from typing import Any

from stickslip.config.problems import ProblemCollector
from stickslip.config.yaml import Document, read_yaml
from stickslip.errors import Path, QuantityError
from stickslip.fit.headings import RECORD, Heading, heading
from stickslip.rig.quantities import COLUMNS, CONDITION_WORDS, MATERIAL, SIGNAL_OF
from stickslip.rig.rpn import Risk
from stickslip.vocabulary.column_units import column_unit
from stickslip.vocabulary.settings import CONDITIONS, FEATURE_SETTINGS, RISK
from stickslip.vocabulary.suggest import listed

Condition = str | float

_OFFSET = "subtract_offset"


@dataclass(frozen=True)
class RecordSettings:
    """Columns of a file: `columns` (our name: heading), `units` (our name: unit), headings to `ignore`."""

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    ignore: tuple[str, ...] = ()


@dataclass(frozen=True)
class FeatureSettings:
    """Settings of the features: `FEATURE_SETTINGS`, in SI; None: chosen from the record, or not computed (bandwidth).

    subtract_offset : whether the median of the acceleration is taken for an offset of its sensor, and subtracted.
    """

    bandwidth: float | None = None
    smallest_drop: float | None = None
    window: float | None = None
    tolerance: float = 0.2
    subtract_offset: bool = False

    @property
    def known(self) -> dict[str, float]:
        """The settings by name, without those that are None."""
        return {name: value for name, value in asdict(self).items() if value is not None}


@dataclass(frozen=True)
class Settings:
    """The settings of a configuration for records. conditions : by `CONDITIONS` and `material`, in SI."""

    record: RecordSettings = field(default_factory=RecordSettings)
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    features: FeatureSettings = field(default_factory=FeatureSettings)
    risk: Risk = field(default_factory=Risk)

    def to_yaml(self) -> str:
        """The settings as text that gives them again."""
        sections = asdict(self) | {"features": self.features.known, "risk": self.risk.known}
        return json.dumps(sections, indent=2, ensure_ascii=False) + "\n"  # which YAML contains


def load_settings(path: FilePath) -> Settings:
    """Read the settings in a YAML file.

    Raises
    ------
    ConfigError
        With everything that is wrong with the file, by line and column.
    """
    return read_settings(read_yaml(path))


def read_settings(document: Document) -> Settings:
    """Read the settings in a document. Raises ConfigError."""
    reader = _Reader(document)
    data = reader.section(document.data, (), ("record", "conditions", "features", "risk"))
    record = reader.section(data.get("record"), ("record",), ("columns", "units", "ignore"))
    features = reader.section(data.get("features"), ("features",), (*FEATURE_SETTINGS, _OFFSET))
    risk = reader.section(data.get("risk"), ("risk",), RISK)
    columns, units = (
        reader.values(record.get(key), ("record", key), column_name, read, COLUMNS)
        for key, read in (("columns", _text), ("units", _column_unit))
    )
    conditions = reader.values(data.get("conditions"), ("conditions",), condition_name, condition, _CONDITION_NAMES)
    chosen = reader.values(features, ("features",), str, _feature_setting, FEATURE_SETTINGS)
    weights = reader.values(risk, ("risk",), str, lambda name, value: RISK[name].read(value), RISK)
    ignore = record.get("ignore") or []
    if not isinstance(ignore, list) or not all(isinstance(word, str) for word in ignore):
        reader.refuse(("record", "ignore"), "a list of the names of columns")
    reader.raise_any()
    of_record = RecordSettings(columns, units, tuple(ignore))
    return Settings(of_record, conditions, FeatureSettings(**chosen), Risk(**weights))


class _Reader(ProblemCollector):
    """Mappings of a document, and what is wrong with them."""

    def section(self, value: object, path: Path, keys: Collection[str]) -> dict[str, Any]:
        """The known keys of a mapping."""
        whole = {} if value is None else value
        return self.known_keys(self.mapping(whole, path, f"the keys {listed(keys)}"), path, keys)

    def values(
        self, value: object, path: Path, name_of: Callable[[str], str | None], read: Callable[[str, object], Any],
        known: Collection[str],
    ) -> dict[str, Any]:  # fmt: skip
        """The values of a mapping by our names; words may be spelled otherwise."""
        values = {}
        for word, text in self.mapping(value, path, f"names of {path[-1]}").items():
            name = name_of(word)
            if name is None:
                self.unknown_key((*path, word), known)
                continue
            try:
                values[name] = read(name, text)
            except QuantityError as error:
                self.refuse((*path, word), error.expected, error.hint, error.found)
        return values


# --- single values ----------------------------------------------------------------------------------------------------

_CONDITION_NAMES = (MATERIAL, *CONDITIONS)


def condition(name: str, text: object) -> Condition:
    """A condition in SI, or the name of a material. Raises QuantityError."""
    if name != MATERIAL:
        return CONDITIONS[name].read(text)
    if not isinstance(text, str) or not text.strip():
        raise QuantityError("the name of a material")
    return text.strip()


def condition_name(word: str) -> str | None:
    """The condition that people call so; None if none."""
    name = word.strip().lower().replace(" ", "_").replace("-", "_")
    name = CONDITION_WORDS.get(name, name)
    return name if name in _CONDITION_NAMES else None


def column_name(word: str) -> str | None:
    """The column of a record that people call so; None if none."""
    return signal_of(heading(word, RECORD, tuple(COLUMNS)))


def signal_of(column: Heading) -> str | None:
    """The column of a record that a heading names; None if none: of friction, a record holds the force."""
    if column.kind in COLUMNS and not column.label:
        return column.kind
    if column.label or column.kind == "mu" and (not column.may_be_force() or column.unit in ("1", "-", "%")):
        return None
    return "friction_force" if column.kind == "mu" else SIGNAL_OF.get(column.kind)


def _text(_: str, text: object) -> str:
    if not isinstance(text, str):
        raise QuantityError("a text")
    return text


def _column_unit(name: str, text: object) -> str:
    unit = _text(name, text)
    column_unit(unit, COLUMNS[name].units)
    return unit


def _feature_setting(name: str, value: object) -> float:
    if name != _OFFSET:
        return FEATURE_SETTINGS[name].read(value)
    if not isinstance(value, bool):
        raise QuantityError("true or false")
    return value
