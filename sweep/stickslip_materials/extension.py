"""What the engine is told of measured friction."""

from stickslip.extensions import Extension

_FITS = "stickslip_materials.resolve:with_fits"

EXTENSION = Extension(
    commands={
        "Friction curves and materials": {
            "fit": "stickslip_materials.commands",
            "compare": "stickslip_materials.commands",
            "points": "stickslip_materials.commands",
        }
    },
    calls={
        "fit": "stickslip_materials.fit",
        "compare": "stickslip_materials.compare.compare:compare",
        **{f"plots.{name}": f"stickslip_materials.plots:{name}" for name in ("plot_fits", "plot_materials")},
    },
    resolvers={
        "friction.table": "stickslip_materials.resolve:with_points",
        "friction.fit": _FITS, "uncertain.fit": _FITS, "axes.*.zip.fit": _FITS,
    },
    marks={"quiet_above": "comparison"},
    results={"comparison": "stickslip_materials.compare.result:Comparison"},
)  # fmt: skip
