"""The page of every variable of a result, from the tables that the results themselves are made of."""

from collections.abc import Iterable, Mapping

from making.markdown import code, sentence, table
from stickslip.config.studies import study_class
from stickslip.studies.uncertain import STATISTICS
from stickslip.vocabulary import quantities, units
from stickslip_rig.quantities import EXACT, FEATURES
from stickslip_sound.loudness import LEVEL_VARIABLES

HEAD = """# Variables of results

Every variable that a result may hold, with its unit and its long name, as they stand in the file. NaN where a thing
does not exist: the period of a motion that settles, say. What the field calls these things is in
[glossary.md](glossary.md), what certifies a regime in [regimes.md](regimes.md).
"""


def _of(key: str) -> Mapping[str, quantities.Variable]:
    return study_class(key).variables


_FULL = "; only with `solver: {early_stop: false}`"
_FAMILIES: dict[str, tuple[str, Mapping[str, quantities.Variable]]] = {
    "Of a cell": ("what `run` and `evaluate` give", quantities.MAP_VARIABLES),
    "Of a trajectory": ("what `simulate` gives, over `time`", quantities.TRACE_VARIABLES),
    "Of borders": ("what `border` gives ([borders.md](borders.md))", _of("border")),
    "Of contours": ("what `contours` gives ([borders.md](borders.md))", _of("contours")),
    "Of margins": (
        "what `advise` and `margins` give ([borders.md](borders.md#margins-how-far-from-the-border)), most once per "
        "parameter: `margin_stiffness`",
        _of("margins"),
    ),
    "Of goals": (
        "what `goal` gives ([explain.md](explain.md#what-should-friction-be-like-goals-backwards)); `here`, `alone` "
        "and `together` once per parameter of the plane: `alone_mu_start`",
        _of("goal"),
    ),
    "Of attractors": ("what `attractors` gives ([attractors.md](attractors.md))", _of("attractors")),
    "Of a ramp": ("what `ramp` gives ([attractors.md](attractors.md#slow-ramps))", _of("ramp")),
    "Of levels": ("what `listen --level` and `sound.levels` give ([pictures.md](pictures.md#sound))", LEVEL_VARIABLES),
    "Of scatter": (
        "what a section `uncertain` gives ([uncertainty.md](uncertainty.md)); of each metric asked for also "
        + ", ".join(f"`{name}_METRIC`" for name in STATISTICS),
        _of("uncertain"),
    ),
    "Of explanations": (
        "what `explain` gives ([explain.md](explain.md)); and of each uncertain quantity `posterior_NAME` (over "
        "`draw`), `interval_NAME` and `prior_interval_NAME`",
        _of("explain"),
    ),
}
_FLAGS = {
    "regime": "Regimes", "status": "Status: how the integration of a cell ended", "mode": "Contact modes",
    "method": "How a border was found", "share_method": "How a share was found",
    "verdict": "Verdicts on a goal",
}  # fmt: skip


def page() -> str:
    """The whole page, in Markdown."""
    parts = [HEAD]
    for heading, (where, variables) in _FAMILIES.items():
        parts += [f"## {heading}\n", sentence(where) + "\n", _variables(variables.values())]
    parts += ["## Of a rig record\n", "Defined in [rig.md](rig.md#features); the model RPN is not among them.\n"]
    parts += [_variables(FEATURES.values()), "And of a simulated one:\n", _variables(EXACT.values())]
    parts += ["## Flags\n", "Integers in the file; these are their names, in the order of the numbers from 0 on.\n"]
    for name, heading in _FLAGS.items():
        rows = ((str(number), code(flag), words) for number, (flag, words) in enumerate(quantities.FLAGS[name].items()))
        parts += [f"### {heading}\n", table(("", "name", "meaning"), rows)]
    return "\n".join(parts)


def _variables(rows: Iterable[quantities.Variable]) -> str:
    return table(("variable", "unit", "meaning"), ((code(v.name), _unit(v.units), _meaning(v)) for v in rows))


def _meaning(variable: quantities.Variable) -> str:
    words = [variable.long_name]
    if variable.comment:
        words.append(sentence(variable.comment).rstrip("."))
    return ". ".join(words) + (_FULL if variable.when == "full" else "")


def _unit(name: str) -> str:
    return {"parameter": "of the parameter", "flag": "flag"}.get(name) or units.spelled(name)
