"""One step of slip in every lane: by the Runge-Kutta pair, for any law, smooth or not. `taylor.py` has that of laws
with a recurrence.

Loops over the lanes of one flat buffer, as in `lanes.py`; a loop a stage, rather than one long loop: a single chain of
six exponentials is too long for the processor to overlap two of them (measured on Zen 3: 50 ns a lane and step against
13).
"""

from ... import layout as at
from ...arithmetic import in_turn, rough_exp2, rough_log2, select, widest_vectors
from ...dense import interpolate
from ...jit import compiled
from ...linking import by_law
from .equations import jerk_in_lane, may_hide, slope_in_lane
from .friction import steepest
from .laws import passes_unseen

# Ch. Tsitouras, Runge-Kutta pairs of order 5(4) satisfying only the first column simplifying assumption, Computers &
# Mathematics with Applications 62 (2011) 770-775; first same as last. Errors: the solution less the embedded one.
NODES = (0.0, 0.161, 0.327, 0.9, 0.9800255409045097, 1.0, 1.0)
_MATRIX = (
    (),
    (0.161,),
    (-0.008480655492356989, 0.335480655492357),
    (2.8971530571054935, -6.359448489975075, 4.3622954328695815),
    (5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525),
    (5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383),
    (0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081, 2.324710524099774),
)
MATRIX = tuple((*row, *[0.0] * (len(_MATRIX) - len(row))) for row in _MATRIX)
ERROR_WEIGHTS = (
    -0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995, -0.1447110071732629, 0.5823571654525552,
    -0.45808210592918697, 0.015151515151515152,
)  # fmt: skip
ORDER = 5
ROWS = at.Rows(at.CONTACT, at.SERIES)
STAGE_W = (at.W, *ROWS.take(5), at.W_NEW)
STAGE_DW = (at.DW, *ROWS.take(5), at.DW_NEW)
STAGES = len(STAGE_W)
ERROR_Y, ERROR_W = ROWS.take(2)
# PI control (Hairer & Wanner II, IV.2): the step grows like error^-ALPHA * last_error^BETA.
BETA = 0.4 / ORDER
ALPHA = 1.0 / ORDER - 0.75 * BETA
LOG2_SAFETY = -0.152003093445  # log2(0.9)
SHRINK_MOST, GROW_MOST = 0.2, 6.0
TINIEST_ERROR2 = 1e-16
ERROR_SHARE = 0.05  # of the tolerance that one step may spend, so that a whole slip stays within it


@by_law("sf:")
def try_step(law, s, rtol):
    """A step of the size STEP in every lane; nothing is committed."""
    stages(law, s)
    control_step(law, s, rtol)
    interpolate(s)


@compiled(inline=True)
def find_stage(law, s, n):
    """Stage number n of the pair, counted from 0: y and w at its node, and w' there.

    Merged for each stage (`in_turn`): its rows and weights are constants there, so that the compiler sees straight-line
    code. y' = b - w is linear, so y needs only the stages of w: sum_j a_nj (b - w_j) = c_n b - sum_j a_nj w_j.
    """
    widest_vectors()
    node, row_w, row_dw = NODES[n], STAGE_W[n], STAGE_DW[n]
    for i in range(at.WIDTH):
        if n == 1:
            s[at.TAKEN + i] = min(s[at.STEP + i], s[at.TAU_END + i] - s[at.TAU + i])
        h, sum_w, sum_dw = s[at.TAKEN + i], MATRIX[n][0] * s[at.W + i], MATRIX[n][0] * s[at.DW + i]
        if n > 1:  # around an empty loop the compiler would take the first lane apart
            for j in range(1, n):
                sum_w += MATRIX[n][j] * s[STAGE_W[j] + i]
                sum_dw += MATRIX[n][j] * s[STAGE_DW[j] + i]
        mean_belt = s[at.B + i] + 0.5 * (node * h) * s[at.ALPHA + i]  # over the time up to the node
        s[at.Y_NEW + i] = s[at.Y + i] + h * (node * mean_belt - sum_w)  # of the last stage in the end
        s[row_w + i] = s[at.W + i] + h * sum_dw
    for i in range(at.WIDTH):  # a loop of its own: where the law looks up numbers, it is no vector code
        s[row_dw + i] = slope_in_lane(law, s, i, s[at.Y_NEW + i], s[row_w + i])


@compiled
def stages(law, s):
    """All but the first, number 0, which is the last of the step before."""
    in_turn(find_stage, law, s, 1, STAGES)


@compiled(inline=True)
def squared_error(error_y, error_w, scale_y, scale_w):
    """Squared error norm of a step: the two errors over their scales and over ERROR_SHARE; a step is good up to 1."""
    return (
        (1.0 / ERROR_SHARE**2)
        * (error_y * error_y * (scale_w * scale_w) + error_w * error_w * (scale_y * scale_y))
        / (scale_y * scale_y * (scale_w * scale_w))
    )


@compiled(inline=True)
def step_factor(error2, last_log):
    """Factor by which the next step differs from this one, and log2 of `error2` for the next call.

    A rejected or NaN step shrinks (and a NaN shrinks most).
    """
    log_error = rough_log2(max(error2, TINIEST_ERROR2))
    proportional = rough_exp2(LOG2_SAFETY - 0.5 * ALPHA * log_error + 0.5 * BETA * last_log)
    factor = min(max(proportional, SHRINK_MOST), GROW_MOST)
    factor = select(error2 <= 1.0, factor, min(factor, 0.9))
    return select(error2 < 1e300, factor, SHRINK_MOST), log_error


@compiled
def control_step(law, s, rtol):
    """Error norm, verdict and size of the next step.

    Errors are measured against the amplitude about steady sliding, so that a decaying oscillation keeps its relative
    accuracy; the slip speed also against itself and its derivative, since at break-away, where it grows from zero, its
    relative error is what delays the slip.
    """
    widest_vectors()
    for i in range(at.WIDTH):
        h, error_y, error_w = s[at.TAKEN + i], 0.0, 0.0
        for j in range(len(STAGE_W)):
            error_y -= ERROR_WEIGHTS[j] * s[STAGE_W[j] + i]
            error_w += ERROR_WEIGHTS[j] * s[STAGE_DW[j] + i]
        s[ERROR_Y + i], s[ERROR_W + i] = h * error_y, h * error_w
    for i in range(at.WIDTH):  # what the law tells
        b = s[at.B + i] + s[at.TAKEN + i] * s[at.ALPHA + i]
        s[at.JERK_NEW + i] = jerk_in_lane(law, s, i, s[at.Y_NEW + i], s[at.W_NEW + i], s[at.DW_NEW + i], b)
        rate, rise = s[at.RATE + i], s[at.RATE + i] * s[at.TAKEN + i]
        unseen = passes_unseen(
            law, rate * s[at.W + i], rate * s[at.W_NEW + i], rise * s[at.DW + i], rise * s[at.DW_NEW + i]
        )
        s[at.GOOD + i] = select(unseen, 0.0, 1.0)
    for i in range(at.WIDTH):
        floor = s[at.FLOOR + i]
        amplitude = max(abs(s[at.Y + i] - s[at.Y_STAR + i]), abs(s[at.W + i] - s[at.B + i])) + 1e-3 * floor
        scale_w = min(amplitude, abs(s[at.W_NEW + i]) + abs(s[at.DW_NEW + i]) + floor)
        error2 = squared_error(s[ERROR_Y + i], s[ERROR_W + i], rtol * amplitude, rtol * scale_w)
        factor, error_log = step_factor(error2, s[at.ERROR_LOG + i])
        # A step that ends far below w = 0 has crossed the zone at once, and the error estimate may not know.
        hides = may_hide(s, i, s[at.TAKEN + i], s[at.W_NEW + i], s[at.DW_NEW + i]) | (
            s[at.W_NEW + i] < -s[at.HIDES + i]
        )
        hides = hides | (s[at.GOOD + i] == 0.0)
        good = (error2 <= 1.0) & (not hides)
        s[at.GOOD + i] = select(good, 1.0, 0.0)
        s[at.STEP + i] = select(hides, min(0.5, factor) * s[at.TAKEN + i], factor * s[at.STEP + i])
        s[at.ERROR_LOG_NEW + i] = error_log


@by_law("sif:")
def restart(law, s, i, h):
    """Let the next step of lane i be of size h, without a memory of errors."""
    s[at.STEP + i], s[at.ERROR_LOG + i] = h, 0.0


@by_law("sici:")
def begin_stepping(law, s, i, cells, c):
    """Size of the first step of a slip, where the speed may grow as fast as the curve falls, or be thrown across it."""
    growth = steepest(law, cells, c) + cells[at.GAMMA, c]
    restart(law, s, i, min(0.05 / (1.0 + growth), s[at.HIDES + i] / abs(s[at.DW + i])))
