"""Names for every row and column of the arrays the kernels share, and the codes they return.

Kernel units: xi = k x / N (spring force over load), tau = t sqrt(k/m), speeds in N/sqrt(k m), gamma = c/sqrt(k m).
The equation of motion is xi'' + gamma xi' + xi = sigma mu(w), w = |v_rel|.

**Frame.** Slip is computed in the frame where the relative speed is positive: for sigma = -1 displacement and belt
speed change sign. There, with u = sigma xi and b = sigma b_belt,

    u' = b - w,      w' = (u + gamma u') - mu(w),      mu(w) = offset + slope w + drop shape(rate w)

and with y = u + gamma b - offset, which follows u exactly, all modes share one simple pair of equations:

    y' = b - w,      w' = y - (gamma + slope) w - drop shape(rate w)

Where the belt accelerates at a rate a, b' = a, the same pair holds for y = u + gamma b + a - offset, with
B = b + gamma a in place of b:

    y' = B - w,      w' = y - (gamma + slope) w - drop shape(rate w),      B' = a,      u'' = a - w'
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

SMALLEST_STEP = 1e-13  # what needs a smaller one cannot be integrated

# --- inputs of a cell: rows of `cells` (CELL_ROWS, n) ---------------------------------------------------------------
(
    GAMMA, BELT, A1, A2, A3, A4,
    DELTA,  # exponent of the law, where it has one
    MU_STATIC,
    MU_STOP,  # NaN: no hysteresis
    AGEING, AGEING_TIME,  # growth of static friction per e-fold of contact time
    XI_START,
    ETA_START,  # NaN: sticking
    CONTACT_START,  # time in contact before the start
    HORIZON,  # may be inf
    CONTACT_STIFFNESS, CONTACT_DAMPING,  # of bristles (`contacts/lugre.py`), over k and over sqrt(k m)
    CONTACT_DAMPING_RATE,  # one over the slip speed at which that damping has fallen to a third; 0: it does not
    ELASTIC_PART,
) = range(19)  # fmt: skip
CELL_ROWS = 19
# rows of the contact, as one that has no friction curve calls them
OWN_0, OWN_1, OWN_2, OWN_3, OWN_4, OWN_5, OWN_6 = A1, A2, A3, A4, DELTA, CONTACT_STIFFNESS, CONTACT_DAMPING

# --- the law of a table: `stations` (STATION_ROWS, STATIONS), see `contacts/stribeck/friction.py` ---------------------
# Polynomials from KNOT on, in powers of z - KNOT, are rows from POWERS on. Buckets of z are equally long in the bits of
# z + BUCKET_START, from number FIRST_BUCKET on, and tell the last station, or knot, that is not above them.
STATION, KNOT, STATION_BUCKETS, KNOT_BUCKETS, POWERS = range(5)
STATIONS, DEGREE = 512, 5
STATION_ROWS = POWERS + DEGREE + 1
BUCKET_START, BUCKET_SHIFT = 2.0**-10, 48  # 16 to an octave, from z = 0 to 4 million
FIRST_BUCKET = (1023 - 10) << 4

# --- outputs of a cell: rows of `results` (RESULT_ROWS, n), NaN until known -----------------------------------------
(
    REGIME, STATUS, BREAKAWAY_TIME, RESTICK_TIME, RESTICK_XI, PERIOD, CYCLE_STICK_TIME, XI_MAX, XI_MIN, SPEED_MAX,
    ACCELERATION_MAX, MU_REVERSAL, CYCLE_HEAT, CROSSINGS, SETTLING_TIME, STEPS, STICKS, STICK_TIME, XI_END, ETA_END,
    DAMPING_RATIO,
    MU_BREAKAWAY,  # load at the last break-away; static friction before the first
    XI_SETTLED,  # where a motion that settles does so
    CYCLE_XI_MAX, CYCLE_XI_MIN,  # of the attractor itself, without the transient
    CYCLE_SPEED_RANGE,  # largest minus least velocity on the attractor
    RESTICK_MARGIN,  # by how much the slip after break-away misses standstill; below 0 where it sticks again
    CLOSENESS,  # smallest margin that the verdict hangs on, over the amplitude (`observers/verdict.py`)
    # of errors, more than the tolerance says: up to the first re-stick of a motion that began in slip; in the friction
    # work of a cycle, the energy that the spring exchanges over it
    ERROR_GROWTH,
) = range(29)  # fmt: skip
RESULT_ROWS = 29
SLOWEST_SLIP = MU_REVERSAL  # of the attractor, where there is no hysteresis

# --- what a cell means (REGIME) and how its integration ended (STATUS) ----------------------------------------------
NOT_COMPUTED, STICK_SLIP, DAMPED, CREEP, SUSTAINED, STUCK, UNRESOLVED, FAILED = range(8)
(
    NOT_RUN, CYCLE_CLOSED, SETTLED, SLIP_CYCLE, NEVER_BREAKS_AWAY, HORIZON_REACHED, STEP_LIMIT, STEP_UNDERFLOW,
    NOT_FINITE, NEUTRAL_RINGING, TWO_WAY_SLIP_CYCLE, FALL_HOLD_CYCLE, SETTLING_OBSERVED, SETTLING_CERTAIN,
    TOO_SLOW_TO_TELL, NEGATIVE_FRICTION, HYSTERESIS_UNDEFINED, IRREGULAR,
) = range(18)  # fmt: skip

# --- how far a cell is followed: until its regime is known, until its other metrics are too, to its horizon -----------
UNTIL_REGIME, UNTIL_METRICS, UNTIL_HORIZON = range(3)

# --- contact modes --------------------------------------------------------------------------------------------------
STICK, RISE, FAST, FALL, HOLD = range(5)  # the plain curve has STICK and RISE only

# --- hot state: rows of `lanes`, one flat buffer; number r of lane i is lanes[r + i], r being a multiple of WIDTH ---
WIDTH = 32
(
    Y,  # u + gamma b - offset
    W,  # slip speed
    DW,  # its derivative
    JERK,  # its second derivative
    WEAK,  # a number of the contact: drop shape(rate w), the weakening part of friction; an inner state
    SIDE_LAST,  # side of the equilibrium of the last extremum of u outside the band: +1, -1, 0 none yet
    CROSSED,  # crossings of the equilibrium so far
    LOOP_COUNT,  # maxima of u since the reference one (`observers/cycles.py`), -1 without one
    ERROR_LOG,  # log2 of the squared error norm of the last accepted step (PI control)
    TAU,
    HEAT,  # friction work so far
    STATE_NUMBERS,
) = range(0, 12 * WIDTH, WIDTH)
AFTER = STATE_NUMBERS  # first of as many rows: the state after the decision to commit a step or not
(
    # the state at the end of the step being tried
    Y_NEW, W_NEW, DW_NEW, JERK_NEW, WEAK_NEW, SIDE_LAST_NEW, CROSSED_NEW, LOOP_COUNT_NEW, ERROR_LOG_NEW,
    STEP,  # the step to try next (Runge-Kutta); the most it may be (Taylor)
    TRIED,  # steps tried so far
    PAUSE,  # steps after which the lane is looked at in any case (`observers.after_pause`)
    # law and guards of the present mode
    B,  # belt speed in the frame; plus gamma times its acceleration, at the start of the step, where there is one
    ALPHA,  # acceleration of the belt in the frame; 0 in maps
    G,  # gamma
    OFFSET, SLOPE, DROP, RATE, EXPONENT,
    Y_STAR,  # y of steady sliding
    LEVEL,  # the mode ends where w crosses this level ...
    SIDE,  # ... from below (+1) or from above (-1)
    TURN,  # 1 where a zero of w' ends the mode as well
    # what the observer of regimes watches for
    RADIUS2,  # squared radius of the disc about steady sliding in which settling may be proven
    BAND2,  # square of the settling band, 0 once the regime is known
    QUIET_BELOW,  # extrema of u may pass without a look as long as LOOP_COUNT is below this
    MARK,  # 1 while extrema are recorded
    W_TOP,  # largest w recorded so far; peaks that stay below are not looked for (-inf: look at all)
    DW_TOP,  # largest |w'| recorded so far
    Y_HIGH, Y_LOW,  # y at the largest and the least u recorded so far; extrema of u between them need no look
    W_LEAST,  # margin of the slip under way, see `observers/verdict.py`; troughs of w above it are not looked at
    GAIN, GAIN_TOP,  # log of what errors have grown by in this slip (`observers/verdict.py`), and its largest so far
    # what steps must know
    FLOOR,  # slip speed below which errors are absolute
    FAR, HIDES,  # slip speed from which friction no longer weakens, and how deep w may dip in a step (`may_hide`)
    TAU_END,  # end of the segment of the drive
    # the step being tried
    TAKEN,  # its size
    WORK,
    GOOD,  # 1 where the error is within tolerance
    LOOK,  # 1 where the observer wants to look at it before it is committed
    FLAG,  # what becomes of it: NOTHING_MET, LOOK_FIRST or HALTED
    # what is looked for inside it in all lanes at once
    TURNING,  # 1 where the observer wants the time at which w passes B
    CROSSES,  # 1 where w passes CROSS_LEVEL; after `crossings.find_crossings`, only where that has found it
    CROSS_LEVEL, CROSS_TIME, CROSS_RISE, CROSS_FALLEN,  # when; by how much y rises till then; double integral of w
    SOUGHT,  # OF_SPEED or OF_SLOPE: an extremum of w or of w' (`observers/tops.py`); 0 where none is sought or found
    TOP, TOP_TIME,  # its value, and when; the time is NaN where it is known for the value only
    GUESS, GUESS_W, GUESS_DW, GUESS_A, GUESS_B,  # a time close to what is sought, and the series about it
    ALLOWED,  # error of w that a Taylor step may make
    BY_SERIES,  # 1 in lanes whose steps are those of series (`contacts/explicit.py`)
    CONTACT,  # first of CONTACT_ROWS rows of what a contact must know beside (`Rows`)
) = range(2 * STATE_NUMBERS, 2 * STATE_NUMBERS + 61 * WIDTH, WIDTH)  # fmt: skip
CONTACT_ROWS = 25
# first of ORDER + 1 rows: coefficients of w over the step, in powers of the time since its start
SERIES = CONTACT + CONTACT_ROWS * WIDTH
NOTHING_MET, LOOK_FIRST, HALTED = 0.0, 1.0, 2.0  # committed or rejected; good, but to be looked at; no step possible
OF_SPEED, OF_SLOPE = 1.0, 2.0  # codes of SOUGHT
ORDER = 14  # of the Taylor step
SERIES_DW = SERIES + (ORDER + 1) * WIDTH  # first of ORDER rows: the coefficients of w'
SERIES_WEAK = SERIES_DW + ORDER * WIDTH  # the same of the weakening part of friction
SERIES_FACTOR = SERIES_WEAK + ORDER * WIDTH  # the same of what some recurrences keep beside (`recurrences.py`)
SERIES_STATE = SERIES_FACTOR + ORDER * WIDTH  # first of ORDER + 1 rows, of an inner state: `contacts/bristles.py`
SERIES_SHARE = SERIES_STATE + (ORDER + 1) * WIDTH  # first of ORDER rows: the same over what it may be

# --- slow state: further rows of `lanes`, which only the scalar code uses -------------------------------------------
SLOW = SERIES_SHARE + ORDER * WIDTH
(
    CELL,  # index of the cell in the block, -1: the lane is idle
    MODE,
    SIGMA,
    W_MIN,  # where the falling branch of the hysteretic curve ends; 0 where there is no hysteresis
    AGE,  # time in contact
    SEGMENT,  # number of the segment of the drive under way
    SAMPLE,  # the next one to be taken (`observers/signals.py`)
    # records of the observers of regimes
    XI_STAR,  # steady sliding on the curve, true frame
    AMPLITUDE,  # distance from steady sliding in the plane (u, u') where the slip began
    ENTERED,  # time at which the motion last came into the settling band
    SLIP_START,  # time of the first slip, NaN before
    CYCLE_START,  # time of the break-away that starts the cycle, NaN before
    XI_HIGH, XI_LOW,
    V_HIGH, V_LOW,  # largest and least relative speed, true frame
    FASTEST, SLOWEST,  # slip speeds of the whole motion, up to the last reset of these
    CLOSEST,  # see CLOSENESS; inf before
    STORED,  # 1 once extremes before these were put into the results
    MU_TURN,  # friction coefficient at the first reversal
    LOOP_TAU, LOOP_HEAT, LOOP_STEPS,  # at the reference maximum of u (`observers/cycles.py`): time, work, steps
    LOOP_STILL,  # looks in a row that showed nothing above the noise
    DECIDED,  # 1 once the regime is known (a run to the horizon goes on)
    DECIDED_BY,  # the status then
    SLIP_LEAST,  # W_LEAST of this slip before its last maximum of u; inf where W_LEAST has it all
    # what `observers/recurrence.py` and `contacts/implicit.py` must know of steady sliding
    ATTRACTS,  # 1 where it attracts small motions
    FIRMNESS,  # by what share they grow or shrink in a loop, about; at most 1
    EVEN,  # slip speed above which errors of w are as large all over a loop, and below which friction shrinks them
    LONGEST,  # step; of implicit ones near steady sliding, so that they do not damp motions that grow
    # from here on of `observers/regime.py` and its parts; that of recurrence takes its own from there, too (RECURRENCE)
    STABLE_FROM, STABLE_TO,  # slip speeds, about that of the belt, at which steady sliding on the curve is stable
    BAND,  # settling band where the slip began
    STICK_COUNT, STICK_SUM,
    HEAT_START,  # friction work up to the start of the cycle
    PEAK, PEAK_BEFORE,  # height above b of the last peak of w, and of the one before
    TROUGH_TIME,  # time of the last trough of w on the line of a hysteretic curve
    TURN_LAST, TURN_BEFORE,  # xi at the last extremum looked at, and at the one before
    # the return map of slip, from one maximum of u to the next (`observers/cycles.py`)
    LOOP_XI, LOOP_GAIN,  # at the reference maximum of u: xi, GAIN
    LOOP_CHANGE,  # relative change of xi a loop at the last look; inf before
    LOOP_MOVED,  # 1 once a change above the noise was seen
    CONFIRMING,  # 1 while a suspected cycle is gone through once more, every extremum being looked at
    PUSH_STATE,  # whether the motion was pushed off a cycle that shows no change (`observers/cycles.py`)
    RETURNED,  # loops after which the state first was that of the reference again; 0 not yet
    HELD,  # 1 if the motion was on the line of a hysteretic curve since the reference
    # the return map of stick-slip under ageing, from one break-away to the next (`observers/cycles.py`)
    RELEASE, RELEASE_CHANGE,  # load at the last break-away, and its change from the one before
    PERIOD_BEFORE, SPEED_BEFORE, HEAT_BEFORE,  # of the last cycle: period, largest slip speed, friction work
    LEAPT,  # how the motion was put where it is known to come (`observers/weak.py`); 0: it was not
    # the amplitude map (`observers/amplitudes.py`)
    INWARD,  # 1: the last loop ended further in than it began, without rest
    MAP_STATE,
    MAP_REST,  # time at which w last came to zero, or was on a line
    MAP_TAU, MAP_FROM,  # time and amplitude of the turn it begins at
    MAP_AT,  # amplitude at which the half loop under way began
    MAP_TO, MAP_TIME,  # amplitude and duration at its end; 0 before
    MAP_NODES,  # nodes so far
    MAP_STEPS,  # steps tried before
    MAP_OFF,  # by how much the last node differed from what those before foretold
    MULTIPLIER,  # of a deviation from the cycle, the share that a loop leaves; 0 where no map told
    MAP_ASIDE,  # first of MAP_ROWS_ASIDE rows: what measuring must not touch
) = range(SLOW, SLOW + 70 * WIDTH, WIDTH)  # fmt: skip
MAP_ROWS_ASIDE, MAP_MOST_NODES = 11, 24
MAP_A = MAP_ASIDE + MAP_ROWS_ASIDE * WIDTH  # first of MAP_MOST_NODES rows: amplitudes of the nodes
MAP_R = MAP_A + MAP_MOST_NODES * WIDTH  # divided differences of the ratio of amplitudes
MAP_T = MAP_R + MAP_MOST_NODES * WIDTH  # the same of the duration

# --- lanes brought together: the same rows once more (`roots.gather`) -----------------------------------------------
GATHERED = MAP_T + MAP_MOST_NODES * WIDTH  # lane GATHERED + k: a copy of what the k-th of them has
LANE_NUMBERS = 2 * GATHERED


class Rows:
    """Rows of `lanes` for files that work together: each takes its own, which no other of them gets."""

    def __init__(self, first: int, end: int):
        self._free, self._end = first, end

    def take(self, number: int) -> tuple[int, ...]:
        """Return so many rows, one after the other. Raises ValueError where so many are not left."""
        rows = range(self._free, self._free + number * WIDTH, WIDTH)
        if rows.stop > self._end:
            raise ValueError(f"{number} rows of lanes, of {(self._end - self._free) // WIDTH} that are left")
        self._free = rows.stop
        return tuple(rows)

    def beside(self) -> Rows:
        """What is left, once more: for each of several files that are never at work together."""
        return Rows(self._free, self._end)


RECURRENCE = Rows(STABLE_FROM, GATHERED)  # of `observers/recurrence.py` and its parts

# --- belts that follow segments (`drive.py`): columns of their table; true frame ------------------------------------
SEGMENT_TIME, SEGMENT_BELT, SEGMENT_ALPHA = range(3)  # duration > 0, belt speed at the start, its acceleration
SEGMENT_COLUMNS = 3

# --- signals of a motion (`observers/signals.py`) -------------------------------------------------------------------
# Columns of `runs` (n, RUN_COLUMNS): where a cell puts its samples; LAST_SAMPLE is not included. The first is taken at
# SAMPLE_START, the others SAMPLE_STEP apart.
FIRST_SAMPLE, LAST_SAMPLE, SAMPLE_START, SAMPLE_STEP = range(4)
RUN_COLUMNS = 4

# Rows of `results` (RIG_ROWS, n), NaN until known
(
    RIG_STATUS,  # HORIZON_REACHED: to the end of the drive
    RIG_STEPS, RIG_STICKS,
    RIG_SLIPS,  # break-aways
    RIG_STICK_TIME,
    RIG_BREAKAWAY_TIME, RIG_BREAKAWAY_LOAD,  # the first one
    RIG_ACCELERATION_MAX, RIG_DRIVE_WORK, RIG_FRICTION_HEAT, RIG_DAMPER_HEAT, RIG_XI_END, RIG_ETA_END,
    RIG_STEPS_TAKEN,  # those that were good, of RIG_STEPS tried
) = range(14)  # fmt: skip
RIG_ROWS = 14
RIG_SUMS = (
    RIG_STEPS, RIG_STEPS_TAKEN, RIG_STICKS, RIG_SLIPS, RIG_STICK_TIME, RIG_ACCELERATION_MAX, RIG_DRIVE_WORK,
    RIG_FRICTION_HEAT, RIG_DAMPER_HEAT,
)  # fmt: skip

# Rows of `signals` (SIGNAL_ROWS, any): true frame, SIGNAL_FRICTION in units of the load
SIGNAL_XI, SIGNAL_ETA, SIGNAL_FRICTION, SIGNAL_MODE = range(4)
SIGNAL_ROWS = 4

# Columns of `stops` (capacity, STOP_COLUMNS); row 0 is a header whose first number counts the stick phases. Without
# rows it is switched off.
STOP_START, STOP_END, STOP_LOAD = range(3)  # of a stick phase; the load at its end
STOP_COLUMNS = 3


# --- the bundle that every function of the kernels gets ---------------------------------------------------------------


RUNNING, DONE = False, True  # what functions of a machine return: the lane goes on, or its cell is finished


class Machine(NamedTuple):
    """A contact under a law, on a drive, seen by an observer. The types of these four are the specialisation.

    contact : tag of a contact, see `contacts`. law : tag of its law of friction.
    drive : `drive.SteadyBelt` or `drive.Segments`.
    observer : of the files in `observers`, with what it fills.
    s : the lanes, rows of `layout.py`. cells : float64 (CELL_ROWS, n), kernel units, C-contiguous.
    rtol : tolerance of a step. max_steps : trial steps a cell may take.
    """

    contact: Any
    law: Any
    drive: Any
    observer: Any
    s: Any
    cells: Any
    rtol: float
    max_steps: float


# --- results of cells nobody has computed yet -------------------------------------------------------------------------


NO_STATIONS = np.zeros((STATION_ROWS, STATIONS))  # of a law that is no table
NO_STOPS = np.zeros((0, STOP_COLUMNS))  # for `run_signals`: no table of stick phases


def new_regimes(n: int) -> NDArray[np.float64]:
    """Results (RESULT_ROWS, n) for the observer of regimes: NaN, no steps, and the codes for "not computed"."""
    results = np.full((RESULT_ROWS, n), np.nan)
    results[REGIME], results[STATUS], results[STEPS] = NOT_COMPUTED, NOT_RUN, 0.0
    return results


def new_signals(n: int) -> NDArray[np.float64]:
    """Results (RIG_ROWS, n) for the observer of signals: NaN, and the code for "not computed"."""
    results = np.full((RIG_ROWS, n), np.nan)
    results[RIG_STATUS] = NOT_RUN
    return results
