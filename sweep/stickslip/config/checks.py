"""Checks of what a configuration asks for, and what its study needs of the rest.

The first part looks at plain data before it is read, the second at what was read.
"""

from collections.abc import Mapping
from typing import Any

from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.rules import Finding
from stickslip.config.studies import study_class
from stickslip.errors import Path
from stickslip.vocabulary.models.lugre import STIFFNESS
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.studies import STUDIES
from stickslip.vocabulary.suggest import listed

RIGID = "none"  # for the stiffness of a contact that sticks without giving way


def with_rigid_contact(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """The plain data, without the stiffness of a contact that has none."""
    friction = data.get("friction")
    if not isinstance(friction, dict) or friction.get(STIFFNESS) != RIGID:
        return data
    return {**data, "friction": {name: value for name, value in friction.items() if name != STIFFNESS}}


def varied_paths(axes: Mapping[str, Any]) -> list[Path]:
    """The positions of the quantities along axes, whether they are right or wrong."""
    paths: list[Path] = []
    for name, axis in axes.items():
        zipped = axis.get("zip") if isinstance(axis, dict) else None
        if isinstance(zipped, dict):
            paths += [("axes", name, "zip", member) for member in zipped if member in QUANTITIES]
        elif name in QUANTITIES:
            paths.append(("axes", name))
    return paths


def study_paths(sections: Mapping[str, Any]) -> list[Path]:
    """The positions of the quantities that sections of studies give themselves."""
    keys = [key for key in sections if key in STUDIES and key != "uncertain"]
    return [(key, *path) for key in keys for path in study_class(key).given_in(sections[key])]


# --- what studies need ------------------------------------------------------------------------------------------------


def check_study(config: Config, problems: ProblemCollector) -> None:
    """Note what is wrong between the section of a study, or what is kept of a map, and the rest."""
    if config.study is not None:
        study_class(config.study.key).check(config.study, config, problems)
    path, variables = ("output", "variables"), config.output.variables or ()
    if variables and not config.is_map:
        problems.add(path, "given for something else than a map, expected none: only maps can do without variables")
    absent = [name for name in variables if VARIABLES[name].when == "full" and config.solver.early_stop]
    if absent:
        message = f"got {listed(absent, 'and')}, which only a run to a horizon defines"
        problems.add(path, message, "add early_stop: false and a horizon to solver")


def add_finding(problems: ProblemCollector, finding: Finding) -> None:
    """Note a rule that is broken."""
    got = finding.got or problems.text(finding.path)
    problems.add(finding.path, f"got {got}, expected {finding.expected}", finding.hint)
