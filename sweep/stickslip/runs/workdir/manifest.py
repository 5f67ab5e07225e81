"""The manifest of a working store: what is computed there, cut how, by what.

It is JSON with a checksum of its own, written before the first block and changed only when other kernels resume the
run. Everything in it but the versions follows from the configuration.

The identity of a run is its settings: the keys of a configuration that decide its results. The title, the execution
section, and of the output section all but `variables` do not; nor does the file a curve was fitted to, since the fitted
coefficients do. A result without some variables is another one: of it they can neither be taken, nor may they be lost
where it replaces one that holds them.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, astuple, dataclass, fields
from datetime import UTC, datetime
from typing import Any

from stickslip._version import __version__
from stickslip.config.grid import options_of
from stickslip.config.model import Config
from stickslip.dataset.provenance import software
from stickslip.engine import columns, kernels_digest
from stickslip.errors import DamagedManifestError
from stickslip.runs.blocks import Blocks
from stickslip.runs.work import Work

NAME = "manifest.json"
FORMAT = 2
_LONGEST = 60  # characters of a value that is shown
_VARIABLES = "output.variables"


@dataclass(frozen=True)
class Manifest:
    """The manifest of a store.

    fingerprint : of everything that the numbers depend on. configuration : resolved, as YAML text. cut : into blocks,
    as arguments of `Blocks`. kernels : digests of those that computed blocks, in the order they came.
    written_in : units of the configuration. fresh : begun to replace whatever result there is, and not finished.
    shards : into how many the blocks are dealt, by the last who worked on them; 0 for a whole run.
    """

    fingerprint: str
    configuration: str
    cut: tuple[int, int, int]
    kernels: tuple[str, ...]
    stickslip: str
    software: str
    created: str
    written_in: Mapping[str, str]
    fresh: bool = False
    shards: int = 0
    format: int = FORMAT

    @property
    def blocks(self) -> Blocks:
        """The cells, cut into blocks."""
        return Blocks(*self.cut)


def make(work: Work, fresh: bool = False) -> Manifest:
    """The manifest of a store that this process begins."""
    config, created = work.config, datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return Manifest(
        fingerprint(config), config.to_yaml(), astuple(work.blocks), (kernels_digest(),), __version__, software(),
        created, config.written_in, fresh,
    )  # fmt: skip


def encode(manifest: Manifest) -> bytes:
    """The bytes of a manifest."""
    plain = asdict(manifest)
    return json.dumps({**plain, "checksum": _checksum(plain)}, indent=1, ensure_ascii=False).encode()


def decode(data: bytes) -> Manifest:
    """The manifest these bytes are. Raises DamagedManifestError; other formats are read as far as they say so."""
    try:
        plain = json.loads(data.decode())
        if plain.pop("checksum") != _checksum(plain):
            raise ValueError("its checksum does not match")
        known = {field.name: plain[field.name] for field in fields(Manifest) if field.name in plain}
        known |= {name: tuple(known[name]) for name in ("cut", "kernels")}
        return Manifest(**known)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        reason = str(error) if "checksum does not" in str(error) else "it is not whole"
        raise DamagedManifestError(reason) from None


def _checksum(plain: Mapping[str, Any]) -> str:
    text = json.dumps(plain, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


# --- the identity of a run --------------------------------------------------------------------------------------------


def settings(config: Config) -> dict[str, Any]:
    """The settings that numbers depend on, as plain data; axes as a list, since their order is that of the cells."""
    plain = {key: value for key, value in config.resolved().items() if key not in ("title", "output", "execution")}
    plain["friction"] = {key: value for key, value in plain["friction"].items() if key != "fit"}
    variables = kept_variables(config)
    chosen = {} if variables is None else {"output": {"variables": variables}}
    return {**plain, **chosen, "axes": [[name, axis] for name, axis in plain["axes"].items()]}


def kept_variables(config: Config) -> list[str] | None:
    """The variables that a map keeps; None for all there are, whether they were named or not."""
    variables = config.output.variables
    if variables is None or not config.is_map or set(variables) == set(columns(options_of(config))):
        return None
    return list(variables)


def fingerprint(config: Config) -> str:
    """Equal for configurations of equal results, and only for those."""
    return hashlib.sha256(json.dumps(settings(config), sort_keys=True).encode()).hexdigest()[:32]


def differences(there: Config, here: Config) -> dict[str, tuple[str, str]]:
    """The keys in which two configurations differ, with both values as text, first that of `there`."""
    old, new = (dict(_flat(settings(config))) for config in (there, here))
    absent = {name: "all" if name == _VARIABLES else "nothing" for name in old | new}
    pairs = {name: (old.get(name, nothing), new.get(name, nothing)) for name, nothing in absent.items()}
    return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}


def described(differing: dict[str, tuple[str, str]]) -> str:
    """Differences for people, one a line."""
    short = {
        name: [text[:_LONGEST] + "..." * (len(text) > _LONGEST) for text in pair] for name, pair in differing.items()
    }
    return "\n".join(f"  {name}: {there} there, {here} here" for name, (there, here) in short.items())


def _flat(plain: dict[str, Any], path: str = "") -> Iterator[tuple[str, str]]:
    """`solver.rtol`, `1e-06` and so on for nested mappings."""
    for key, value in plain.items():
        if not path and key == "axes":
            yield "order of axes", ", ".join(name for name, _ in value)
            value = dict(value)
        if isinstance(value, dict):
            yield from _flat(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", json.dumps(value, ensure_ascii=False)
