"""Names of rows and codes: what a cell is, what is answered, what is stored on the way."""

# Rows of a cell; LAW is the position in LAWS. BAND_SHARE: settling band over the distance from steady sliding at which
# the slip begins. CENTRE: displacement from which the distance is taken, NaN: that of steady sliding on the curve.
(
    BELT, GAMMA, A1, A2, A3, A4, DELTA, LAW, STATIC, STOP, AGEING, AGE_TIME, CONTACT, XI0, ETA0, BAND_SHARE, CENTRE,
) = range(17)  # fmt: skip
CELL_ROWS = 17
LAWS = ("stribeck", "stribeck_delta", "rational", "cubic")

# Answers
(
    REGIME, BREAKAWAY_TIME, RESTICK_TIME, RESTICK_XI, PERIOD, STICK_TIME, XI_MAX, XI_MIN, SPEED_MAX, ACCELERATION_MAX,
    HEAT_PER_CYCLE, LOOPS_PER_CYCLE, DECREMENT, STEPS, BREAKAWAYS, CYCLE_XI_MAX, CYCLE_XI_MIN, CYCLE_SPEED_RANGE,
    CROSSINGS, SETTLING_TIME, XI_SETTLED, XI_STEADY, MU_BREAKAWAY, MU_REVERSAL, DECIDED_AT,
) = range(25)  # fmt: skip
ANSWERS = 25
UNDECIDED, STICK_SLIP, SETTLES, RINGS, STUCK = range(5)

# State of the motion, and what is remembered of it
(
    TAU, P, W, HEAT, SIGMA, STEP, TAKEN, BIRTH, STUCK_FOR, RELEASES, W_MIN, RADIUS, STIFFEST, AMPLITUDE, RATIO, QUIET,
    LOOP_TAU, LOOP_HEAT, FIRST_SLIP, RELEASE_LOAD, REVERSAL, BAND2, MIDDLE, INSIDE, ENTERED, SIDE, CROSSED, PROVEN,
) = range(28)  # fmt: skip
STATES = 28
HIGH, LOW, FASTEST, HARDEST, FORWARD, BACKWARD = range(6)  # of a record of extrema: xi, xi, w, |w'|, belt minus mass
BOOK = 6
WHOLE, CYCLE, LOOP = range(3)  # records: since the first slip or the start, since the last one, of a loop of slip
RELEASED_AT, RELEASED_P, RELEASED_STICK, RELEASED_HEAT = range(4)  # columns of the memory of break-aways
RELEASED_BOOK = 4  # first of the columns of the record of the cycle that ended there
MEMORY = 8

SLIP_AGAIN, REST, FALL, TO_FAST, TO_RISE, DONE = range(6)  # what comes next
