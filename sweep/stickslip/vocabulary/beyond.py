"""Things the model does not have, named where people ask for them: one sentence for each, `PAGE` tells the rest.

And one that it has without a name of its own.
"""

PAGE = "speed"  # of the documentation: which tools have it

# A sentence, and the words that ask for it: keys of configurations and topics of `help`, spaces as underscores.
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
_BRISTLES = "Bristles stand on any friction curve: give the contact_stiffness of the contact beside its law"
_OF_BRISTLES = "lugre bristle bristles dahl elasto_plastic presliding".split()
SENTENCES = tuple(sentence for sentence, _ in _ROWS)
_BY_WORD = {word: sentence for sentence, words in _ROWS for word in words.split()}
_BY_WORD |= dict.fromkeys(_OF_BRISTLES, _BRISTLES)


def beyond_the_model(word: str) -> str | None:
    """The sentence on what a word asks for and the model does not have; None if it asks for nothing of the kind."""
    return _BY_WORD.get("_".join(word.lower().replace("-", " ").replace("_", " ").split()))


def hint(word: str) -> str | None:
    """The sentence with the page that names tools which have it."""
    sentence = beyond_the_model(word)
    if sentence == _BRISTLES:
        return f"{sentence}; `stickslip help memory` says more"
    return f"{sentence}; `stickslip help {PAGE}` names tools that have it" if sentence else None
