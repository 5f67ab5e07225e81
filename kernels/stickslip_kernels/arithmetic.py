"""Elementary functions that LLVM can vectorise.

A call to libm in the hot loop would keep it scalar (llvmlite carries no vector library), so the loop brings its own:
exponential and logarithm to rounding, and a rough power for the step-size controller, where one per cent is accurate
enough. Cody-Waite reduction x = n ln 2 + r, |r| <= ln(2)/2, polynomial in r, and n added to the exponent bits.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .jit import WIDEST_VECTORS, compiled

SQRT2 = 1.4142135623730951
LOG2_E = 1.4426950408889634
LN2_HIGH = 6.93147180369123816490e-01  # trailing zeros: n * LN2_HIGH is exact for |n| < 2**20
LN2_LOW = 1.90821492927058770002e-10
# Adding 1.5 * 2**52 rounds to the nearest integer and leaves that integer in the low bits.
ROUND = 6755399441055744.0
SMALLEST, LARGEST = -708.0, 700.0  # the range in which n still fits the exponent field

MANTISSA = 0x000FFFFFFFFFFFFF
ONE_BITS = 0x3FF0000000000000
TWO52_BITS = 0x4330000000000000
TWO52 = 4503599627370496.0


@compiled(inline=True)
def exp(x):
    """e**x, relative error below 5e-16 for -708 <= x <= 700; outside, the value at the nearer end."""
    x = min(max(x, SMALLEST), LARGEST)
    shifted = x * LOG2_E + ROUND
    n = shifted - ROUND
    r = (x - n * LN2_HIGH) - n * LN2_LOW
    # Taylor polynomial of degree 12 in Estrin's form: remainder 2e-16, short dependency chains.
    r2 = r * r
    r4 = r2 * r2
    r8 = r4 * r4
    low = (1.0 + r) + r2 * (0.5 + r * 0.16666666666666666)
    middle = (0.041666666666666664 + r * 0.008333333333333333) + r2 * (0.001388888888888889 + r * 1.984126984126984e-4)
    high = (2.48015873015873e-05 + r * 2.7557319223985893e-06) + r2 * (
        2.755731922398589e-07 + r * 2.505210838544172e-08
    )
    polynomial = low + r4 * middle + r8 * (high + r4 * 2.08767569878681e-09)
    return float_of(bits_of(polynomial) + (bits_of(shifted) << 52))


@compiled(inline=True)
def rough_log2(x):
    """log2 |x|, at most 0.087 below the true value for normal x; -1023 for 0, 1024 or more for inf and NaN.

    Exponent and mantissa read as one number: the mantissa stands for its own logarithm.
    """
    return (float_of((bits_of(abs(x)) >> 12) | TWO52_BITS) - TWO52) * 2.0**-40 - 1023.0


@compiled(inline=True)
def rough_exp2(x):
    """2**x to one per cent for |x| < 1000."""
    shifted = x + ROUND
    r = x - (shifted - ROUND)
    return float_of(bits_of(1.0 + r * (0.6931472 + r * 0.2402265)) + (bits_of(shifted) << 52))


@compiled(inline=True)
def log(x):
    """Natural logarithm of a normal x > 0, relative error below 1e-15 (absolute near x = 1); -709.1 for x = 0."""
    bits = bits_of(x)
    exponent = float_of((bits >> 52) + TWO52_BITS) - TWO52 - 1023.0
    m = float_of((bits & MANTISSA) | ONE_BITS)
    large = m > SQRT2
    m = select(large, 0.5 * m, m)
    exponent = exponent + select(large, 1.0, 0.0)
    # ln m = 2 artanh f, f = (m - 1)/(m + 1), |f| < 0.172: the series to f^19 leaves 1e-17.
    f = (m - 1.0) / (m + 1.0)
    g = f * f
    g2 = g * g
    low = (0.6666666666666666 + g * 0.4) + g2 * (0.2857142857142857 + g * 0.2222222222222222)
    high = (0.18181818181818182 + g * 0.15384615384615385) + g2 * (0.13333333333333333 + g * 0.11764705882352941)
    series = f * (2.0 + g * (low + g2 * g2 * (high + g2 * g2 * 0.10526315789473684)))
    return exponent * LN2_HIGH + (series + exponent * LN2_LOW)


# --- single instructions of LLVM that Numba cannot express ------------------------------------------------------------


@intrinsic
def bits_of(typing_context, number):
    """The 64 bits of a float64, as an int64."""

    def generate(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), generate


@intrinsic
def float_of(typing_context, bits):
    """The float64 whose bits are those of an int64."""

    def generate(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), generate


@intrinsic
def select(typing_context, condition, if_true, if_false):
    """`if_true if condition else if_false` for floats, both evaluated, as one instruction.

    The ternary is a branch; around a store LLVM turns it into masked stores, which cost 40 cycles each on some
    processors (measured on Zen 3: the hot loop ran four times slower).
    """

    def generate(context, builder, signature, arguments):
        return builder.select(*arguments)

    return types.float64(types.boolean, types.float64, types.float64), generate


@intrinsic
def widest_vectors(typing_context):
    """Let the loops of the function that says so use the widest registers the processor has.

    LLVM prefers half of them on Intel's servers, whose first kinds slowed down for them.
    """

    def generate(context, builder, signature, arguments):
        # llvmlite knows a few attributes by name only; this one it prints as it is.
        set.add(builder.function.attributes, WIDEST_VECTORS)
        return context.get_dummy_value()

    return types.void(), generate


@intrinsic
def nonzero_bits(typing_context, array, first, count):
    """Return which of `count` floats of a contiguous array, from number `first` on, are not zero: bit i of an int64 for
    the i-th. `count`, at most 63, must be a literal.
    """
    if not isinstance(count, types.IntegerLiteral):
        return None
    n = count.literal_value

    def generate(context, builder, signature, arguments):
        data = arguments[0]
        if isinstance(signature.args[0], types.Array):
            data = context.make_array(signature.args[0])(context, builder, data).data
        vector = ir.VectorType(ir.DoubleType(), n)
        start = builder.bitcast(builder.gep(data, [arguments[1]]), vector.as_pointer())
        up = builder.fcmp_unordered("!=", builder.load(start, align=8), ir.Constant(vector, [0.0] * n))
        return builder.zext(builder.bitcast(up, ir.IntType(n)), ir.IntType(64))

    return types.int64(array, types.int64, count), generate


@intrinsic
def in_turn(typing_context, function, law, s, first, last):
    """Call function(law, s, n) for n from `first` to `last` - 1, which are literals.

    LLVM merges each, n being a constant there; Numba compiles the function once.
    """
    if not (isinstance(first, types.IntegerLiteral) and isinstance(last, types.IntegerLiteral)):
        return None
    called = typing_context.resolve_function_type(function, (law, s, types.int64), {})

    def generate(context, builder, signature, arguments):
        call = context.get_function(function, called)
        context.add_linking_libs(getattr(call, "libs", ()))
        for n in range(first.literal_value, last.literal_value):
            call(builder, (*arguments[1:3], context.get_constant(types.int64, n)))
        return context.get_dummy_value()

    return types.void(function, law, s, first, last), generate


@intrinsic
def lowest_bit(typing_context, bits):
    """The index, from 0, of the lowest bit set in an int64 other than 0."""

    def generate(context, builder, signature, arguments):
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 1))

    return types.int64(types.int64), generate
