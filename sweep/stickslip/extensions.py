"""Extensions: packages that lean on the engine and bring commands, Python calls, sections, studies and figures.

An extension is found by an entry point of the group `stickslip.extensions`, in whatever package it is installed:

    [project.entry-points."stickslip.extensions"]
    sound = "stickslip_sound.extension:EXTENSION"

whose value is an `Extension`, in a module that imports nothing of the engine but this one. What it brings is named by
place, `module` or `module:name`, and imported when it is used. The engine asks for what there is, and knows no
extension by name.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.metadata import entry_points
from importlib.util import spec_from_loader
from types import ModuleType
from typing import Any, NamedTuple

GROUP = "stickslip.extensions"
Place = str  # `module` or `module:name`


class StudyEntry(NamedTuple):
    """What may be computed instead of a map, by the key of the section that asks for it.

    place : of the class. command : what the command of this name does, where there is one. with_uncertain : whether the
    section may stand beside `uncertain`, whose quantities are then its own. beside : places of other sections that it
    brings, by key. apart : the command that alone computes such configurations; "" if `run` does.
    """

    place: Place
    command: str = ""
    with_uncertain: bool = False
    beside: Mapping[str, Place] = {}
    apart: str = ""


@dataclass(frozen=True)
class Extension:
    """What an extension brings.

    commands : by what they are about, by name: places of click commands.
    calls : by name in `stickslip` (`plots.NAME` in one of its rooms): places of modules, functions and classes.
    quantities : places of tables of quantities, by the section that holds them. marks : of results without the
        attribute `result`, the kind by a variable that no others have.
    results : by kind, of results that are no studies, places of a `config.studies.Result`; `marks` tell them, too.
    subjects : names of variables that a map is about where it has them, and not about its regimes.
    studies : by key. resolvers : by the path of a key in a file (`friction.fit`, `*` for any name or number), places of
        functions that take the document and give it with what the key stands for, in this order.
    methods : by name in `ds.stickslip`: places of functions that take a dataset first.
    """

    commands: Mapping[str, Mapping[str, Place]] = field(default_factory=dict)
    calls: Mapping[str, Place] = field(default_factory=dict)
    quantities: Mapping[str, Place] = field(default_factory=dict)
    marks: Mapping[str, str] = field(default_factory=dict)
    results: Mapping[str, Place] = field(default_factory=dict)
    studies: Mapping[str, StudyEntry] = field(default_factory=dict)
    resolvers: Mapping[str, Place] = field(default_factory=dict)
    subjects: Sequence[str] = ()
    methods: Mapping[str, Place] = field(default_factory=dict)


def installed() -> tuple[Extension, ...]:
    """The extensions that are there, in the order of their names."""
    return tuple(named().values())


@cache
def named() -> Mapping[str, Extension]:
    """The extensions that are there by name, in the order of names.

    One whose package was taken away though its entry point is still listed (an editable installation) is left out.
    """
    extensions = {}
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        try:
            extensions[point.name] = point.load()
        except ModuleNotFoundError as error:
            if error.name != point.module.partition(".")[0]:
                raise
        except AttributeError as error:  # its module imports the engine, which is just asking for it
            raise ImportError(f"{point.value}: expected in a module that imports stickslip.extensions alone") from error
    return extensions


def brought(field: str) -> dict[str, Any]:
    """One field of all extensions, joined: `brought("calls")`; of a name in two of them, the first holds."""
    joined: dict[str, Any] = {}
    for extension in reversed(installed()):
        joined |= getattr(extension, field)
    return joined


def commands() -> Iterator[tuple[str, Mapping[str, Place]]]:
    """The names of extensions, each with places of its commands by name."""
    for name, extension in named().items():
        yield name, {command: place for row in extension.commands.values() for command, place in row.items()}


def call(name: str, module: str) -> Any:
    """What extensions bring under a name in a module of the engine. Raises AttributeError."""
    places = {} if name.startswith("_") else brought("calls")
    inside = module.removeprefix("stickslip").removeprefix(".")
    whole = f"{inside}.{name}" if inside else name
    if whole not in places:
        raise AttributeError(f"module {module!r} has no attribute {name!r}")
    return imported(places[whole])


class _Named(MetaPathFinder, Loader):
    """Lets `from stickslip.sound import levels` find the module that an extension calls `sound`."""

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        package, _, name = fullname.rpartition(".")
        if package != "stickslip" or ":" in brought("calls").get(name, ":"):
            return None
        return spec_from_loader(fullname, self)

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = imported(brought("calls")[spec.name.rpartition(".")[2]])
        self._spec = module.__spec__
        return module  # type: ignore[no-any-return]

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__ = self._spec


sys.meta_path.append(_Named())


def imported(place: Place) -> Any:
    """What lies at a place."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name) if name else import_module(module)
