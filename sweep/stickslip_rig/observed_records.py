"""The step between reading a document and checking it: the features of records in place of their names.

    observed: [{record: felt.csv, drive: rig.yaml}]

becomes an observation at the conditions of the rig, with the features of the record and all that a simulated one needs.
`observation.py` evaluates them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path as FilePath
from typing import Any

from stickslip.config.yaml import Document
from stickslip.errors import ConfigError, Path, QuantityError
from stickslip.vocabulary.quantities import QUANTITIES

EXPLAIN = "explain"
_OF_RIG = ("system", "friction", "start", "drive", "sensor", "features", "solver")  # what a simulated record needs
_FORMS = {"record": (str, "the name of a CSV file: record: felt.csv"),
          "drive": (str | Mapping, "the configuration of the rig: drive: rig.yaml")}  # fmt: skip


def with_records(document: Document) -> Document:
    """The document, its observations with the features of the records that they name.

    Where features stand beside the name (a resolved configuration), nothing is read. What is wrong with the section is
    left to whoever checks it. Raises ConfigError for wrong records, and records of other tests.
    """
    data = document.data if isinstance(document.data, dict) else {}
    section, uncertain = data.get(EXPLAIN), data.get("uncertain")
    observations = section.get("observed") if isinstance(section, dict) else None
    if not isinstance(section, dict) or not isinstance(observations, list):
        return document
    quantities = uncertain.get("quantities") if isinstance(uncertain, dict) else None
    unknown = [*quantities] if isinstance(quantities, dict) else []
    whole = [_whole(document, (EXPLAIN, "observed", i), given, unknown) if _names_record(given) else given
             for i, given in enumerate(observations)]  # fmt: skip
    return replace(document, data={**data, EXPLAIN: {**section, "observed": whole}})


def _names_record(given: Any) -> bool:
    return isinstance(given, dict) and bool({"record", "drive"} & given.keys()) and "features" not in given


def _whole(document: Document, path: Path, given: dict[str, Any], unknown: Collection[str]) -> dict[str, Any]:
    """An observation with what its record says. unknown : quantities that are not taken from the rig."""
    for key, (kind, expected) in _FORMS.items():
        if not isinstance(given.get(key), kind):
            what, place = (f"got {given[key]!r}", (*path, key)) if key in given else ("missing", path)
            raise document.refused(place, f"{what}, expected {expected}")
    record, drive = given["record"], given["drive"]
    conditions, key = {}, ""
    # which loads the kernels, for nothing where no record is named
    observation = import_module("stickslip_rig.observation")
    try:
        for key in [name for name in given if name in QUANTITIES]:
            conditions[key] = QUANTITIES[key].read(given[key])
        key = "drive"
        rig = observation.rig_of(_beside(document, drive) if isinstance(drive, str) else drive, conditions)
        key = "record"
        measured = observation.read_record(_beside(document, record))
        features = observation.observed(measured, rig, unknown, bool(given.get("scatter")))
    except ConfigError:
        raise
    except QuantityError as error:
        raise document.refused((*path, key), f"got {given[key]!r}, expected {error.expected}") from None
    except ValueError as error:
        name = given[key] if isinstance(given[key], str) else key
        raise document.refused((*path, key), f"{name}: {error}") from None
    plain = rig.resolved()
    at = {name: value for name, value in plain["system"].items() if name not in unknown}
    return {**at, **features._asdict(), **given, "drive": {name: plain[name] for name in _OF_RIG}}


def _beside(document: Document, name: str) -> str:
    """A file beside the configuration, or else from the folder that the program runs in."""
    beside = FilePath(document.name).parent / name
    return str(beside if beside.exists() else name)
