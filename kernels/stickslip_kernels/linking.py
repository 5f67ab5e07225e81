"""What machines and laws share: arrays as addresses, and laws as functions of another object.

A machine (`exports.py`) is compiled once for a contact. There the tag of its law is `Linked`, and functions of a law
that say their kinds are calls of another object, that of the law, where its own tag chooses what is compiled: the loops
over all lanes, and what scalar code asks of a curve. The loader joins the two (`runtime.py`).
"""

import operator
from typing import Any, NamedTuple

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import (
    intrinsic,
    lower_builtin,
    make_attribute_wrapper,
    models,
    register_model,
    type_callable,
)  # fmt: skip

from .jit import by_type

PREFIX = "law."  # of the names of functions of laws
FLOATS = types.CPointer(types.float64)


class Linked(NamedTuple):
    """Tag of a law in an object of its own. stations : address of the numbers of a table."""

    stations: Any


# --- arrays of two dimensions ---------------------------------------------------------------------------------------


class Columns(types.Type):
    """A C-contiguous array of floats at an address: three words, where Numba's has nine."""

    def __init__(self):
        super().__init__("Columns")


COLUMNS, _SHAPE = Columns(), types.UniTuple(types.int64, 2)


@register_model(Columns)
class _Model(models.StructModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, [("data", FLOATS), ("shape", _SHAPE)])


make_attribute_wrapper(Columns, "shape", "shape")


@intrinsic
def columns_at(typing_context, address, shape):
    """The array at an address."""

    def generate(context, builder, signature, arguments):
        array = cgutils.create_struct_proxy(COLUMNS)(context, builder)
        array.data, array.shape = arguments[0], context.cast(builder, arguments[1], signature.args[1], _SHAPE)
        return array._getvalue()

    return COLUMNS(address, shape), generate


@type_callable(operator.getitem)
def _type_of_number(context):
    return lambda array, place: types.float64 if array is COLUMNS and isinstance(place, types.BaseTuple) else None


@type_callable(operator.setitem)
def _type_of_setting(context):
    return lambda array, place, number: types.none if array is COLUMNS and isinstance(place, types.BaseTuple) else None


def _address(context, builder, kinds, values):
    array = cgutils.create_struct_proxy(COLUMNS)(context, builder, values[0])
    row, column = cgutils.unpack_tuple(builder, context.cast(builder, values[1], kinds[1], _SHAPE))
    return builder.gep(array.data, [builder.add(builder.mul(row, builder.extract_value(array.shape, 1)), column)])


@lower_builtin(operator.getitem, Columns, types.BaseTuple)
def _number(context, builder, signature, values):
    return builder.load(_address(context, builder, signature.args, values))


@lower_builtin(operator.setitem, Columns, types.BaseTuple, types.Number)
def _set_number(context, builder, signature, values):
    number = context.cast(builder, values[2], signature.args[2], types.float64)
    builder.store(number, _address(context, builder, signature.args, values))
    return context.get_dummy_value()


# --- functions of laws ----------------------------------------------------------------------------------------------

# Kinds of arguments, and of results after a colon: numbers, truth, the lanes, cells, ends of a step (`roots.py`).
_KINDS = {"f": types.float64, "i": types.int64, "b": types.boolean, "s": FLOATS, "c": COLUMNS,
          "e": types.UniTuple(types.float64, 4), "p": types.UniTuple(types.float64, 2), "": types.none}  # fmt: skip


def by_law(kinds=None, *, inline=False):
    """Decorator: `by_type` of the law, the first argument.

    kinds : of the other arguments and the result, for functions that machines call.
    """

    def decorate(default):
        function = by_type(lambda law, *_: law, inline=inline)(default)
        if kinds is not None:
            function.kinds = kinds
            function.of(Linked)(_call(function))
        return function

    return decorate


def signature_of(function):
    """Result and argument of a function of a law, which passes a tuple: address of the stations, and what it is of."""
    arguments, _, result = function.kinds.partition(":")
    return _KINDS[result](types.Tuple((FLOATS, *(_KINDS[kind] for kind in arguments))))


def _call(function):
    name, signature = PREFIX + function.__name__, signature_of(function)
    (wanted,) = signature.args

    @intrinsic
    def call(typing_context, numbers):
        def generate(context, builder, types_here, values):
            value = context.cast(builder, values[0], types_here.args[0], wanted)
            kind = ir.FunctionType(context.get_value_type(signature.return_type), [context.get_value_type(wanted)])
            return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [value])

        return signature.return_type(numbers), generate

    return lambda law, *numbers: call((law.stations, *numbers))


def door(function, tag):
    """The function of a law with this tag, as a machine calls it."""

    def call(numbers):
        return function(with_stations(tag, numbers[0]), *numbers[1:])

    return call


@by_law(inline=True)
def with_stations(law, stations):
    """The tag with the numbers of an array."""
    return law


with_stations.of(Linked)(lambda law, stations: Linked(stations))
