"""What was drawn and how, as global attributes of a result."""

from __future__ import annotations

from stickslip.config.uncertain import Uncertain


def told(said: Uncertain, undecided: float) -> dict[str, str]:
    """Method, quantities, correlation, and the share of draws that say nothing."""
    return {
        "uncertain_method": said.method_in_words,
        "uncertain_quantities": "; ".join(f"{one.name}: {one.in_words}" for one in said.quantities),
        "uncertain_correlation": said.correlation_in_words,
        "uncertain_undecided": f"{100 * undecided:.3g} % of all draws were unresolved, failed or not computed",
    }
