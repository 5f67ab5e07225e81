"""What integers in results say: regimes, ends of an integration, contact modes. The value is the position."""

from __future__ import annotations

# Regimes are int8 and 0 means "nobody computed this cell".
REGIME_MESSAGES = {
    "not_computed": "this cell was not computed",
    "stick_slip": "a limit cycle with a stick phase",
    "damped": "settles to steady sliding, crossing the equilibrium at least twice",
    "creep": "overdamped approach: settles to steady sliding, crossing the equilibrium at most once",
    "sustained": "oscillates for ever without sticking",
    "stuck": "never breaks away",
    "unresolved": "not decided: the horizon or the step budget ran out, or growth cannot be told from decay",
    "failed": "no number could be computed; the status says why",
}
STATUS_MESSAGES = {
    "not_run": "this cell was not computed",
    "cycle_closed": "one full cycle from break-away to break-away was closed",
    "settled": "the motion came into the settling band, from where it is proven that it stays",
    "slip_cycle": "a cycle of slip in one direction came back to where it was",
    "never_breaks_away": "the contact sticks for ever",
    "horizon_reached": "the horizon was reached; raise `horizon` to see more",
    "step_limit": "the step budget ran out; raise `max_steps`",
    "step_underflow": "the step size fell below rounding",
    "not_finite": "a number was not finite",
    "neutral_ringing": "a free vibration that nothing damps or feeds came back to where it was",
    "two_way_slip_cycle": "a cycle of slip in both directions, without sticking, came back to where it was",
    "fall_hold_cycle": "a cycle of slip down the line of a hysteretic curve and up again came back to where it was",
    "settling_observed": "the peaks of a chain of falls and holds shrank inside the settling band: seen, not proven",
    "settling_certain": "the settling band was not reached, but it is proven that nothing else is left",
    "too_slow_to_tell": "the amplitude grows or decays too slowly for the integration to tell which",
    "negative_friction": "the slip reached speeds at which the law makes the friction coefficient negative",
}
MODE_MESSAGES = {
    "stick": "the mass rides on the belt",
    "rise": "slip on the Stribeck curve (on a hysteretic one: below its minimum)",
    "fast": "slip on a hysteretic Stribeck curve at or above its minimum",
    "fall": "slip on the straight line of a hysteretic curve",
    "hold": "slip at constant speed, friction between the line and the curve",
}
REGIMES = tuple(REGIME_MESSAGES)
STATUSES = tuple(STATUS_MESSAGES)
MODES = tuple(MODE_MESSAGES)
FLAGS: dict[str, dict[str, str]] = {
    "regime": REGIME_MESSAGES, "status": STATUS_MESSAGES, "mode": MODE_MESSAGES,
    "regime_below": REGIME_MESSAGES, "regime_above": REGIME_MESSAGES,
}  # fmt: skip

# What is said beside a flag that has another name in the field.
_ALSO = {"creep": "overdamped"}


def flag_label(name: str) -> str:
    """The name of a flag as people read it in tables and legends."""
    return f"{name} ({_ALSO[name]})" if name in _ALSO else name
