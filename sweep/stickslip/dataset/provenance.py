"""The global attributes of a dataset: what made its numbers, from what, when."""

import os
import platform
import subprocess
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import gmtime, strftime

from stickslip._version import __version__

CONVENTIONS = "CF-1.11"  # a test holds the compliance checker to it
REFERENCES = (
    "Controlling Stick-Slip Noise Generation with Lubricants, Sound & Vibration, June 2016: equation of motion, "
    "Eq. (1); Stribeck curve, Eq. (2); hysteretic curve, Eq. (2a); stick-slip tendency, Eq. (3)"
)
INCOMPLETE = "incomplete"  # attribute of a result that lacks blocks, unless its cells say so themselves
_REPORTED_PACKAGES = ("numba", "llvmlite", "numpy", "xarray", "netCDF4")


def provenance(configuration: str, *, title: str, action: str = "computed") -> dict[str, str]:
    """The global attributes of a dataset.

    configuration : the resolved configuration as text, everything needed to compute the dataset again.
    action : what was done, for the history line (a command, say).
    """
    now, revision = strftime("%Y-%m-%dT%H:%M:%SZ", gmtime()), git_revision()
    return {
        "Conventions": CONVENTIONS,
        "title": title,
        "source": f"stickslip {__version__}" + (f", git {revision}" if revision else ""),
        "history": f"{now} stickslip {__version__}: {action}",
        "references": REFERENCES,
        "date_created": now,
        "software": software(),
        "configuration": configuration,
    }


def git_revision() -> str | None:
    """Commit of the checkout this file is in, "-dirty" appended if tracked files differ; None outside a checkout."""
    return _revision(_checkout(__file__))


@cache
def _checkout(file: str) -> Path:
    return Path(file).resolve().parents[3]


@cache  # a process runs the files it has loaded, whatever becomes of them
def _revision(root: Path) -> str | None:
    if not (root / ".git").exists():  # an installed package: do not report the repository of whoever uses it
        return None
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    command = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True, env=environment)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None


@cache  # read from the files of the packages, a millisecond
def software() -> str:
    """Versions of what the numbers depend on, and the kind of machine."""
    versions = [f"Python {platform.python_version()}"]
    for package in _REPORTED_PACKAGES:
        with suppress(PackageNotFoundError):
            versions.append(f"{package} {version(package)}")
    return ", ".join([*versions, f"{platform.system()} {platform.machine()}"])
