"""Words in messages: the one that was probably meant, several in a row, and things that the model does not have.

Symbols of formulas and the field's other words for our quantities are never read, since a file should say the same to
everyone; messages name ours.
"""

import difflib
from collections.abc import Iterable

from stickslip.vocabulary.quantities import QUANTITIES


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
    """Our quantity for what somebody else calls `word`, if it is `among` those that are possible."""
    known, spelled = set(among), word.strip().lower().replace("-", "_").replace(" ", "_")
    rows = (row for name, row in QUANTITIES.items() if name in known)
    return next((row.name for row in rows if spelled in row.synonyms.lower().split()), None)


def nearest(word: str, among: Iterable[str]) -> str | None:
    """The word that is spelled most like `word`, if any comes close."""
    known, spelled = list(among), word.lower().replace("-", "_").replace(" ", "_")
    if swapped := [other for other in known if sorted(other) == sorted(spelled)]:  # strokse is strokes, not stroke
        return swapped[0]
    if whole := [other for other in known if spelled in other.split("_")]:  # belt is belt_speed rather than delta
        return whole[0]
    close = difflib.get_close_matches(spelled, known, 1, 0.6)
    return close[0] if close else None


def listed(words: Iterable[str], last: str = "or") -> str:
    """Words in a row: ``a, b or c``."""
    *first, final = words
    return f"{', '.join(first)} {last} {final}" if first else final


# --- what the model does not have -------------------------------------------------------------------------------------

# A sentence, and the words in configurations that ask for it, spaces as underscores.
_ROWS = (
    (
        "The model is one mass on one spring: it has no second mass, no further degree of freedom, no coupled modes",
        "mass_2 m2 second_mass masses stiffness_2 k2 damping_2 c2 degrees_of_freedom dof modes mode_coupling flutter "
        "brake squeal torsion",
    ),
    (
        "The belt runs at a constant speed, the plate of a rig in strokes: neither is elastic or has a motor",
        "belt_speed_amplitude belt_speed_frequency elastic_belt belt_stiffness belt_mass drive_stiffness motor gear",
    ),
    (
        "The normal load is constant in time: it has no amplitude, frequency, modulation or dither",
        "modulation load_modulation load_amplitude normal_load_amplitude normal_load_frequency dither variable_load "
        "ultrasonic contact_loss",
    ),
    (
        "Nothing but the belt, or the plate of a rig, moves the mass: no external force and no base excitation",
        "forcing excitation external_force base_excitation",
    ),
    (
        "Temperature is no quantity of the model: give each temperature a friction curve of its own (axes with labels)",
        "temperature thermal heating flash_temperature",
    ),
    (
        "Friction does not change with the number of cycles: the model has no wear, running-in or third body",
        "wear running_in run_in archard third_body debris",
    ),
    (
        "A contact has one layer of bristles, contact_stiffness, or none: no hysteresis with nonlocal memory",
        "leuven gms maxwell_slip generalised_maxwell_slip iwan jenkins nonlocal_memory",
    ),
    (
        "The contact is one point of dry friction: it has no area and no pressure distribution",
        "contact_area pressure hertz asperities roughness fem finite_element",
    ),
)
SENTENCES = tuple(sentence for sentence, _ in _ROWS)
_BY_WORD = {word: sentence for sentence, words in _ROWS for word in words.split()}
_BRISTLES = "Bristles stand on any friction curve: give the contact_stiffness of the contact beside its law"
_BY_WORD |= dict.fromkeys("lugre bristle bristles dahl elasto_plastic presliding".split(), _BRISTLES)


def beyond_the_model(word: str) -> str | None:
    """The sentence on what a word asks for and the model does not have; None if it asks for nothing of the kind."""
    return _BY_WORD.get("_".join(word.lower().replace("-", " ").replace("_", " ").split()))


def beyond_hint(word: str) -> str | None:
    """The sentence with the page that says more: which tools have it."""
    sentence = beyond_the_model(word)
    more = "memory` says more" if sentence == _BRISTLES else "speed` names tools that have it"
    return f"{sentence}; `stickslip help {more}" if sentence else None
