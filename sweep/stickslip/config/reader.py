"""Configurations from YAML files, or from Python: everything is checked before anything is computed.

All problems are reported at once, each with its line and column, or with its key where there are none. `model.py` holds
what a configuration consists of, `rules.py` what must hold between its parts, `yaml.py` and `python.py` make the plain
data that is read here; this file finds what is missing or given twice, and explains.
"""

import os
import re
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from stickslip import extensions
from stickslip.config import rules
from stickslip.config.model import (
    DEFAULT_TITLE,
    QUANTITY_SECTIONS,
    SECTIONS,
    Axis,
    Config,
    Group,
    Range,
    Values,
    quantities_in,
)
from stickslip.config.problems import ProblemCollector
from stickslip.config.resolve import LAWS_FITTED, existing_config, has_unread, python_document, resolved, varied_paths
from stickslip.config.rules import warn_of_units
from stickslip.config.sections import Section, Solver
from stickslip.config.studies import KEYS, section_class, study_class
from stickslip.config.uncertain import QUANTITIES_PATH, SamplingSection, read_uncertain
from stickslip.config.yaml import Document, Setting, overridden, parse_yaml, read_yaml
from stickslip.errors import ConfigError, Path, dotted
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import written_units
from stickslip.vocabulary.models import STIFFNESS, WRITTEN_LAWS, law_of_contact, laws_with, model_of
from stickslip.vocabulary.quantities import (
    BESIDE,
    MAP_VARIABLES,
    QUANTITIES,
    QUANTITIES_OF,
    STUDIES,
    VARIABLES,
    WITH_UNCERTAIN,
    listed,
)

_RIGID = "none"  # for the stiffness of a contact that sticks without giving way
_AXIS_FORMS = "a list of values, or start, stop and num"
_GROUP_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

Given = Config | str | os.PathLike[str] | Mapping[str, Any]  # what stands for a configuration in Python


def load_config(
    path: str | os.PathLike[str] | Mapping[str, Any], settings: Iterable[Setting] = (), apart: str | None = ""
) -> Config:
    """The configuration in a YAML file, or the one of the package that `path` calls (`resolve.existing_config`).

    path : may be the configuration itself: mappings shaped like the YAML, with numbers in SI, texts with units, lists
        and arrays (`python.py`). Paths in it start at the folder that the program runs in.
    settings : of a command line, which are put into it. apart : the key of the study that it must have, of those that
        stand apart; "" for none of these, None for any.
    Raises ConfigError, which lists everything that is wrong with it, and warns of numbers whose unit was forgotten.
    """
    document = python_document(path) if isinstance(path, Mapping) else read_yaml(existing_config(path))
    written = overridden(document, settings)
    config = _ConfigReader(resolved(written), apart).config()
    warn_of_units(written, config)
    return config


def as_config(given: Given, apart: str | None = "") -> Config:
    """The configuration that was given: as it is, as a mapping, or as a file. apart : as above. Raises ConfigError."""
    return given if isinstance(given, Config) else load_config(given, apart=apart)


def command_for(path: str | os.PathLike[str]) -> str:
    """The command that computes what a YAML file asks for. Raises ConfigError if it cannot be read."""
    key = _apart_in(read_yaml(existing_config(path)).data)
    return STUDIES[key].apart if key else "run"


def is_for_what_is_installed(path: str | os.PathLike[str]) -> bool:
    """Whether a YAML file has only sections, and points behind its words, that the engine or an extension reads."""
    data = read_yaml(existing_config(path)).data
    return not data.keys() - set(KEYS) and not has_unread(data)


def parse_config(text: str, name: str = "<text>", settings: Iterable[Setting] = (), apart: str | None = None) -> Config:
    """The configuration in a YAML text, such as the one kept in a result; `name` stands for a file in messages.

    settings : of a command line, which are put into the text. apart : as for `load_config`. Raises ConfigError.
    """
    return _ConfigReader(resolved(overridden(parse_yaml(text, name), settings)), apart).config()


def make_config(data: Mapping[str, Any], name: str = "<data>", apart: str | None = "") -> Config:
    """The configuration in mappings shaped like the YAML; `name` stands for a file in messages. Raises ConfigError."""
    return _ConfigReader(resolved(python_document(data, name)), apart).config()


def _apart_in(data: object) -> str:
    """The key of the study in plain data that stands apart; "" for none."""
    keys = data if isinstance(data, dict) else {}
    return next((key for key in keys if key in STUDIES and STUDIES[key].apart), "")


class _ConfigReader(ProblemCollector):
    """Reads one document and collects what is wrong with it."""

    def __init__(self, document: Document, apart: str | None) -> None:
        super().__init__(document)
        self._apart = _apart_in(document.data) if apart is None else apart
        self._elsewhere, self._sections = set[str](), set(QUANTITY_SECTIONS)

    def config(self) -> Config:
        """The configuration. Raises ConfigError."""
        whole = dict(self.mapping(self.document.data, (), f"the keys {listed(KEYS)}"))
        if not isinstance(self.document.data, dict):  # everything else would be missing
            raise ConfigError(self.document.name, self.problems)
        friction = whole.get("friction")
        if isinstance(friction, dict) and friction.get(STIFFNESS) == _RIGID:
            whole["friction"] = {name: value for name, value in friction.items() if name != STIFFNESS}
        data = self.known_keys(self._without_foreign(whole), (), KEYS)
        self._elsewhere = {key for key in data if key in STUDIES and study_class(key).own_conditions}
        title = data.get("title", DEFAULT_TITLE)
        self.is_text(title, ("title",), "a text")
        sections: dict[str, Any] = {
            key: self.section_of(model, (key,), data.get(key)) for key, model in SECTIONS.items()
        }
        varied = self.mapping(data.get("axes"), ("axes",), "names of quantities")
        axes = [axis for name, value in varied.items() if (axis := self._axis(name, value)) is not None]
        studies = self._studies(data, sections["solver"])
        study: Any = studies.get("study")
        given = self._given(data)
        self._check_once(given)
        friction = sections["friction"]
        sections["friction"] = friction.model_copy(update={"law": law_of_contact(friction.law, given)})
        self._check_contact(sections["friction"], given)
        law = sections["friction"].law
        of_model = QUANTITIES_OF[model_of(law)]
        holders = [*(sections[key] for key in QUANTITY_SECTIONS), *([study] if study else [])]
        values = {name: getattr(section, name) for section in holders for name in quantities_in(section)}
        fixed = {name: value for name, value in values.items() if name in of_model and value is not None}
        drawn = None if self._elsewhere else studies.get("uncertain")  # what is impossible explains nothing
        space = rules.QuantitySpace(fixed, axes, drawn, law)
        own = study_class(study.key).rules(study, space, given) if study else ()
        for finding in (*rules.findings(space), *own):
            self.add_finding(finding)
        self.raise_any()
        for holder, key in (*((sections, key) for key in QUANTITY_SECTIONS), *([(studies, "study")] if study else [])):
            names = [name for name in quantities_in(holder[key]) if name not in given]
            absent = {name: QUANTITIES[name].default if name in of_model else None for name in names}
            holder[key] = holder[key].model_copy(update=absent)
        config = Config(title=str(title).strip(), axes=tuple(axes), **sections, **studies)
        self._check_study(config)
        self.raise_any()
        return config.shown_in(written_units(self.document.data))

    def _without_foreign(self, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """The plain data without sections of studies that are not asked for, each of which is a problem."""
        foreign = set()
        for key in data:
            owner = BESIDE.get(key) or key
            if owner in STUDIES and (owner != self._apart if STUDIES[owner].apart else owner not in data):
                foreign.add(key)
                hint = f"stickslip {STUDIES[owner].apart or owner} computes what has one"
                self.add((key,), f"expected no {key} in a map", hint, at_key=True)
        self._sections |= {key for key in data if key in STUDIES and key not in foreign}
        if self._apart:
            study = study_class(self._apart)
            for problem in study.misplaced(data):
                self.meant |= study.section.rows.keys() if problem.path == (self._apart,) else set()
                self.add(problem.path, problem.message, problem.hint, at_key=True)
        for path in varied_paths(data.get("axes")):
            if (section := QUANTITIES[str(path[-1])].section) not in (*self._sections, self._apart):
                hint = f"stickslip {STUDIES[section].apart or section} has one"
                self.add(path, f"{path[-1]} belongs to {section}, which a map has not", hint, at_key=True)
        return {key: value for key, value in data.items() if key not in foreign}

    # --- something else than a map ------------------------------------------------------------------------------------

    def _studies(self, data: Mapping[str, Any], solver: Solver) -> dict[str, Any]:
        """The section that asks for something else than a map, if there is one; there cannot be two, but that what
        some studies are about may be uncertain."""
        keys = [key for key in data if key in STUDIES]
        several = len(keys) > 1 and not (len(keys) == 2 and "uncertain" in keys and {*keys} & {*WITH_UNCERTAIN})
        for key in keys[1:] if several else ():
            self.add((key,), f"got {key} besides {keys[0]}{self.line((keys[0],))}, expected one of them", at_key=True)
        studies: dict[str, Any] = {}
        for key in keys:
            if key == "uncertain":
                studies[key] = read_uncertain(self, data[key], solver.early_stop)
                continue
            if (section := self.read(section_class(key), (key,), data[key])) is not None:
                studies["study"] = section
            beside = {name: extensions.imported(place) for name, place in STUDIES[key].beside.items()}
            studies["beside"] = {
                name: self.section_of(model, (name,), data.get(name)) for name, model in beside.items()
            }
        if studies.get("uncertain") and not all(study_class(key).with_indices for key in keys):
            studies["uncertain"] = studies["uncertain"].model_copy(update={"indices": False})
        return studies

    # --- keys, sections -----------------------------------------------------------------------------------------------

    def unknown_key(self, path: Path, known: Collection[str], what: str = "key", hint: str | None = None) -> None:
        """Note that the last key of `path` is none of those `known`; it may belong elsewhere."""
        key = str(path[-1])
        sections: dict[str, type[Section]] = {**SECTIONS, "uncertain": SamplingSection}
        if key in QUANTITIES:
            self.meant.add(key)
            hint = f"{key} belongs to {QUANTITIES[key].section}, or to axes"
            self.add(path, f"unknown {what}, expected {listed(known)}", hint, at_key=True)
        elif owner := next((name for name, model in sections.items() if key in model.model_fields), None):
            self.add(path, f"unknown {what}, expected {listed(known)}", f"{key} belongs to {owner}", at_key=True)
        else:
            super().unknown_key(path, known, what, hint)

    # --- axes ---------------------------------------------------------------------------------------------------------

    def _axis(self, name: str, raw: object) -> Axis | None:
        """The axis called `name`; None if something is wrong with it."""
        path: Path = ("axes", name)
        if isinstance(raw, dict) and ("zip" in raw or "labels" in raw):
            return self._group(path, self.known_keys(raw, path, ("zip", "labels")))
        if name not in QUANTITIES:
            quantities = [quantity for quantity, row in QUANTITIES.items() if row.section in self._sections]
            self.unknown_key(path, quantities, "quantity", "a group of quantities needs the key zip")
            return None
        data = {"values": raw} if isinstance(raw, list) else raw
        if not isinstance(data, dict) or not data:
            self.refuse(path, _AXIS_FORMS, f"{name}: {{start: ..., stop: ..., num: 50}}")
            return None
        model: type[Range | Values] = Values if "values" in data else Range
        known = self.known_keys(data, path, [key for key in model.model_fields if key != "name"])
        return self.read(model, path, {"name": name, **known})

    def _group(self, path: Path, raw: Mapping[str, Any]) -> Group | None:
        """Quantities that vary together, under a name of their own."""
        name, labels, before = str(path[-1]), raw.get("labels"), len(self.problems)
        if name in QUANTITIES or name in MAP_VARIABLES or not _GROUP_NAME.fullmatch(name):
            expected = "a name of its own for the group: a word that is no quantity and no result"
            self.add(path, f"got the name {name}, expected {expected}", at_key=True)
        lists = raw.get("zip")
        if not isinstance(lists, dict) or not lists:
            self.add((*path, "zip"), "expected a mapping of quantities to lists of values", "zip: {mass: [1, 2], ...}")
            return None
        zipped = self.known_keys(lists, (*path, "zip"), QUANTITIES)
        members = [self.read(Values, (*path, "zip", member), {"name": member, "values": values})
                   for member, values in zipped.items()]  # fmt: skip
        if labels is not None and not isinstance(labels, list):
            self.refuse((*path, "labels"), "a list of names")
        names = labels if isinstance(labels, list) else []
        for i, label in enumerate(names):
            if self.is_text(label, (*path, "labels", i), "a name") and label in names[:i]:
                self.refuse((*path, "labels", i), "a name that is not in the list yet")
        columns = {(*path, "zip", member): values for member, values in zipped.items()} | {(*path, "labels"): labels}
        lengths = {place: len(values) for place, values in columns.items() if isinstance(values, list)}
        first: Path = next(iter(lengths), ())
        for place, length in lengths.items():
            if length != lengths[first]:
                self.add(place, f"got {length} values, expected {lengths[first]} like {first[-1]}{self.line(first)}")
        if len(self.problems) > before:
            return None
        return Group(name=name, members=tuple(member for member in members if member), labels=labels)

    # --- every quantity exactly once ----------------------------------------------------------------------------------

    def _given(self, data: Mapping[str, Any]) -> dict[str, list[Path]]:
        """The positions at which each quantity is given, rightly or wrongly."""
        inside = {key: value if isinstance(value, dict) else {} for key, value in data.items()}
        owners = QUANTITY_SECTIONS | {key: section_class(key) for key in data if key in STUDIES and key != "uncertain"}
        paths: list[Path] = [(key, name) for key, model in owners.items()
                             for name in inside.get(key, ()) if name in quantities_in(model)]  # fmt: skip
        scattered = inside.get("uncertain", {}).get("quantities")
        paths += [(*QUANTITIES_PATH, name) for name in scattered] if isinstance(scattered, dict) else []
        given: dict[str, list[Path]] = {}
        for path in (*paths, *varied_paths(inside.get("axes")), *self._study_paths(inside)):
            if path[-1] in QUANTITIES:
                given.setdefault(str(path[-1]), []).append(path)
        return given

    def _study_paths(self, sections: Mapping[str, Any]) -> list[Path]:
        """The positions of the quantities that sections of studies give themselves."""
        keys = [key for key in sections if key in STUDIES and key != "uncertain"]
        return [(key, *path) for key in keys for path in study_class(key).given_in(sections[key])]

    def _check_once(self, given: Mapping[str, list[Path]]) -> None:
        """No quantity is given twice, and those without a default are given."""
        for first, *others in given.values():
            for path in others:
                if self._elsewhere and path[0] in {"axes", *self._elsewhere}:
                    continue  # what is observed or predicted elsewhere
                message = f"given twice, as {dotted(first)}{self.line(first)} already, expected once"
                other = path if "--set" in self.line(first) else first
                is_set = "--set" in self.line(first) + self.line(path)
                hint = f"--set {dotted(other)}= removes the other" if is_set else "keep the one you mean"
                self.add(path, message, hint, at_key=True)
        for name, declared in QUANTITIES.items():
            if declared.section in self._sections - {"friction"} and declared.default is None:
                self._check_given(name, given)

    def _check_given(self, name: str, given: Collection[str]) -> None:
        declared = QUANTITIES[name]
        if name not in given and not self.meant & {name, declared.section, "axes"}:
            message = f"missing, expected the {declared.long_name}: {units.expected(declared.units)}"
            self.add((declared.section, name), message, f"or vary it: axes: {{{name}: ...}}")

    def _check_contact(self, friction: Any, given: Mapping[str, list[Path]]) -> None:
        """Check that the contact is given in one form of its model, completely, and with nothing of other laws."""
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
            if has_unread(self.document.data):
                message = f"nothing that is installed reads the points to fit, expected {forms}"
                self.add(
                    ("friction",), message, "an extension reads them; `stickslip --help` lists those that are here"
                )
            else:
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
            laws = [other for other in laws_with(name) if other in WRITTEN_LAWS]
            whose = f"the law {listed(laws)}" if laws else f"contacts with {STIFFNESS}"
            self.add(paths[0], f"got {name} with the law {law}, expected {expected}: it is for {whose}", at_key=True)

    def _check_study(self, config: Config) -> None:
        """Note what is wrong between the section of a study, or what is kept of a map, and the rest."""
        if config.study is not None:
            study_class(config.study.key).check(config.study, config, self)
        path, variables = ("output", "variables"), config.output.variables or ()
        if variables and not config.is_map:
            self.add(path, "given for something else than a map, expected none: only maps can do without variables")
        absent = [name for name in variables if VARIABLES[name].when == "full" and config.solver.early_stop]
        if absent:
            message = f"got {listed(absent, 'and')}, which only a run to a horizon defines"
            self.add(path, message, "add early_stop: false and a horizon to solver")
