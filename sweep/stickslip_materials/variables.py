"""The variables of materials compared."""

from stickslip.vocabulary.models import CURVE, FITTED
from stickslip.vocabulary.parameter import Variable, table
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import VARIABLES

MATERIAL_VARIABLES: dict[str, Variable] = table(
    Variable("rank", "1", "rank of the material, 1 for the one that is quiet from the lowest speed on",
             comment="NaN: not determined, see quiet_state and fit_quality"),
    Variable("quiet_above", "m s-1", "belt speed above which the pair is quiet",
             comment="no stick-slip and no other lasting vibration that began in stick; see quiet_state"),
    Variable("quiet_state", "1", "what the speed above which the pair is quiet is"),
    Variable("quiet_above_low", "m s-1", "lower end of the confidence interval of quiet_above",
             comment="0: no vibration at any speed searched; NaN: the points do not determine it"),
    Variable("quiet_above_high", "m s-1", "upper end of the confidence interval of quiet_above",
             comment="inf: vibration up to the fastest speed searched; NaN: the points do not determine it"),
    Variable("better_than_next", "1", "probability of being quiet from a lower speed on than the next in rank",
             comment="as far as the scatter of the points goes"),
    Variable("draws_used", "1", "curves drawn whose verdict is known"),
    Variable("draws_falling", "1", f"share of the curves drawn that fall for ever ({CURVE.slope} < 0)",
             comment="they vibrate at any speed unless the damper outweighs the fall"),
    Variable("margin", "1", "belt speed over quiet_above",
             comment="above 1: quiet; of a range of belt speeds that of its slowest"),
    Variable("worst_speed", "m s-1", "belt speed of a range at which the vibration is largest",
             comment="its slowest where it is quiet throughout"),
    Variable("quiet_probability", "1", "probability of being quiet at the belt speed and above",
             comment="as far as the scatter of the points goes; draws without a verdict do not count as quiet"),
    Variable("undecided_probability", "1", "share of the curves drawn without a verdict at the belt speed"),
    *(v for v in VARIABLES.values() if v.name in ("regime", "frequency", "stick_fraction", "tendency")),
    *(Variable(name, SEARCHABLE[name].units, SEARCHABLE[name].long_name) for name in (*FITTED, "mu_stop")),
    Variable("residual_rms", "1", "residual of the fit, root mean square"),
    Variable("points", "1", "measured points"),
    Variable("slowest_point", "m s-1", "slowest measured speed"),
    Variable("fastest_point", "m s-1", "fastest measured speed"),
    Variable("fit_good", "1", "whether the points determine the curve"),
    Variable("friction", "1", "friction coefficient of the fitted curve"),
    Variable("friction_low", "1", "lower end of the 95 % band of the fitted curve"),
    Variable("friction_high", "1", "upper end of the 95 % band of the fitted curve"),
    Variable("point_friction", "1", "measured friction coefficient"),
    Variable("point_sigma", "1", "standard deviation of the measured friction coefficient"),
)  # fmt: skip
