"""Words in messages: the one that was probably meant, and several in a row.

Words of others for ours (symbols of formulas, the field's words, other programs' keys) are never read, since a file
should say the same to everyone; messages name ours.
"""

import difflib
from collections.abc import Iterable

from stickslip.vocabulary.models import MODELS

_SYNONYMS = {
    "mass": "m moving_mass weight",
    "stiffness": "k spring spring_constant spring_stiffness spring_rate stiffnes c_spring",
    "damping": "c d damper dashpot damping_coefficient viscous_damping viscosity",
    "normal_load": "n fn f_n load force normal_force normalforce preload contact_force pressing_force",
    "belt_speed": "v v0 v_belt vb speed drive_speed driving_speed driving_velocity belt_velocity sliding_speed "
    "sliding_velocity pulling_speed",
    "contact_time": "hold_time dwell_time rest_time",
    "displacement": "x x0 position",
    "velocity": "v0 xdot start_velocity",
    "stroke": "amplitude travel",
    "dwell": "pause",
    "start": "from min minimum begin low lower initial",
    "stop": "to max maximum end high upper final",
    "num": "n steps points count number size nr num_points",
    "spacing": "scale scaling",
    "axes": "axis sweep vary parameters grid ranges",
    "friction": "friction_law contact material curve",
    "system": "oscillator model",
    "output": "out results save files",
    "solver": "integrator settings tolerances",
    "execution": "compute parallel threads",
    "file": "filename path nc result",
    "plot": "figure picture image png",
    "rtol": "tol tolerance reltol rel_tol",
    "horizon": "t_end tend duration t_max time",
    "title": "name label",
} | {
    name: row.synonyms for model in MODELS for name, row in (*model.parameters.items(), *model.measured.items())
}  # fmt: skip


def suggest(word: str, among: Iterable[str]) -> str | None:
    """The word `among` the possible ones that was probably meant: a synonym, or one that is spelled much like it."""
    known = list(among)
    return synonym_of(word, known) or nearest(word, known)


def did_you_mean(word: str, among: Iterable[str]) -> str | None:
    """The question `did you mean mass?` about a word that is none `among` the possible ones; None if none is near."""
    near = suggest(word, among)
    return f"did you mean {near}?" if near else None


def or_meant(word: str, among: Iterable[str], before: str = "; ", otherwise: str = "") -> str:
    """The end of a message about such a word: `; did you mean mass?`, or `otherwise`."""
    question = did_you_mean(word, among)
    return f"{before}{question}" if question else otherwise


def synonym_of(word: str, among: Iterable[str]) -> str | None:
    """Our word for what somebody else calls `word`, if it is `among` those that are possible."""
    known, spelled = set(among), word.strip().lower().replace("-", "_").replace(" ", "_")
    return next((ours for ours, words in _SYNONYMS.items() if ours in known and spelled in words.split()), None)


def nearest(word: str, among: Iterable[str]) -> str | None:
    """The word that is spelled most like `word`, if any comes close."""
    known, spelled = list(among), word.lower().replace("-", "_").replace(" ", "_")
    if swapped := [one for one in known if sorted(one) == sorted(spelled)]:  # strokse is strokes rather than stroke
        return swapped[0]
    if whole := [one for one in known if spelled in one.split("_")]:  # belt is belt_speed rather than delta
        return whole[0]
    close = difflib.get_close_matches(spelled, known, 1, 0.6)
    return close[0] if close else None


def listed(words: Iterable[str], last: str = "or") -> str:
    """Words in a row: ``a, b or c``."""
    *first, final = words
    return f"{', '.join(first)} {last} {final}" if first else final
