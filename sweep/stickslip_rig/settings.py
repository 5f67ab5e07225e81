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

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import Any

from stickslip.config.problems import ProblemCollector
from stickslip.config.python import python_document
from stickslip.config.yaml import Document, Setting, overridden, read_yaml, write_yaml
from stickslip.errors import Path, QuantityError
from stickslip.vocabulary.column_units import column_unit
from stickslip_materials.fit.headings import Heading, heading
from stickslip_materials.fit.words import RECORD
from stickslip_rig.quantities import COLUMNS, CONDITION_WORDS, MATERIAL, SIGNAL_OF
from stickslip_rig.risk import Risk
from stickslip_rig.sections import FeatureSettings
from stickslip_rig.vocabulary import CONDITIONS

Condition = str | float

_CONDITION_NAMES = (MATERIAL, *CONDITIONS)


@dataclass(frozen=True)
class RecordSettings:
    """Columns of a file: `columns` (our name: heading), `units` (our name: unit), headings to `ignore`."""

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    ignore: tuple[str, ...] = ()


@dataclass(frozen=True)
class Settings:
    """The settings of a configuration for records. conditions : by `CONDITIONS` and `material`, in SI."""

    record: RecordSettings = field(default_factory=RecordSettings)
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    features: FeatureSettings = field(default_factory=FeatureSettings)
    risk: Risk = field(default_factory=Risk)

    def to_yaml(self) -> str:
        """The settings as text that gives them again."""
        record = {"columns": dict(self.record.columns), "units": dict(self.record.units)}
        return write_yaml({
            "record": {**record, "ignore": list(self.record.ignore)}, "conditions": dict(self.conditions),
            "features": self.features.resolved(), "risk": self.risk.resolved(),
        })  # fmt: skip


def load_settings(path: FilePath | None, settings: Iterable[Setting] = ()) -> Settings:
    """Read the settings in a YAML file, if there is one, and those of a command line, which are put into it.

    Raises
    ------
    ConfigError
        With everything that is wrong with the file, by line and column.
    """
    document = python_document({}, "options") if path is None else read_yaml(path)
    return read_settings(overridden(replace(document, data=document.data or {}), settings))


def read_settings(document: Document) -> Settings:
    """Read the settings in a document. Raises ConfigError."""
    reader = _Reader(document)
    data = reader.keys_of(document.data or {}, (), ("record", "conditions", "features", "risk"))
    record = reader.keys_of(data.get("record"), ("record",), ("columns", "units", "ignore"))
    known = RECORD, tuple(COLUMNS)
    columns, units = (
        reader.values(record.get(key), ("record", key), lambda word: signal_of(heading(word, *known)), read, COLUMNS)
        for key, read in (("columns", _text), ("units", _column_unit))
    )
    conditions = reader.values(data.get("conditions"), ("conditions",), condition_name, condition, _CONDITION_NAMES)
    sections: dict[str, Any] = {
        key: reader.section_of(model, (key,), data.get(key) or {})
        for key, model in (("features", FeatureSettings), ("risk", Risk))
    }
    ignore = record.get("ignore") or []
    if not isinstance(ignore, list) or not all(isinstance(word, str) for word in ignore):
        reader.refuse(("record", "ignore"), "a list of the names of columns")
    reader.raise_any()
    return Settings(RecordSettings(columns, units, tuple(ignore)), conditions, **sections)


class _Reader(ProblemCollector):
    """Mappings of a document, and what is wrong with them."""

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
                self.refuse((*path, word), error.expected, error.hint, error.kind)
        return values


# --- single values ----------------------------------------------------------------------------------------------------


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
