"""What integers in results mean: regimes, ends of an integration, contact modes.

The value of a flag is its position.
"""

# Regimes are int8 and 0 means "this cell was not computed".
REGIME_MESSAGES = {
    "not_computed": "this cell was not computed",
    "stick_slip": "a limit cycle with a stick phase",
    "damped": "settles to steady sliding, crossing the equilibrium at least twice",
    "creep": "overdamped approach: settles to steady sliding, crossing the equilibrium at most once",
    "sustained": "oscillates indefinitely without sticking",
    "stuck": "never breaks away",
    "unresolved": "not decided: the horizon or the step budget ran out, or growth cannot be distinguished from decay",
    "failed": "no number could be computed; the status says why",
}
STATUS_MESSAGES = {
    "not_run": "this cell was not computed",
    "cycle_closed": "one full cycle was closed: from break-away to break-away, or the state recurred",
    "settled": "the motion came into the settling band, from where it is proven that it stays",
    "slip_cycle": "a limit cycle of slip in one direction: the state recurred",
    "never_breaks_away": "the contact sticks permanently",
    "horizon_reached": "the horizon was reached; raise `horizon` to see more",
    "step_limit": "the step budget ran out; raise `max_steps`",
    "step_underflow": "the step size fell below rounding",
    "not_finite": "a number was not finite",
    "neutral_ringing": "an undamped free vibration: the state recurred",
    "two_way_slip_cycle": "a limit cycle of slip in both directions, without sticking: the state recurred",
    "fall_hold_cycle": "a limit cycle of slip down the line of a hysteretic curve and up the curve: the state recurred",
    "settling_observed": "seen to shrink into the settling band, or to where small motions decay: not proven",
    "settling_certain": "the settling band was not reached, but it is proven that the motion settles",
    "too_slow_to_tell": "the amplitude grows or decays too slowly for the integration to tell the two apart",
    "negative_friction": "the slip reached speeds at which the law makes the friction coefficient negative",
    "hysteresis_undefined": "mu_stop was given for a curve that rises first and falls without end: it has no minimum",
    "irregular": "it sticks again and again, but not in the same way; stick-slip unless steady sliding is stable",
}
MODE_MESSAGES = {
    "stick": "the mass moves with the belt",
    "rise": "slip on the Stribeck curve (on a hysteretic one: below its minimum)",
    "fast": "slip on a hysteretic Stribeck curve at or above its minimum",
    "fall": "slip on the straight line of a hysteretic curve",
    "hold": "slip at constant speed, friction between the line and the curve (Filippov sliding mode)",
}
SHARE_MESSAGES = {
    "not_computed": "this cell was not computed",
    "exact": "the area inside the unstable cycle, or a theorem of the plane (see the attribute share_exact)",
    "sampled": "scrambled Sobol points in the box; the error is the standard error of their randomisations",
}
METHOD_MESSAGES = {
    "not_computed": "there is no border",
    "bisection": "the regime was bisected",
    "restick_margin": "stick-slip ends by grazing there: restick_margin passes zero, and a bracketed secant led to it",
    "growth_rate": "steady sliding loses its stability there, by linear theory; cells whose regime is known lie "
    "border_width apart on both sides",
}
COMPUTED_MESSAGES = {
    "inferred": "not computed itself: its regime is that of the computed cells around it",
    "computed": "computed itself",
}
QUIET_MESSAGES = {
    "not_computed": "this material was not computed",
    "border": "vibration ends there: above, up to the fastest speed searched, nothing vibrates for long",
    "quiet_throughout": "no vibration at any speed searched: the value is the slowest of them, an upper bound",
    "vibrates_throughout": "vibration up to the fastest speed searched: the value is that speed, a lower bound",
    "unresolved": "cells without a verdict lie around the border: the value is where these end, an upper bound",
    "not_determined": "the measured points do not tell where vibration ends, or are no friction coefficients",
}
VERDICT_MESSAGES = {
    "not_computed": "this was not computed",
    "vibrates": "a vibration lasts somewhere in the range, more often than the goal allows",
    "quiet": "no vibration lasts anywhere in the range, as often as the goal wants it",
    "undecided": "cells in the range are unresolved or failed, on which the verdict depends",
    "impossible": "no cell is so: friction at the minimum above that at break-away, say",
}
REGIMES = tuple(REGIME_MESSAGES)
# Codes of regimes that do not say what the motion is, and names of those that do.
UNDECIDED = tuple(REGIMES.index(name) for name in ("not_computed", "unresolved", "failed"))
DECIDED = tuple(name for code, name in enumerate(REGIMES) if code not in UNDECIDED)
STATUSES = tuple(STATUS_MESSAGES)
VERDICTS = tuple(VERDICT_MESSAGES)
MODES = tuple(MODE_MESSAGES)
SHARE_METHODS = tuple(SHARE_MESSAGES)
METHODS = tuple(METHOD_MESSAGES)
QUIET_STATES = tuple(QUIET_MESSAGES)
VIBRATING = ("stick_slip", "sustained")  # regimes in which a vibration lasts
FLAGS: dict[str, dict[str, str]] = {
    "regime": REGIME_MESSAGES, "status": STATUS_MESSAGES, "mode": MODE_MESSAGES, "computed": COMPUTED_MESSAGES,
    "regime_below": REGIME_MESSAGES, "regime_above": REGIME_MESSAGES,
    "regime_throughout": REGIME_MESSAGES, "method": METHOD_MESSAGES,
    "regime_from_stick": REGIME_MESSAGES, "regime_from_sliding": REGIME_MESSAGES, "share_method": SHARE_MESSAGES,
    "regime_left": REGIME_MESSAGES, "regime_right": REGIME_MESSAGES, "quiet_state": QUIET_MESSAGES,
    **dict.fromkeys(("verdict", "verdict_left", "verdict_right"), VERDICT_MESSAGES),
}  # fmt: skip

# Names in the field, beside ours.
_ALSO = {"creep": "overdamped"}


def flag_label(name: str) -> str:
    """The name of a flag as people read it in tables and legends."""
    return f"{name} ({_ALSO[name]})" if name in _ALSO else name
