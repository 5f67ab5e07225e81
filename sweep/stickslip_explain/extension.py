"""What the engine is told of explanations and goals."""

from stickslip.extensions import Extension, StudyEntry

EXTENSION = Extension(
    commands={
        "From measurements to causes": {
            "explain": "stickslip_explain.command",
            "next": "stickslip_explain.command",
            "goal": "stickslip.cli.run",
        }
    },
    calls={name: f"stickslip_explain.api:{name}" for name in ("explain", "goal", "next_measurement")},
    studies={
        "goal": StudyEntry(
            "stickslip_explain.goal_study:GoalStudy", "Find the region in which a part is quiet over a range.", True
        ),
        "explain": StudyEntry("stickslip_explain.study:ExplainStudy", with_uncertain=True),
    },
    resolvers={
        "observed": "stickslip_explain.section:with_observations",
        "prior": "stickslip_explain.section:with_observations",
        "uncertain.explained": "stickslip_explain.section:with_draws",
    },
)
