"""Intrinsics, single instructions of LLVM that Numba cannot express: bits of a float, a select, the lowest bit set."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .jit import WIDEST_VECTORS


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
def lowest_bit(typing_context, bits):
    """The index, from 0, of the lowest bit set in an int64 other than 0."""

    def generate(context, builder, signature, arguments):
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 1))

    return types.int64(types.int64), generate
