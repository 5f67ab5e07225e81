"""Configurations from YAML files, or from Python: everything is checked before anything is computed.

All problems are reported at once, each with its line and column, or with its key where there are none. `model.py` holds
what a configuration consists of, `rules.py` what must hold between its parts, `yaml.py` and `python.py` make the plain
data that is read here; this file finds what is missing or given twice, and explains.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from pydantic import ValidationError

from stickslip.config import checks, examples, rules
from stickslip.config.fit_section import LAWS_FITTED, with_fits
from stickslip.config.model import Axis, Config, Group, Range, Values
from stickslip.config.overrides import Setting, overridden
from stickslip.config.problems import ProblemCollector
from stickslip.config.python import python_document
from stickslip.config.read_uncertain import QUANTITIES_PATH, read_uncertain
from stickslip.config.sections import QUANTITY_SECTIONS, REFUSED, SECTIONS, AnySection, Solver
from stickslip.config.studies import STUDIES
from stickslip.config.unit_warnings import warn_of_units
from stickslip.config.yaml import Document, hint_about_list, parse_yaml, read_yaml
from stickslip.errors import MOST_PROBLEMS, ConfigError, Path, dotted
from stickslip.vocabulary import beyond, units
from stickslip.vocabulary.display_units import written_units
from stickslip.vocabulary.models import laws_with, model_of
from stickslip.vocabulary.quantities import DRIVE, QUANTITIES, quantities_of_model
from stickslip.vocabulary.results import MAP_VARIABLES
from stickslip.vocabulary.suggest import listed

DEFAULT_TITLE = "Regimes of a friction oscillator"
_AXIS_FORMS = "a list of values, or start, stop and num"
_GROUP_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_EXPECTED = {"tuple_type": "a list", "string_type": "a text", "dict_type": "a mapping"}  # pydantic's own errors

Given = Config | str | os.PathLike[str] | Mapping[str, Any]  # what stands for a configuration in Python


def load_config(path: str | os.PathLike[str] | Mapping[str, Any], settings: Iterable[Setting] = ()) -> Config:
    """The configuration in a YAML file, or the one of the package that `path` calls (`examples.existing_config`).

    path : may be the configuration itself: mappings shaped like the YAML, with numbers in SI, texts with units, lists
        and arrays (`python.py`). Paths in it start at the folder that the program runs in.
    settings : of a command line, which are put into it.
    Raises ConfigError, which lists everything that is wrong with it, and warns of numbers whose unit was forgotten.
    """
    document = python_document(path) if isinstance(path, Mapping) else read_yaml(examples.existing_config(path))
    document = overridden(document, settings)
    config = _read(document)
    warn_of_units(document, config)
    return config


def as_config(given: Given) -> Config:
    """The configuration that was given: as it is, as a mapping, or as a file. Raises ConfigError."""
    return given if isinstance(given, Config) else load_config(given)


def is_config(given: object) -> bool:
    """True for a configuration in any of its forms, and not for a mapping of parameters of cells."""
    return isinstance(given, Config | str | os.PathLike) or (
        isinstance(given, Mapping) and any(key in Config.model_fields for key in given)
    )


def read_rig_config(document: Document, others: Collection[str]) -> Config:
    """The configuration of a test rig, with a drive; keys `others` are somebody else's. Raises ConfigError."""
    return _read(document, rig=True, others=others)


def parse_config(text: str, name: str = "<text>", settings: Iterable[Setting] = ()) -> Config:
    """The configuration in a YAML text, such as the one kept in a result; `name` stands for a file in messages.

    settings : of a command line, which are put into the text. Raises ConfigError.
    """
    return _read(overridden(parse_yaml(text, name), settings))


def make_config(data: Mapping[str, Any], name: str = "<data>") -> Config:
    """The configuration in mappings shaped like the YAML; `name` stands for a file in messages. Raises ConfigError."""
    return _read(python_document(data, name))


def _read(document: Document, rig: bool = False, others: Collection[str] = ()) -> Config:
    """A document with its curve fitted, if it names points, and then checked."""
    return _Reader(with_fits(document), rig, others).config().shown_in(written_units(document.data))


class _Reader(ProblemCollector):
    """Reads one document and collects what is wrong with it."""

    def __init__(self, document: Document, rig: bool = False, others: Collection[str] = ()) -> None:
        super().__init__(document)
        self._rig, self._others = rig, others

    def config(self) -> Config:
        """The configuration. Raises ConfigError."""
        whole = self._mapping_of(self.document.data, ())
        if not isinstance(self.document.data, dict):  # everything else would be missing
            raise ConfigError(self.document.name, self.problems)
        for problem in checks.misplaced(self._rig, whole):
            self.meant |= DRIVE.keys() if problem.path == ("drive",) else set()
            self.add(problem.path, problem.message, problem.hint, at_key=True)
        known = [key for key in (*Config.model_fields, *self._others) if checks.belongs(self._rig, key)]
        data = self.known_keys(whole, (), known)
        title = data.get("title", DEFAULT_TITLE)
        self.is_text(title, ("title",), "a text")
        raw = {key: self._mapping_of(data.get(key), (key,)) for key in (*SECTIONS, "axes")}
        sections: dict[str, Any] = {key: self._section(model, (key,), raw[key]) for key, model in SECTIONS.items()}
        axes = [axis for name, value in raw["axes"].items() if (axis := self._axis(name, value)) is not None]
        studies = self._studies(data, sections["solver"])
        given = self._given(raw, data.get("uncertain"))
        self._check_once(given)
        self._check_contact(sections["friction"], given)
        if ramp := checks.ramp_of_no_use(sections["drive"], given):
            self.add(ramp.path, ramp.message, ramp.hint, at_key=True)
        law = sections["friction"].law
        of_model = quantities_of_model(model_of(law))
        fixed = {name: value for key in QUANTITY_SECTIONS for name, value in sections[key]
                 if name in of_model and value is not None}  # fmt: skip
        if self._rig:
            fixed = checks.with_ramp(fixed, sections["drive"], "ramp" in given)
        for finding in rules.findings(rules.Space(fixed, axes, studies.get("uncertain"), law)):
            checks.add_finding(self, finding, self._about_list(finding.path))
        self.raise_any()
        for key in QUANTITY_SECTIONS:
            own = [name for name in type(sections[key]).model_fields if name in QUANTITIES]
            absent = {name: QUANTITIES[name].default if name in of_model else None for name in own if name not in given}
            sections[key] = sections[key].model_copy(update=absent)
        of_maps = {} if self._rig else dict.fromkeys(checks.OF_RIGS)
        config = Config(title=str(title).strip(), axes=tuple(axes), **{**sections, **of_maps, **studies})
        checks.check_study(config, self)
        self.raise_any()
        return config

    # --- something else than a map ------------------------------------------------------------------------------------

    def _studies(self, data: Mapping[str, Any], solver: Solver) -> dict[str, Any]:
        """The section that asks for something else than a map, if there is one; there cannot be two."""
        keys = [key for key in data if key in STUDIES]
        for key in keys[1:]:
            self.add((key,), f"got {key} besides {keys[0]}{self.line((keys[0],))}, expected one of them", at_key=True)
        studies: dict[str, Any] = {}
        for key in keys:
            if key == "uncertain":
                studies[key] = read_uncertain(self, data[key], self._section, solver.early_stop)
                continue
            known = self.known_keys(self._mapping_of(data[key], (key,)), (key,), STUDIES[key].model_fields)
            if (section := self._valid(STUDIES[key], known, (key,))) is not None:
                studies[key] = section
        return studies

    # --- keys, sections -----------------------------------------------------------------------------------------------

    def _mapping_of(self, value: object, path: Path) -> dict[str, Any]:
        """`value` if it is a mapping, with the keys that belong there; else an empty one, which may be a problem."""
        section = (SECTIONS | STUDIES).get(str(path[0])) if path else None
        whole = [key for key in Config.model_fields if checks.belongs(self._rig, key)]
        keys = listed(section.model_fields if section else whole)
        hint = f"output: {{file: {value}}}" if path == ("output",) and isinstance(value, str) else None
        return self.mapping(value, path, "names of quantities" if path == ("axes",) else f"the keys {keys}", hint)

    def unknown_key(self, path: Path, known: Collection[str], what: str = "key", hint: str | None = None) -> None:
        """Note that the last key of `path` is none of those `known`; a quantity belongs elsewhere."""
        key = str(path[-1])
        if key in QUANTITIES:
            self.meant.add(key)
            hint = f"{key} belongs to {QUANTITIES[key].section}, or to axes"
            self.add(path, f"unknown {what}, expected {listed(known)}", hint, at_key=True)
        elif sentence := beyond.hint(key) or beyond.hint("_".join(map(str, path[-2:]))):
            self.add(path, f"unknown {what}, expected {listed(known)}", sentence, at_key=True)
        elif len(path) > 1 or key not in checks.OF_RIGS:  # which are known to be misplaced
            super().unknown_key(path, known, what, hint)

    def _about_list(self, path: Path) -> str | None:
        """A hint about the list in which the value at `path` is, where that is the reason."""
        value = self.document.data
        for key in self._written(path)[:-1]:
            value = value.get(key) if isinstance(value, dict) else None
        return hint_about_list(value)

    def _section(self, model: type[AnySection], path: Path, data: Mapping[str, Any]) -> AnySection:
        """A section from what of `data` is right; the rest becomes problems."""
        known = self.known_keys(data, path, model.model_fields)
        try:
            return model.model_validate(known)
        except ValidationError as error:
            bad = self._report(error, path)
        try:
            return model.model_validate({key: value for key, value in known.items() if key not in bad})
        except ValidationError:  # what was left out is missed by the rest; reported it is already
            return model()

    def _report(self, error: ValidationError, path: Path, skipped: int = 0) -> set[str | int]:
        """Note the errors of pydantic; returns the keys that are wrong.

        skipped : how many of its keys lead to the value at `path` already.
        """
        details = error.errors(include_url=False)
        for detail in details:
            where = (*path, *detail["loc"][skipped:])
            context = detail.get("ctx", {})
            if detail["type"] == REFUSED:
                self.refuse(where, context["expected"], context["hint"], context["found"])
            elif detail["type"] == "missing" and where[-1] in self.meant:
                continue  # under another word
            elif detail["type"] == "missing":
                known = STUDIES[str(path[0])].model_fields[str(where[-1])].description if path[0] in STUDIES else None
                self.add(where, f"missing, expected {known or _AXIS_FORMS}")
            else:
                self.refuse(where, _EXPECTED.get(detail["type"], detail["msg"]))
        return {detail["loc"][0] for detail in details}

    # --- axes ---------------------------------------------------------------------------------------------------------

    def _axis(self, name: str, raw: object) -> Axis | None:
        """The axis called `name`; None if something is wrong with it."""
        path: Path = ("axes", name)
        if isinstance(raw, dict) and ("zip" in raw or "labels" in raw):
            return self._group(path, self.known_keys(raw, path, ("zip", "labels")))
        if name not in QUANTITIES:
            quantities = [quantity for quantity in QUANTITIES if checks.belongs(self._rig, quantity)]
            self.unknown_key(path, quantities, "quantity", "a group of quantities needs the key zip")
            return None
        if isinstance(raw, list):
            return self._values(name, raw, path)
        if isinstance(raw, dict) and "values" in raw:
            known = self.known_keys(raw, path, ("values",))
            return self._values(name, known["values"], (*path, "values"))
        if isinstance(raw, dict) and raw:
            known = self.known_keys(raw, path, [key for key in Range.model_fields if key != "name"])
            return self._valid(Range, {"name": name, **known}, path)
        self.refuse(path, _AXIS_FORMS, f"{name}: {_example_range(name)}")
        return None

    def _valid(
        self, model: type[AnySection], data: Mapping[str, Any], path: Path, skipped: int = 0
    ) -> AnySection | None:
        """The model of `data`, found at `path`; None if something is wrong with it. `skipped`: see `_report`."""
        try:
            return model.model_validate(data, context=[MOST_PROBLEMS])
        except ValidationError as error:
            self._report(error, path, skipped)
            return None

    def _values(self, name: str, raw: object, path: Path) -> Values | None:
        """The list of values at `path`."""
        if not isinstance(raw, list) or not raw:
            self.refuse(path, "a list of values")
            return None
        return self._valid(Values, {"name": name, "values": raw}, path, skipped=1)

    def _group(self, path: Path, raw: Mapping[str, Any]) -> Group | None:
        """Quantities that vary together, under a name of their own."""
        name, before = str(path[-1]), len(self.problems)
        if name in QUANTITIES or name in MAP_VARIABLES or not _GROUP_NAME.fullmatch(name):
            expected = "a name of its own for the group: a word that is no quantity and no result"
            self.add(path, f"got the name {name}, expected {expected}", at_key=True)
        lists = raw.get("zip")
        if not isinstance(lists, dict) or not lists:
            self.add((*path, "zip"), "expected a mapping of quantities to lists of values", "zip: {mass: [1, 2], ...}")
            return None
        zipped = self.known_keys(lists, (*path, "zip"), QUANTITIES)
        members = [self._values(member, value, (*path, "zip", member)) for member, value in zipped.items()]
        labels = raw.get("labels")
        lengths = {(*path, "zip", key): len(value) for key, value in zipped.items() if isinstance(value, list)}
        if labels is not None and self._are_labels(labels, (*path, "labels")):
            lengths[(*path, "labels")] = len(labels)
        self._check_lengths(lengths)
        if len(self.problems) > before:
            return None
        return Group(name=name, members=tuple(m for m in members if m), labels=labels)

    def _are_labels(self, labels: object, path: Path) -> bool:
        """True if `labels` is a list of texts that differ; if not, the reason is noted."""
        if not isinstance(labels, list):
            self.refuse(path, "a list of names")
            return False
        for i, label in enumerate(labels):
            if self.is_text(label, (*path, i), "a name") and label in labels[:i]:
                self.refuse((*path, i), "a name that is not in the list yet")
        return True

    def _check_lengths(self, lengths: Mapping[Path, int]) -> None:
        """Lists of a group are of one length."""
        first = next(iter(lengths), ())
        for path, length in lengths.items():
            if length != lengths[first]:
                self.add(path, f"got {length} values, expected {lengths[first]} like {first[-1]}{self.line(first)}")

    # --- every quantity exactly once ----------------------------------------------------------------------------------

    def _given(self, raw: Mapping[str, Mapping[str, Any]], uncertain: object) -> dict[str, list[Path]]:
        """The positions at which each quantity is given, rightly or wrongly."""
        paths: list[Path] = [(key, name) for key, model in QUANTITY_SECTIONS.items()
                             for name in raw[key] if name in model.model_fields and name in QUANTITIES]  # fmt: skip
        scattered = uncertain.get("quantities") if isinstance(uncertain, dict) else None
        named = scattered if isinstance(scattered, dict) else ()
        paths += [(*QUANTITIES_PATH, name) for name in named if name in QUANTITIES]
        given: dict[str, list[Path]] = {}
        for path in [*paths, *checks.varied_paths(raw["axes"])]:
            given.setdefault(str(path[-1]), []).append(path)
        return given

    def _check_once(self, given: Mapping[str, list[Path]]) -> None:
        """No quantity is given twice, and those without a default are given."""
        for first, *others in given.values():
            for path in others:
                message = f"given twice, as {dotted(first)}{self.line(first)} already, expected once"
                self.add(path, message, "keep the one you mean", at_key=True)
        for name, declared in QUANTITIES.items():
            if (
                declared.section not in ("friction", *(() if self._rig else checks.OF_RIGS))
                and declared.default is None
            ):
                self._check_given(name, given)

    def _check_given(self, name: str, given: Collection[str]) -> None:
        declared = QUANTITIES[name]
        if name not in given and not self.meant & {name, declared.section, "axes"}:
            message = f"missing, expected the {declared.long_name}: {units.expected(declared.units)}"
            self.add((declared.section, name), message, f"or vary it: axes: {{{name}: ...}}")

    def _check_contact(self, friction: Any, given: Mapping[str, list[Path]]) -> None:
        """What the contact needs is given in one of the forms of its model, completely, and nothing of other laws."""
        law, model = friction.law, model_of(friction.law)
        measured = [name for name in model.measured if name in given]
        replaced = [name for name in model.replaced if name in given]
        forms = ", or ".join(map(", ".join, model.forms))
        if friction.fit is not None and law not in LAWS_FITTED and not {*model.needed, *model.measured} & given.keys():
            self.refuse(("friction", "fit"), "no points: the curve fitted to them is that of the law stribeck")
        if measured and replaced:
            line = self.line(given[measured[0]][0])
            for name in replaced:
                message = f"got {name} besides {measured[0]}{line}, expected one form of the curve"
                self.add(given[name][0], message, f"the forms are {forms}", at_key=True)
        either = {*model.replaced, *model.measured}
        if either and not measured and not replaced and not self.meant & either:
            self.add(("friction",), f"the friction curve is missing, expected {forms}", "`stickslip help model`")
        else:
            whole = model.forms[bool(measured)]
            for name in whole if not (measured and replaced) else set(model.forms[0]) & set(model.forms[-1]):
                self._check_given(name, given)
        for name, paths in given.items():
            row = QUANTITIES[name]
            if law in laws_with(name) or (row.default is not None and getattr(friction, name, None) == row.default):
                continue
            expected = listed(model.needed, "and") if row.default is None else "none"
            laws = listed(laws_with(name))
            self.add(
                paths[0], f"got {name} with the law {law}, expected {expected}: it is for the law {laws}", at_key=True
            )


def _example_range(name: str) -> str:
    """A range as it is written for a quantity."""
    declared = QUANTITIES[name]
    if declared.units == "1":
        return "{start: 0.1, stop: 0.5, num: 50}"
    number, unit = units.example(declared.units).split(" ", 1)
    return f"{{start: {number} {unit}, stop: {float(number) * 10:g} {unit}, num: 50}}"
