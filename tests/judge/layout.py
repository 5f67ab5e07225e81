"""Names of rows and codes: what a cell is, what is answered, what is remembered on the way."""

# Rows of a cell; LAW is the position in LAWS
BELT, GAMMA, A1, A2, A3, A4, DELTA, LAW, STATIC, STOP, AGEING, AGE_TIME, CONTACT, XI0, ETA0 = range(15)
CELL_ROWS = 15
LAWS = ("stribeck", "stribeck_delta", "rational", "cubic")

# Answers
(
    REGIME, BREAKAWAY_TIME, RESTICK_TIME, RESTICK_XI, PERIOD, STICK_TIME, XI_MAX, XI_MIN, SPEED_MAX, ACCELERATION_MAX,
    HEAT_PER_CYCLE, LOOPS_PER_CYCLE, DECREMENT, STEPS, BREAKAWAYS,
) = range(15)  # fmt: skip
ANSWERS = 15
UNDECIDED, STICK_SLIP, SETTLES, RINGS, STUCK = range(5)

# State of the motion, and what is remembered of it
(
    TAU, P, W, HEAT, SIGMA, STEP, TAKEN, BIRTH, STUCK_FOR, RELEASES, W_MIN, RADIUS, STIFFEST, AMPLITUDE, RATIO, QUIET,
    LOOP_TAU, LOOP_HEAT,
) = range(18)  # fmt: skip
STATES = 18
HIGH, LOW, FASTEST, HARDEST = range(4)  # of a book of extrema: xi, xi, w, |w'|
WHOLE, CYCLE, LOOP = range(3)  # books: since the first break-away or the start, since the last one, of a loop of slip
RELEASED_AT, RELEASED_P, RELEASED_STICK, RELEASED_HEAT = range(4)  # columns of the memory of break-aways
MEMORY = 8

SLIP_AGAIN, REST, FALL, TO_FAST, TO_RISE, DONE = range(6)  # what comes next
