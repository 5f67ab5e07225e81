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
from stickslip.config.resolve import python_document
from stickslip.config.yaml import Document, Setting, overridden, read_yaml, write_yaml
from stickslip.errors import QuantityError
from stickslip.vocabulary.display_units import column_unit
from stickslip_materials.fit.headings import Heading, heading
from stickslip_materials.fit.words import RECORD
from stickslip_rig.quantities import COLUMNS, CONDITION_WORDS, CONDITIONS, MATERIAL, SIGNAL_OF
from stickslip_rig.risk import Risk
from stickslip_rig.sections import FeatureSettings

Condition = str | float


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
        record = {name: list(value) if name == "ignore" else dict(value) for name, value in vars(self.record).items()}
        sections = {"features": self.features.resolved(), "risk": self.risk.resolved()}
        return write_yaml({"record": record, "conditions": dict(self.conditions), **sections})


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
    problems = ProblemCollector(document)
    data = problems.keys_of(document.data or {}, (), ("record", "conditions", "features", "risk"))
    record = problems.keys_of(data.get("record"), ("record",), ("columns", "units", "ignore"))

    def values(
        section: Mapping[str, Any], key: str, known: Collection[str], name_of: Callable[[str], str | None],
        read: Callable[[str, object], Any],
    ) -> dict[str, Any]:  # fmt: skip
        """The values of a mapping by our names; words may be spelled otherwise."""
        path, named = ("record", key) if section is record else (key,), {}
        for word, text in problems.mapping(section.get(key), path, f"names of {key}").items():
            try:
                if (name := name_of(word)) is None:
                    problems.unknown_key((*path, word), known)
                else:
                    named[name] = read(name, text)
            except QuantityError as error:
                problems.refuse((*path, word), error.expected, error.hint, error.kind)
        return named

    def column_named(word: str) -> str | None:
        return signal_of(heading(word, RECORD, tuple(COLUMNS)))

    columns = values(record, "columns", COLUMNS, column_named, _text)
    units = values(record, "units", COLUMNS, column_named, _column_unit)
    conditions = values(data, "conditions", (MATERIAL, *CONDITIONS), condition_name, condition)
    features = problems.section_of(FeatureSettings, ("features",), data.get("features") or {})
    risk = problems.section_of(Risk, ("risk",), data.get("risk") or {})
    ignore = record.get("ignore") or []
    if not isinstance(ignore, list) or not all(isinstance(word, str) for word in ignore):
        problems.refuse(("record", "ignore"), "a list of the names of columns")
    problems.raise_any()
    return Settings(RecordSettings(columns, units, tuple(ignore)), conditions, features, risk)


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
    return name if name in (MATERIAL, *CONDITIONS) else None


def signal_of(column: Heading) -> str | None:
    """The column of a record that a heading names; None if none: of friction, a record holds the force."""
    if column.kind in COLUMNS and not column.label:
        return column.kind
    if column.label or column.kind == "load" and not column.has_own_unit():  # kg
        return None
    if column.kind == "mu" and (not column.may_be_force() or column.unit in ("1", "-", "%")):
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
