"""Half floats in kernels: numba has no arithmetic of theirs, so that they come as the 16 bits that they are.

Those of one that is finite and not negative, thirteen places to the left, spell its 2⁻¹¹²th part in single precision,
where exponents count from another zero: what they are added up with is multiplied by 2¹¹² beforehand.
"""

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic, overload

ZERO = 2.0**112         # between the exponents' zeros


def bits_of(numbers: np.ndarray) -> np.ndarray:
    """The same memory, as its bits where it is of half floats."""
    return numbers.view(np.uint16) if numbers.dtype == np.float16 else numbers


def unit(numbers: np.ndarray) -> np.float32:
    """By what `stored` numbers of such an array are to be multiplied."""
    return np.float32(ZERO if numbers.dtype == np.uint16 else 1.0)


def stored(number):
    """For kernels, of an element of an array by `bits_of`: float32, its `unit`th part."""
    raise NotImplementedError("for kernels alone")


@overload(stored, inline="always")
def _stored(number):
    if number == types.uint16:
        return lambda number: _spelt(np.uint32(number) << np.uint32(13))
    return lambda number: number


@njit(inline="always")
def half_float(bits):
    """The float32 that the 16 bits of a half float spell which is not negative, and finite."""
    return _spelt(np.uint32(bits) << np.uint32(13)) * np.float32(ZERO)


@intrinsic
def _spelt(typing, bits):
    """The float32 that 32 bits spell."""
    def build(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], context.get_value_type(types.float32))

    return types.float32(types.uint32), build


@intrinsic
def fetched(typing, line, place):
    """Have the processor fetch what is around line[place] into its cache, of a contiguous array, and go on."""
    def build(context, builder, signature, arguments):
        there = builder.gep(context.make_array(signature.args[0])(context, builder, arguments[0]).data, [arguments[1]])
        byte, number = ir.IntType(8).as_pointer(), ir.IntType(32)
        prefetch = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(ir.VoidType(), [byte, number, number, number]), "llvm.prefetch.p0")
        builder.call(prefetch, [builder.bitcast(there, byte), number(0), number(2), number(1)])     # read, kept, data
        return context.get_dummy_value()

    return types.void(line, types.intp), build
