"""Names for every row and column of the arrays the kernels share, and the codes they return.

Kernel units: xi = k x / N (spring force over load), tau = t sqrt(k/m), speeds in N/sqrt(k m), gamma = c/sqrt(k m).
The equation of motion is xi'' + gamma xi' + xi = sigma mu(w), w = |v_rel|.

**Frame.** Slip is computed in the frame where the relative speed is positive: for sigma = -1 displacement and belt
speed change sign. There, with u = sigma xi and b = sigma b_belt,

    u' = b - w,      w' = (u + gamma u') - mu(w),      mu(w) = offset + slope w + drop shape(rate w)

and with y = u + gamma b - offset, which follows u exactly, all modes share one lean pair of equations:

    y' = b - w,      w' = y - (gamma + slope) w - drop shape(rate w)

Where the belt accelerates at a rate a, b' = a (`rig/`), the same pair holds for y = u + gamma b + a - offset, with
B = b + gamma a in place of b:

    y' = B - w,      w' = y - (gamma + slope) w - drop shape(rate w),      B' = a,      u'' = a - w'
"""

SMALLEST_STEP = 1e-13  # what needs a smaller one cannot be integrated

# --- inputs of a cell: rows of `cells` (CELL_ROWS, n) ---------------------------------------------------------------
(
    GAMMA,
    BELT,
    A1,
    A2,
    A3,
    A4,
    DELTA,  # exponent of the law, where it has one
    MU_STATIC,
    MU_STOP,  # NaN: no hysteresis
    AGEING,  # growth of static friction per e-fold of contact time
    AGEING_TIME,
    XI_START,
    ETA_START,  # NaN: sticking
    CONTACT_START,  # time in contact before the start
    HORIZON,  # may be inf
) = range(15)
CELL_ROWS = 15

# --- outputs of a cell: rows of `results` (RESULT_ROWS, n), NaN until known -----------------------------------------
(
    REGIME,
    STATUS,
    BREAKAWAY_TIME,
    RESTICK_TIME,
    RESTICK_XI,
    PERIOD,
    CYCLE_STICK_TIME,
    XI_MAX,
    XI_MIN,
    SPEED_MAX,
    ACCELERATION_MAX,
    MU_REVERSAL,
    CYCLE_HEAT,
    CROSSINGS,
    SETTLING_TIME,
    STEPS,
    STICKS,
    STICK_TIME,
    XI_END,
    ETA_END,
    DAMPING_RATIO,
    MU_BREAKAWAY,  # load at the last break-away; static friction before the first
    XI_SETTLED,  # where a motion that settles does so
    CYCLE_XI_MAX,  # of the attractor itself, without the way to it
    CYCLE_XI_MIN,
    CYCLE_SPEED_RANGE,  # largest less least velocity on the attractor
) = range(26)
RESULT_ROWS = 26

# --- what a cell means (REGIME) and how its integration ended (STATUS) ----------------------------------------------
NOT_COMPUTED, STICK_SLIP, DAMPED, CREEP, SUSTAINED, STUCK, UNRESOLVED, FAILED = range(8)
(
    NOT_RUN,
    CYCLE_CLOSED,
    SETTLED,
    SLIP_CYCLE,
    NEVER_BREAKS_AWAY,
    HORIZON_REACHED,
    STEP_LIMIT,
    STEP_UNDERFLOW,
    NOT_FINITE,
    NEUTRAL_RINGING,
    TWO_WAY_SLIP_CYCLE,
    FALL_HOLD_CYCLE,
    SETTLING_OBSERVED,
    SETTLING_CERTAIN,
    TOO_SLOW_TO_TELL,
    NEGATIVE_FRICTION,
) = range(16)

# --- contact modes --------------------------------------------------------------------------------------------------
STICK, RISE, FAST, FALL, HOLD = range(5)  # the plain curve knows STICK and RISE only

# --- hot state: rows of `lanes`, one flat buffer; number r of lane i is lanes[r + i], r being a multiple of WIDTH ---
WIDTH = 32
(
    Y,  # u + gamma b - offset
    W,  # slip speed
    DW,  # its derivative
    JERK,  # its second derivative
    WEAK,  # drop shape(rate w), the weakening part of friction (kept by the Taylor step only)
    TAU,
    HEAT,  # friction work so far
    QUIET,  # extrema of u that may still pass without a look
    ERROR_LOG,  # log2 of the squared error norm of the last accepted step (PI control)
    # the same nine after the step, copied back when it is committed
    Y_NEXT,
    W_NEXT,
    DW_NEXT,
    JERK_NEXT,
    WEAK_NEXT,
    TAU_NEXT,
    HEAT_NEXT,
    QUIET_NEXT,
    ERROR_LOG_NEXT,
    STEP,  # the step to try next (Runge-Kutta); the most it may be (Taylor)
    TRIED,  # steps tried so far
    # law and guards of the present mode
    B,  # belt speed in the frame; plus gamma times its acceleration, at the start of the step, where there is one
    ALPHA,  # acceleration of the belt in the frame; 0 in maps
    G,  # gamma
    OFFSET,
    SLOPE,
    DROP,
    RATE,
    EXPONENT,
    Y_STAR,  # y of steady sliding
    LEVEL,  # the mode ends where w crosses this level ...
    SIDE,  # ... from below (+1) or from above (-1)
    TURN,  # 1 where a zero of w' ends the mode as well
    RADIUS2,  # squared radius of the disc about steady sliding in which settling may be proven
    BAND2,  # square of the settling band, 0 once the regime is known
    FLOOR,  # slip speed below which errors are absolute
    FAR,  # slip speed from which on friction no longer weakens, and how deep w may dip between the ends of a step:
    HIDES,  # `steep.py`
    MARK,  # 1 while extrema are recorded
    W_TOP,  # largest w recorded so far; peaks that stay below are not looked at (-inf: look at all)
    DW_TOP,  # the same for |w'|
    Y_HIGH,  # y at the largest and the least u recorded so far; extrema of u between them need no look
    Y_LOW,
    TAU_END,
    # the step being tried: size, end, verdict
    TAKEN,
    Y_NEW,
    W_NEW,
    DW_NEW,
    JERK_NEW,
    WEAK_NEW,
    WORK,
    GOOD,  # 1 where the error is within tolerance
    EXTREMUM,  # 1 where the step holds an extremum to be looked at
    TURNED_QUIETLY,  # 1 where u turns in it without need of a look
    FLAG,  # 0: committed or rejected; 1: good, but the scalar code must look first; 2: no step can be taken
    ALLOWED,  # error of w that a Taylor step may make
    # inside a Runge-Kutta step: stages and errors
    W_2,
    W_3,
    W_4,
    W_5,
    W_6,
    K_2,
    K_3,
    K_4,
    K_5,
    K_6,
    ERROR_Y,
    ERROR_W,
    SERIES,  # first of ORDER + 1 rows: coefficients of w over the step, in powers of the time since its start
) = range(0, 68 * WIDTH, WIDTH)
ORDER = 14  # of the Taylor step
SERIES_DW = SERIES + (ORDER + 1) * WIDTH  # first of ORDER rows: the coefficients of w'
SERIES_WEAK = SERIES_DW + ORDER * WIDTH  # the same of the weakening part of friction
STATE_NUMBERS = Y_NEXT - Y  # how far a state is from its successor

# --- slow state: further rows of `lanes`, which only the scalar code uses -------------------------------------------
SLOW = SERIES_WEAK + ORDER * WIDTH
(
    CELL,  # index of the cell in the block, -1: the lane is idle
    MODE,
    SIGMA,
    W_MIN,  # minimum of the hysteretic curve; 0 where there is no hysteresis
    STABLE_FROM,  # steady sliding on the curve is stable for all slip speeds from here about that of the belt
    STABLE_TO,  # to here
    XI_STAR,  # steady sliding on the curve, true frame
    BAND,  # settling band: radius about steady sliding in the plane (u, u')
    ENTERED,  # time at which the motion last came into the settling band
    SLIP_START,  # time of the first slip, NaN before
    CYCLE_START,  # time of the break-away that starts the cycle, NaN before
    STICK_COUNT,
    STICK_SUM,
    HEAT_START,  # friction work up to the start of the cycle
    SIDE_LAST,  # side of the equilibrium of the last extremum outside the band: +1, -1, 0 none yet
    CROSSED,  # crossings of the equilibrium so far
    QUIET_GIVEN,  # what QUIET was when it was last set
    XI_HIGH,
    XI_LOW,
    V_HIGH,  # largest and least relative speed, true frame
    V_LOW,
    DW_HIGH,  # largest |w'|
    PEAK,  # height above b of the last peak of w
    PEAK_BEFORE,
    TROUGH_TIME,  # time of the last trough of w on the line of a hysteretic curve
    STORED,  # 1 once extremes before these were put into the results
    MU_TURN,  # friction coefficient at the first reversal
    TURN_LAST,  # xi at the last extremum looked at, and at the one before
    TURN_BEFORE,
    # the return map of slip, from one maximum of u to the next (`loops.py`)
    LOOP_COUNT,  # maxima of u since the reference one, -1 without one; xi, time and work there:
    LOOP_XI,
    LOOP_TAU,
    LOOP_HEAT,
    LOOP_STEPS,  # steps tried up to there
    LOOP_CHANGE,  # relative change of xi a loop at the last look; inf before
    LOOP_MOVED,  # 1 once a change above the noise was seen
    LOOP_STILL,  # looks in a row that showed nothing above the noise
    CONFIRMING,  # 1 while a suspected cycle is gone through once more, every extremum being looked at
    RETURNED,  # loops after which the state first was that of the reference again; 0 not yet
    HELD,  # 1 if the motion was on the line of a hysteretic curve since the reference
    # the return map of stick-slip under ageing, from one break-away to the next (`rest.py`)
    RELEASE,  # load at the last break-away, and its change from the one before
    RELEASE_CHANGE,
    PERIOD_BEFORE,  # of the last cycle: period, largest slip speed, friction work
    SPEED_BEFORE,
    HEAT_BEFORE,
    DECIDED,  # 1 once the regime is known (a run to the horizon goes on)
    DECIDED_BY,  # the status then
) = range(SLOW, SLOW + 47 * WIDTH, WIDTH)
LANE_NUMBERS = SLOW + 47 * WIDTH

# --- trace log: rows of `log` (capacity, LOG_COLUMNS); row 0 is a header whose first number counts the segments met ---
# The others hold one segment each, from LOG_TAU to the LOG_TAU of the next. A log without rows is switched off.
LOG_TAU, LOG_MODE, LOG_SIGMA, LOG_U, LOG_W, LOG_DW, LOG_OFFSET, LOG_SLOPE, LOG_DROP = range(9)
LOG_COLUMNS = 9

# --- samples of a trajectory: rows of `samples` (SAMPLE_ROWS, n); signs as in the true frame ------------------------
SAMPLE_XI, SAMPLE_RELATIVE, SAMPLE_ACCELERATION, SAMPLE_FRICTION, SAMPLE_MODE = range(5)
SAMPLE_ROWS = 5

# --- how to integrate: numbers of `control` -------------------------------------------------------------------------
RTOL, MAX_STEPS, EARLY_STOP = range(3)

# --- rigs: a specimen on a belt that follows a drive, `rig/` --------------------------------------------------------
# Columns of `segments` (any, SEGMENT_COLUMNS), in which the drive keeps its acceleration; true frame
SEGMENT_TIME, SEGMENT_BELT, SEGMENT_ALPHA = range(3)  # duration > 0, belt speed at the start, its acceleration
SEGMENT_COLUMNS = 3

# Columns of `runs` (n, RUN_COLUMNS): where a rig finds its drive in `segments`, and puts its samples in `signals`; the
# last ones are not included. The first sample is taken at SAMPLE_START, the others SAMPLE_STEP apart.
FIRST_SEGMENT, LAST_SEGMENT, FIRST_SAMPLE, LAST_SAMPLE, SAMPLE_START, SAMPLE_STEP = range(6)
RUN_COLUMNS = 6

# Rows of `results` (RIG_ROWS, n), NaN until known
(
    RIG_STATUS,  # HORIZON_REACHED: to the end of the drive
    RIG_STEPS,
    RIG_STICKS,
    RIG_SLIPS,  # breaks-away
    RIG_STICK_TIME,
    RIG_BREAKAWAY_TIME,  # the first one, and the load there
    RIG_BREAKAWAY_LOAD,
    RIG_ACCELERATION_MAX,
    RIG_DRIVE_WORK,
    RIG_FRICTION_HEAT,
    RIG_DAMPER_HEAT,
    RIG_XI_END,
    RIG_ETA_END,
) = range(13)
RIG_ROWS = 13
RIG_SUMS = (
    RIG_STEPS, RIG_STICKS, RIG_SLIPS, RIG_STICK_TIME, RIG_ACCELERATION_MAX, RIG_DRIVE_WORK, RIG_FRICTION_HEAT,
    RIG_DAMPER_HEAT,
)  # fmt: skip

# Rows of `signals` (SIGNAL_ROWS, any): true frame, SIGNAL_FRICTION in units of the load
SIGNAL_XI, SIGNAL_ETA, SIGNAL_FRICTION, SIGNAL_MODE = range(4)
SIGNAL_ROWS = 4

# Columns of `stops` (capacity, STOP_COLUMNS); row 0 is a header whose first number counts the stick phases. Without
# rows it is switched off.
STOP_START, STOP_END, STOP_LOAD = range(3)  # of a stick phase; the load at its end
STOP_COLUMNS = 3

# The slow state of a rig: CELL, MODE, SIGMA and W_MIN as above, then (segment under way, next sample to be taken, time
# in contact)
RIG_SEGMENT, RIG_SAMPLE, RIG_AGE = range(W_MIN + WIDTH, W_MIN + 4 * WIDTH, WIDTH)
