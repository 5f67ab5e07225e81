"""Whether what a configuration asks for can be computed: lines, planes, boxes with possible cells; variables."""

from __future__ import annotations

from stickslip.config import refined
from stickslip.config.complaints import Complaints
from stickslip.config.lines import broken_rules, line_along
from stickslip.config.model import Config
from stickslip.config.planes import broken_in_plane, plane_along
from stickslip.config.states import STATES_IN_BOX, state_axes
from stickslip.errors import ArgumentError
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.words import listed


def check(config: Config, found: Complaints) -> None:
    """Note what is wrong between a section that asks for something else than a map, and the rest."""
    for one in (_lines, _plane, _states, _boxes, _variables):
        one(config, found)


def _lines(config: Config, found: Complaints) -> None:
    """The lines that are searched for borders exist, and cells on them are possible."""
    if config.border is None:
        return
    try:
        line = line_along(config, config.border.along, config.border.between)
    except ArgumentError as error:
        found.add(("border", error.key), error.what)
        return
    for finding in broken_rules(config, config.border.along, line):
        got = finding.got or found.text(finding.path)
        found.add(finding.path, f"got {got}, expected {finding.expected}", finding.hint)


def _states(config: Config, found: Complaints) -> None:
    """Starting states come from the box, and from no axis."""
    for path in state_axes(config) if config.attractors else ():
        found.add(path, STATES_IN_BOX, at_key=True)


def _boxes(config: Config, found: Complaints) -> None:
    """There is an axis along which a map can be refined."""
    for finding in refined.broken_rules(config.axes, config.refine) if config.refine else ():
        got = finding.got or found.text(finding.path)
        found.add(finding.path, f"got {got}, expected {finding.expected}", finding.hint, at_key=bool(finding.got))


def _plane(config: Config, found: Complaints) -> None:
    """The plane in which borders are followed exists, and cells in it are possible."""
    if config.contours is None:
        return
    try:
        plane = plane_along(config, config.contours.axes, config.contours.between or {})
    except ArgumentError as error:
        found.add(("contours", error.key), error.what)
        return
    for finding in broken_in_plane(config, plane):
        path = finding.path
        if path[0] == "contours" and path[-1] not in (config.contours.between or {}):
            path = ("axes", path[-1])
        found.add(path, f"got {finding.got or found.text(path)}, expected {finding.expected}", finding.hint)


def _variables(config: Config, found: Complaints) -> None:
    """Variables that are to be kept exist in the result."""
    path, kept = ("output", "variables"), config.output.variables or ()
    if kept and not config.is_map:
        found.add(path, "given for something else than a map, expected none: only maps can do without variables")
    absent = [name for name in kept if VARIABLES[name].when == "full" and config.solver.early_stop]
    if absent:
        message = f"got {listed(absent, 'and')}, which only a run to a horizon defines"
        found.add(path, message, "add early_stop: false and a horizon to solver")
