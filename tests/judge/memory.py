"""What a cell of a contact with memory does, by collocation: cells in kernel units in, answers out.

Nothing is taken from the kernels but the definitions of what is asked: the band, the loops, the least slip speed.
"""

from math import inf, nan

import numpy as np

from .book import answers
from .jit import compiled
from .layout import A1, A2, A3, A4, BELT, DELTA, GAMMA, LAW, LAWS
from .memory_motion import (
    A, AGEING, B, BRISTLES, CUT_1, CUT_2, D, ELASTIC, GROWTH, KIND, LONG, REST, ROWS, S_0, S_1, S_1_RATE, SIGN, SLIP,
    START_0, START_1, START_2, TURNS, acceleration, curve_level, friction, jacobian, slip_speed,
)  # fmt: skip
from .radau import MATRIX, SIZE, STAGES, STATES, at_share, error_of, polynomial_of, step

NAMES = (  # of answers
    "REGIME", "PERIOD", "F_MAX", "F_MIN", "FASTEST", "SLOWEST", "HEAT", "ACCELERATION", "WHOLE_MAX", "WHOLE_MIN",
    "WHOLE_FASTEST", "CROSSINGS", "SETTLING", "LOOPS", "STEPS", "DECIDED", "WHOLE_ACCELERATION", "AT_BAND",
)  # fmt: skip
ANSWERS = len(NAMES)
(
    REGIME, PERIOD, F_MAX, F_MIN, FASTEST, SLOWEST, HEAT, ACCELERATION, WHOLE_MAX, WHOLE_MIN, WHOLE_FASTEST, CROSSINGS,
    SETTLING, LOOPS, STEPS, DECIDED, WHOLE_ACCELERATION, AT_BAND,
) = range(ANSWERS)  # fmt: skip
UNDECIDED, CYCLE, SETTLES = range(3)
BAND = 1e-4
MOST_LOOPS, LOOPS_OF_CYCLE = 3000, 12
SAME, LEFT = 1e-9, 1e-8  # change of the state in the section over a cycle, and what is left of the changes
ALIKE = 1e-6  # change from which on loops are different ones
NEAR = 1e-3  # deviation from steady sliding from which on linear theory holds
SAMPLES = 12  # in a step
GOLDEN, SECTIONS, ROOM, EDGE = 0.6180339887498949, 20, 0.05, 1e-4  # of the search for the largest |w'|
# columns of the book of loops: time, f, the third state, heat; extremes of u, w and |w'| up to the next
T_0, F_0, Z_0, HEAT_0, HIGH, LOW, TOP, BOTTOM, HARDEST = range(9)


@compiled
def begin_loop(loop):
    loop[HIGH], loop[LOW], loop[TOP], loop[BOTTOM], loop[HARDEST] = -inf, inf, -inf, inf, 0.0


@compiled
def note(loop, u, w, dw):
    loop[HIGH], loop[LOW] = max(loop[HIGH], u), min(loop[LOW], u)
    loop[TOP], loop[BOTTOM], loop[HARDEST] = max(loop[TOP], w), min(loop[BOTTOM], w), max(loop[HARDEST], abs(dw))


@compiled
def pull_at(p, y, h, x, sizes, z, work):
    """|w'| at the share x of a step, by a step that ends there."""
    return abs(acceleration(p, y + z[STAGES - 1])) if step(p, y, x * h, sizes, z, work) else 0.0


@compiled
def hardest_pull(p, y, h, low, high, sizes, z, work):
    """The largest |w'| between two shares of a step, by golden section."""
    a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    of_a, of_b = pull_at(p, y, h, a, sizes, z, work), pull_at(p, y, h, b, sizes, z, work)
    for _ in range(SECTIONS):
        if of_a > of_b:
            high, b, of_b = b, a, of_a
            a = high - GOLDEN * (high - low)
            of_a = pull_at(p, y, h, a, sizes, z, work)
        else:
            low, a, of_a = a, b, of_b
            b = low + GOLDEN * (high - low)
            of_b = pull_at(p, y, h, b, sizes, z, work)
    return max(of_a, of_b)


@compiled
def hardest_in_step(p, y, h, pulls, least, sizes, z, work):
    """The largest |w'| in a step, of which `pulls` are samples, where it may be above `least`; else 0."""
    top = 0.0
    for n in range(SAMPLES + 1):
        left, right = pulls[max(n - 1, 0)], pulls[min(n + 1, SAMPLES)]
        if pulls[n] < max(left, right) or pulls[n] < (1.0 - ROOM) * max(least, top):
            continue
        if n == 0 and pull_at(p, y, h, EDGE, sizes, z, work) <= pulls[0]:
            continue
        if n == SAMPLES and pull_at(p, y, h, 1.0 - EDGE, sizes, z, work) <= pulls[n]:
            continue
        low, high = max(n - 1, 0) / SAMPLES, min(n + 1, SAMPLES) / SAMPLES
        top = max(top, hardest_pull(p, y, h, low, high, sizes, z, work))
    return top


@compiled
def first_passage(c, level, sign_before):
    """Share of the step at which the second state first passes the level, on the polynomial; 2 if it does not."""
    below = 0.0
    for n in range(1, SAMPLES + 1):
        x = n / SAMPLES
        value = at_share(c, 1, x)[0] - level
        if value * sign_before < 0.0:
            low, high = below, x
            for _ in range(60):
                middle = 0.5 * (low + high)
                if (at_share(c, 1, middle)[0] - level) * sign_before < 0.0:
                    high = middle
                else:
                    low = middle
            return high
        below = x
    return 2.0


@compiled
def turning(p, c, x, stage):
    """What vanishes with w' at the share x of a step; slip both ways leaves the state there in `stage`."""
    if p[REST] == 0.0:
        return at_share(c, 1, x)[1]
    for row in range(STATES):
        stage[row] = at_share(c, row, x)[0]
    return acceleration(p, stage)


@compiled
def sizes_of(p, y, sizes):
    if p[KIND] == BRISTLES:
        load = p[A1] + max(p[A3], 0.0)
        sizes[0], sizes[1], sizes[2] = load, max(abs(y[1]), p[BELT]), load
    else:
        sizes[0], sizes[1], sizes[2] = p[A], 1.0, 1.0


@compiled
def deviation(p, y):
    """From steady sliding, in what makes it linear."""
    if p[KIND] != BRISTLES:
        return max(abs(y[1]), abs(y[2]), abs(y[0]) / p[A])
    off, g = abs(y[1] - p[BELT]), curve_level(p, p[BELT])[0]
    return max(off / p[BELT], off / p[A4], abs(y[2] / g - 1.0), abs(y[0] / (g + p[A2] * p[BELT]) - 1.0))


@compiled
def follow(p, tolerance, most_steps, share_of_band, out, book):
    """Follow one cell from its start; p : its rows, of which SIGN is changed on the way."""
    belt, kind = p[BELT], p[KIND]
    steady = 0.0 if kind != BRISTLES else curve_level(p, belt)[0] + p[A2] * belt
    level = belt if kind == BRISTLES else 0.0
    y, end, sizes = p[START_0 : START_0 + STATES].copy(), np.empty(STATES), np.empty(STATES)
    z, c = np.empty((STAGES, STATES)), np.empty((STAGES + 1, STATES))
    work = np.empty((SIZE, SIZE)), np.empty(SIZE), np.empty((STAGES, STATES)), np.empty((STATES, STATES))
    t, h, heat, steps, loops, side = 0.0, p[LONG] * 1e-6, 0.0, 0, 0, 1.0 if y[1] > level else -1.0
    out[:] = nan
    out[REGIME], out[CROSSINGS], out[STEPS] = UNDECIDED, 0.0, 0
    whole, loop, pulls = np.empty(9), book[0], np.empty(SAMPLES + 1)
    begin_loop(whole)
    begin_loop(loop)
    loop[T_0] = nan
    note(whole, y[0], slip_speed(p, y), acceleration(p, y))
    amplitude, entered_at = max(abs(y[0] - steady), abs(slip_speed(p, y) - belt)), inf
    inside = False
    while steps < most_steps:
        steps += 1
        out[STEPS] = steps
        sizes_of(p, y, sizes)
        if not h > 1e-290:
            return
        if not step(p, y, h, sizes, z, work):
            h *= 0.25
            continue
        error = error_of(p, y, h, sizes, z, work) / tolerance
        if not error < 1.0:
            h *= max(0.1, 0.9 * error ** (-1.0 / 6.0)) if error < inf else 0.1
            continue
        grown = h * min(4.0, 0.9 * max(error, 1e-8) ** (-1.0 / 6.0))
        polynomial_of(y, z, c)
        share, event = first_passage(c, level, side), 1
        if kind == BRISTLES:
            through = first_passage(c, 0.0, p[SIGN])
            if through < share:
                share, event = through, 2
        if share <= 1.0:
            target, part, ok = (level if event == 1 else 0.0), share * h, True
            for _ in range(8):
                ok = ok and step(p, y, part, sizes, z, work)
                end[:] = y + z[STAGES - 1]
                by_time = acceleration(p, end) / (1.0 if kind == BRISTLES else slip_speed(p, end))
                off = (end[1] - target) / by_time
                if abs(off) < 1e-14 * part or not abs(off) < 0.1 * part:
                    break
                part -= off
            if not ok:
                h *= 0.25
                continue
            h = part
            polynomial_of(y, z, c)
        else:
            event = 0
        end[:] = y + z[STAGES - 1]
        if event == 1:
            end[1] = level
        if event == 2:
            end[1] = 0.0
        for n in range(STAGES):
            stage = y + z[n]
            mu = friction(p, stage) + (0.0 if kind == BRISTLES else p[A1])
            heat += h * MATRIX[STAGES - 1, n] * mu * slip_speed(p, stage)
        # what is passed on the way
        stage = end.copy()
        slope_before, pulls[0] = turning(p, c, 0.0, stage), abs(acceleration(p, y))
        for n in range(1, SAMPLES + 1):
            x = n / SAMPLES
            slope = turning(p, c, x, stage)
            if slope * slope_before < 0.0:
                low, high = x - 1.0 / SAMPLES, x
                for _ in range(40):
                    middle = 0.5 * (low + high)
                    if turning(p, c, middle, stage) * slope_before > 0.0:
                        low = middle
                    else:
                        high = middle
                if p[REST] == 0.0:
                    stage[1] = at_share(c, 1, low)[0]
                note(loop, end[0], slip_speed(p, stage), 0.0)
                note(whole, end[0], slip_speed(p, stage), 0.0)
                amplitude = max(amplitude, abs(slip_speed(p, stage) - belt))
            slope_before = slope
            if n < SAMPLES:
                for row in range(STATES):
                    stage[row] = at_share(c, row, x)[0]
                pulls[n] = abs(acceleration(p, stage))
        w, dw = slip_speed(p, end), acceleration(p, end)
        pulls[SAMPLES] = abs(dw)
        hardest = hardest_in_step(p, y, h, pulls, loop[HARDEST], sizes, z, work)
        loop[HARDEST], whole[HARDEST] = max(loop[HARDEST], hardest), max(whole[HARDEST], hardest)
        note(loop, end[0], w, dw)
        note(whole, end[0], w, dw)
        distance = max(abs(end[0] - steady), abs(w - belt))
        amplitude = max(amplitude, distance)
        if distance > share_of_band * amplitude:
            inside = False
        elif not inside:
            inside = True
            low, high = 0.0, 1.0
            for _ in range(50):
                x = 0.5 * (low + high)
                for row in range(STATES):
                    stage[row] = at_share(c, row, x)[0]
                if max(abs(stage[0] - steady), abs(slip_speed(p, stage) - belt)) > share_of_band * amplitude:
                    low = x
                else:
                    high = x
            out[SETTLING], entered_at = t + high * h, deviation(p, end)
        t, h = t + h, (min(grown, 4.0 * h) if event == 0 else min(grown, max(h, 0.05 * grown)))
        y[:] = end
        if event == 2:
            p[SIGN] = -p[SIGN]
        if event == 1:
            if abs(y[0] - steady) > share_of_band * amplitude:
                out[CROSSINGS] += 1.0
            side = -side
            if side > 0.0:
                loops += 1
                if loops >= MOST_LOOPS:
                    return
                loop = book[loops]
                begin_loop(loop)
                loop[T_0], loop[F_0], loop[Z_0], loop[HEAT_0] = t, y[0], y[2], heat
                note(loop, y[0], belt, 0.0)
                sizes_of(p, y, sizes)
                of = length_of_cycle(book, loops, sizes)
                if of > 0:
                    answer_cycle(book, loops, of, p, out, whole)
                    out[DECIDED] = t
                    return
        growth = p[GROWTH]
        off = deviation(p, y)
        if growth < 0.0 and off < NEAR and off * off < 1e-2 * min(1.0, -6.28 * growth / max(p[TURNS], -growth)):
            if isnan(out[DECIDED]):
                out[REGIME], out[DECIDED] = SETTLES, t
            if inside and off < 0.01 * entered_at:
                note(whole, steady, belt, 0.0)
                out[WHOLE_MAX], out[WHOLE_MIN], out[WHOLE_ACCELERATION] = whole[HIGH], whole[LOW], whole[HARDEST]
                out[WHOLE_FASTEST], out[AT_BAND] = max(whole[TOP], -whole[BOTTOM]), entered_at
                return


@compiled
def isnan(x):
    return x != x


@compiled
def length_of_cycle(book, loops, sizes):
    """Of how many loops the cycle is that has just been closed; 0: of none that is certain."""
    for of in range(1, LOOPS_OF_CYCLE + 1):
        if loops - 3 * of < 1:
            return 0
        last, before, first, zeroth = book[loops], book[loops - of], book[loops - 2 * of], book[loops - 3 * of]
        share = of_range(book, loops, of, sizes)  # changes count by the range of the cycle, which may be small
        change = change_of(last, before, sizes)
        previous, earlier = change_of(before, first, sizes), change_of(first, zeroth, sizes)
        if change < SAME * share and previous < 10.0 * SAME * share:
            ratio = change / previous if previous > 1e-11 * share else 0.0
            if ratio < 1.0 and change * ratio / (1.0 - ratio) < LEFT * share and earlier < 1e-3 * share:
                for fewer in range(1, of):
                    if of % fewer == 0 and change_of(last, book[loops - fewer], sizes) < ALIKE * share:
                        return fewer
                return of
    return 0


@compiled
def of_range(book, loops, of, sizes):
    """By how much u ranged in the last loops, so many, over its size; at most 1."""
    high, low = -inf, inf
    for n in range(loops - of, loops):
        high, low = max(high, book[n, HIGH]), min(low, book[n, LOW])
    return min((high - low) / sizes[0], 1.0)


@compiled
def change_of(last, before, sizes):
    return max(abs(last[F_0] - before[F_0]) / sizes[0], abs(last[Z_0] - before[Z_0]) / sizes[2])


@compiled
def answer_cycle(book, loops, of, p, out, whole):
    total = np.empty(9)
    begin_loop(total)
    for n in range(loops - of, loops):
        note(total, book[n, HIGH], book[n, TOP], book[n, HARDEST])
        note(total, book[n, LOW], book[n, BOTTOM], 0.0)
    out[REGIME], out[LOOPS] = CYCLE, of
    out[PERIOD], out[HEAT] = book[loops, T_0] - book[loops - of, T_0], book[loops, HEAT_0] - book[loops - of, HEAT_0]
    out[F_MAX], out[F_MIN] = max(total[HIGH], book[loops, F_0]), min(total[LOW], book[loops, F_0])
    out[FASTEST], out[SLOWEST], out[ACCELERATION] = total[TOP], total[BOTTOM], total[HARDEST]
    out[WHOLE_MAX], out[WHOLE_MIN], out[WHOLE_FASTEST] = whole[HIGH], whole[LOW], max(whole[TOP], -whole[BOTTOM])
    out[WHOLE_ACCELERATION], out[SETTLING] = whole[HARDEST], nan


def judge_memory(rows, tolerance=1e-9, most_steps=100_000, band=BAND):
    """Answers (n, ANSWERS) of cells (n, ROWS) in kernel units, belts forwards; extremes of u over the load."""
    return answers(judge_memory_cells, np.array(rows, np.float64), ANSWERS, tolerance, most_steps, band)


def judge_memory_cells(rows, out, tolerance, most_steps, band):
    """The same into `out`."""
    book, j = np.empty((MOST_LOOPS + 1, 9)), np.empty((STATES, STATES))
    for p, answer in zip(rows, out, strict=True):
        steady = np.zeros(STATES)
        p[SIGN] = 1.0
        if p[KIND] == BRISTLES:
            g = curve_level(p, p[BELT])[0]
            steady[:] = g + p[A2] * p[BELT], p[BELT], g
        jacobian(p, steady, j)
        roots = np.linalg.eigvals(j)
        leading = roots[np.argmax(roots.real)]
        p[GROWTH], p[TURNS] = leading.real, abs(leading.imag)
        p[LONG] = 1.0 / max(abs(roots).max(), 1.0)
        if p[KIND] == BRISTLES:
            p[SIGN] = first_sign(p)
        follow(p, tolerance, most_steps, band, answer, book)
        if p[KIND] != BRISTLES:  # loads of the cell itself
            for row in (F_MAX, F_MIN, WHOLE_MAX, WHOLE_MIN):
                answer[row] += p[A1]


def let_turn(rows, w):
    """The regularised form, from slip speeds w; its loads in steady sliding."""
    belt, r = rows[:, BELT], rows[:, B] / rows[:, A]
    steady = rows[:, A1] / rows[:, A]
    c, half = steady + r * rows[:, START_2], 0.5 * np.exp(np.minimum(steady, 40.0))
    rows[:, REST] = steady
    rows[:, START_0] += rows[:, A1]
    rows[:, A1] = rows[:, A] * np.where(steady > 40.0, steady, np.arcsinh(half))
    rows[:, START_0] -= rows[:, A1]
    with np.errstate(over="ignore"):
        chi, at_belt = np.arcsinh(0.5 * np.abs(w) / belt * np.exp(c)), np.arcsinh(0.5 * np.exp(c))
    chi = np.where(c > 300.0, np.log(np.maximum(np.abs(w) / belt, 1e-290)) + c, chi)
    rows[:, START_1] = np.sign(w) * np.where(w == 0.0, 0.0, chi) - np.where(c > 300.0, c, at_belt)


def first_sign(p):
    """Of w just after the start."""
    y = p[START_0 : START_0 + STATES]
    if y[1] != 0.0:
        return np.sign(y[1])
    pull = acceleration(p, y)
    return -1.0 if pull < 0.0 else 1.0


def kernel_rows(cells, law, regularised=False):
    """SI cells (arrays by name) to rows; belts backwards are mirrored. regularised : whether w may pass zero."""
    n = np.size(cells["mass"])
    m, k, load = (np.broadcast_to(cells[name], n) for name in ("mass", "stiffness", "normal_load"))
    time, length = np.sqrt(m / k), load / k
    speed, impedance = length / time, np.sqrt(k * m)
    rows = np.zeros((n, ROWS))
    way = np.where(cells["belt_speed"] < 0.0, -1.0, 1.0)
    belt = np.abs(cells["belt_speed"]) / speed
    rows[:, BELT], rows[:, GAMMA] = belt, cells["damping"] / impedance
    u, velocity = way * cells["displacement"] / length, way * cells["velocity"] / speed
    if law.startswith("rate_state"):
        rows[:, KIND] = AGEING if law == "rate_state_ageing" else SLIP
        rows[:, A], rows[:, B], rows[:, D] = cells["a"], cells["b"], cells["D_c"] / length
        rows[:, A1] = cells["mu_0"] + (cells["a"] - cells["b"]) * np.log(belt * speed / cells["v_0"])  # steady load
        for row, name, effect in ((CUT_1, "direct", cells["a"]), (CUT_2, "evolution", -cells["b"])):
            cut = cells.get(f"{name}_cutoff_speed", np.full(n, np.nan))
            rows[:, row] = np.nan_to_num(belt * speed / cut)
            rows[:, A1] -= effect * np.log((1.0 + rows[:, row]) / (1.0 + np.nan_to_num(cells["v_0"] / cut)))
        rows[:, START_0] = u - rows[:, A1]
        with np.errstate(divide="ignore", invalid="ignore"):
            rows[:, START_1] = np.where(np.isnan(velocity), np.log(0.1), np.log((belt - velocity) / belt))
            theta = np.where(cells["contact_time"] > 0.0, cells["contact_time"] / time * belt / rows[:, D], 1.0)
        rows[:, START_2] = np.log(theta)
        if regularised:
            let_turn(rows, np.where(np.isnan(velocity), 0.1 * belt, belt - velocity))
        return rows
    rows[:, KIND], rows[:, LAW] = BRISTLES, LAWS.index(law)
    for row, values in (
        (A1, cells["a1"]), (A2, cells["a2"] * speed), (A3, cells["a3"]), (A4, cells["a4"] / speed),
        (DELTA, cells["delta"]), (S_0, cells["contact_stiffness"] / k), (S_1, cells["contact_damping"] / impedance),
        (S_1_RATE, np.nan_to_num(speed / cells["contact_damping_speed"])), (ELASTIC, cells["elastic_part"]),
        (START_0, u), (START_1, np.where(np.isnan(velocity), 0.0, belt - velocity)),
    ):  # fmt: skip
        rows[:, row] = values
    return rows
