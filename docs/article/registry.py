"""The table of figures. A new one is a function that returns `Made`, its configuration, and a line here.

`agrees` and `differs` are sentences for the gallery; fields in braces are findings, so no number is typed by hand.
"""

from __future__ import annotations

from article import ageing, borders, curves, motion, springs, stiffness, tendency
from article.recipe import Figure

FIGURES: dict[str, Figure] = {
    "fig2": Figure(
        "Stribeck curve with its transition point",
        curves.figure_2,
        ("fig2",),
        "Stick-slip occurs solely in the declining branch of the Stribeck curve.",
        "The transition point v(mu_min) is {v_min:.4f} m/s, the friction coefficient there {mu_min:.4f}. Started "
        "close to steady sliding, stick-slip ends at {edge_from_sliding:.4f} m/s, the transition point.",
        "Started from sticking, it persists up to {edge_from_sticking:.3f} m/s, {edge_from_sticking_over_v_min:.2f} "
        "times as fast: in the rising branch stick-slip and steady sliding coexist.",
    ),
    "borders": Figure(
        "What becomes of the declining branch: exact borders",
        borders.figure_borders,
        ("borders",),
        "Stick-slip occurs solely in the declining branch of the Stribeck curve.",
        "In the declining branch, below {v_min:.4f} m/s, the mass stick-slips on all {lines:.0f} springs; on soft ones "
        "stick-slip ends close to there ({stiffness_soft:.2g} N/m: {end_soft:.6f} m/s, {end_soft_over_v_min:.3f} times "
        "as fast).",
        "On stiff ones it goes far into the rising branch: at {stiffness_stiff:.4g} N/m to {end_stiff:.6f} m/s, "
        "{end_stiff_over_v_min:.2f} times as fast, and no further than {limit:.4f} m/s, the near-harmonic limit. In "
        "the hatched band steady sliding is stable as well: which one it is depends on the start. Each point of the "
        "line is known to {width:.0e} of itself.",
    ),
    "basins": Figure(
        "What depends on the start: shares and shocks",
        borders.figure_basins,
        ("basins",),
        "Each curve has one outcome: stick-slip, a damped oscillation, or creep.",
        "Up to {stable_from:.4f} m/s, in the declining branch, no starting state settles (1 N/m).",
        "From there on to {both_to:.3f} m/s both are possible. At {belt_speed:g} m/s {share:.1%} of the starting "
        "states in a box (displacement 0 to 2 m, velocity -1 to 1 m/s) settle to steady sliding, and a shock of "
        "{shock:.4f} m/s ends it for ever; at {both_to:.3f} m/s {share_last:.1%} settle, and it takes "
        "{shock_last:.4f} m/s. The border between the two is an unstable cycle, found backwards in time.",
    ),
    "fig3": Figure(
        "Displacement and velocity in stick-slip",
        motion.figure_3,
        ("fig3",),
        "Stick phases at the speed of the belt alternate with slip.",
        "Break-away to break-away takes {period:.4f} s, {stick_fraction:.1%} of it sticking at the speed of the belt.",
    ),
    "fig4": Figure(
        "Passage through the Stribeck curve",
        motion.figure_4,
        ("fig4",),
        "The slip speed always overshoots the speed of the belt, and can pass through the rising branch.",
        "The slip speed reaches {overshoot_1:.2f} times the belt speed at {belt_speed_1:g} m/s and "
        "{overshoot_2:.2f} times at {belt_speed_2:g} m/s; the faster one ({slip_speed_max_2:.3f} m/s) passes the "
        "transition point ({v_min:.3f} m/s) into the rising branch, the slower one ({slip_speed_max_1:.3f} m/s) "
        "does not.",
    ),
    "fig5": Figure(
        "Declining, flat and rising curves",
        motion.figure_5,
        ("fig5",),
        "A flat curve gives a damped oscillation, a rising one a damped oscillation or creep, neither stick-slip.",
        "Declining: {regime_declining}; rising: {regime_rising} (damping ratio {damping_ratio_rising:.2f}); "
        "steeply rising: {regime_steeply_rising} (damping ratio {damping_ratio_steeply_rising:.2f}).",
        "Nothing damps the oscillation on a flat curve: it is {regime_flat}. The damped oscillation of "
        "the article needs a damper; a damping ratio of {damping_ratio_flat_with_a_damper:.3f} is enough.",
    ),
    "fig6": Figure(
        "Influence of the stiffness, plain curve",
        stiffness.figure_6,
        ("fig6",),
        "Stiffer means higher frequency and smaller amplitude; no stiffness is free of stick-slip.",
        "All {cells:.0f} cells over {decades:.0f} decades of stiffness and five belt speeds are in stick-slip. "
        "From 1 to 10,000 N/m (belt 0.1 m/s) the frequency rises from {frequency_k1:.3g} to "
        "{frequency_k10000:.3g} per second, and the amplitude of the displacement falls from "
        "{displacement_amplitude_k1:.3g} to {displacement_amplitude_k10000:.2g} m.",
        "The friction force does not follow: without a damper its rise while sticking grows from "
        "{friction_swing_k1:.2f} to {friction_swing_k1000:.2f} N (1 to 1000 N/m).",
    ),
    "fig7": Figure(
        "Possible curves during deceleration",
        curves.figure_7,
        ("fig8",),
        "Friction while slowing down may differ from friction while speeding up: a straight line below the minimum.",
        "From the minimum ({mu_reversal:.4f} at {v_reversal:.4f} m/s) to mu_stop; tendencies {tendency_1:+.3f}, "
        "{tendency_2:+.4f} and {tendency_3:+.3f}.",
        "Slip that reverses below the minimum starts its line there (dashed): the article leaves this open.",
    ),
    "fig8": Figure(
        "Influence of mu_stop",
        motion.figure_8,
        ("fig8",),
        "mu_stop1 gives stick-slip, mu_stop2 a damped vibration, and with mu_stop3 sliding is soon stationary.",
        "mu_stop1: {regime_1}; mu_stop2: {regime_2}, with {equilibrium_crossings_2:.0f} crossings of the "
        "equilibrium over {settling_time_2:.0f} s; mu_stop3: {regime_3}, with {equilibrium_crossings_3:.0f} over "
        "{settling_time_3:.0f} s.",
        "At mu_stop2 the tendency is zero, the border by Eq. (3); here stick-slip ends at {border_mu_stop:.3f} "
        "already. In between the mass slips at a constant speed (the flat segments), while friction rises from "
        "the line to the curve (a Filippov sliding mode): what the article leaves open, because its line and its "
        "curve would disagree there.",
    ),
    "eq3": Figure(
        "Tendency and simulated regime",
        tendency.figure_maps,
        ("eq3",),
        "Tendency above zero means stick-slip, below zero none.",
        "Over the minimum of the curve and mu_stop the sign is right in {share_predicted:.1%} of {cells:,.0f} cells.",
        "At low speed (0.02 m/s: {share_predicted_v0_02:.1%}) it misses stick-slip, because the straight line is no "
        "mirror image of the curve; at high speed (0.2 m/s: {share_predicted_v0_2:.1%}) it raises false alarms, as "
        "the path through the rising branch dissipates energy. At the slowest belt and a low mu_stop fast and slow "
        "slip alternate without end and without sticking (sustained), at a tendency below zero. It takes "
        "mu_reversal as it occurred in each simulated motion, and mu_start as friction at break-away: it diagnoses a "
        "motion, it predicts none.",
    ),
    "eq3_box": Figure(
        "The tendency over a wide range of parameters",
        tendency.figure_box,
        ("eq3_box",),
        "The conclusions can be drawn without knowledge of the system's flexibility.",
        "Over {cells:,.0f} cells the sign is right in {share_predicted:.1%}; stick-slip is missed in "
        "{share_missed:.1%} of the cells that have it, and announced in {share_false_alarm:.1%} of those that "
        "have none. It is exact for a curve the line mirrors (an error of {mirror_error_a4_10:.4f} of the drop, "
        "and going with the curvature).",
        "Where the slip stays below the minimum of the curve, {share_predicted_below_min:.1%} are right, where it "
        "goes through the rising branch {share_predicted_past_min:.1%}; there occur "
        "{share_of_false_alarms_past_min:.1%} of the false alarms. So stiffness and belt speed do matter: right "
        "in {best_share:.0%} of cells at best and {worst_share:.0%} at worst ({worst_share_belt_speed:g} m/s, "
        "{worst_share_stiffness:g} N/m). On the curve of Figure 2 stick-slip begins at tendencies from "
        "{border_lowest:+.2f} to {border_highest:+.2f} of the drop.",
    ),
    "fig9": Figure(
        "Influence of the stiffness, modified curve",
        stiffness.figure_9,
        ("fig9",),
        "On the modified curve a stiffer spring ends stick-slip, because mu_reversal rises with stiffness.",
        "30 N/m: {regime_k30}; 100 N/m: {regime_k100}. Stick-slip ends at {transition_stiffness:.2f} N/m; "
        "mu_reversal rises from {mu_reversal_k1:.3f} (1 N/m) to {mu_reversal_k100:.3f} (100 N/m).",
        "The tendency is zero at {stiffness_of_zero_tendency:.2f} N/m already; where stick-slip ends it is "
        "{tendency_at_transition:.4f}.",
    ),
    "springs": Figure(
        "Tendency to stick-slip over the stiffness, measured",
        springs.figure_springs,
        ("rig/stiffness",),
        "Work is in progress: to vary the rigidity of the rig, and to determine friction during acceleration and "
        "deceleration of the specimen.",
        "Records of a simulated rig with {springs:.0f} springs, with noise and sensors; {told:.0f} of them tell the "
        "tendency, from {softest:+.4f} on the softest to {stiffest:+.4f}, at most {error:.4f} off that of the curve "
        "(the widest interval: {half:.4f} either way). It falls as mu_reversal rises with stiffness, and is close to "
        "zero where stick-slip ends, at {end:.1f} N/mm. Of {pairs:,.0f} random pairs on random rigs, started from "
        "sticking, Eq. (3) misses {missed:.1%} of those that stick and slip; where nothing damps and slip stays below "
        "the minimum of the curve, {right_below_bare:.1%} of its signs are right.",
        "Of the pairs that do not stick and slip it announces {false:.1%} nevertheless, so that {right:.1%} of all "
        "signs are right. {past_of_false:.1%} of these false alarms are where slip goes past the minimum (there "
        "{right_past:.1%} are right); a damping ratio above 0.05, which Eq. (3) does not know, leaves "
        "{right_below_damped:.1%} right below it. And {coexist:.1%} of the pairs that stick and slip slide steadily if "
        "they once do: one tendency cannot say which of the two motions a rig will be in.",
    ),
    "fig10": Figure(
        "Real area of contact",
        ageing.figure_10,
        ("fig11",),
        "The real area of contact grows under load, and the adhesive part of friction with it.",
        "The model has no asperities. Static friction being proportional to the area, the contact of Figure 11 is "
        "{area_ratio_1000s:.2f} times as large after 1000 s as initially.",
        "The profile is invented; the article gives no numbers.",
    ),
    "fig11": Figure(
        "Static friction over waiting time",
        ageing.figure_11,
        ("fig11",),
        "On a logarithmic scale of waiting time static friction grows linearly.",
        "Measured as on the rig, by the force at break-away, it grows by {slope_per_decade:.4f} per decade from "
        "10 s on (set: {ageing_rate:g}), {off_line_max:.1e} at most off a straight line.",
        "Below the ageing time it levels off: a straight line would diverge to minus infinity. The loading counts "
        "as hold time, too. Levels and slopes are illustrations.",
    ),
    "fig19": Figure(
        "Static friction of three greases",
        ageing.figure_19,
        ("fig19",),
        "Grease A and B have the same slope; grease C performs best, with the lowest static friction and the "
        "lowest slope.",
        "Fitted slopes per decade: A {slope_A:.4f}, B {slope_B:.4f}, C {slope_C:.4f} (set: {ageing_rate_A:g}, "
        "{ageing_rate_B:g}, {ageing_rate_C:g}); best by level after {judged_after:g} s is {best_by_level}, by "
        "slope {best_by_slope}.",
        "Greases and scatter are illustrations with the properties the article describes: it gives no numbers.",
    ),
}
