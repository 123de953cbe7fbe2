"""Arrays in kernels: large ones read where they lie, and half-precision floats.

Parameters are copied into the type of the lanes for every program that uses them. An array of hundreds of megabytes is
not: a step names its address in the integers, and keeps the array alive in `Step.kept`.

    step = Step(wall, parameters, [address(texels), texels.size], kept=(texels,))

    @stage
    def wall(lanes, p, ints, key):
        texels = borrowed(ints[0], ints[1], np.uint16)

Numba has no arithmetic for half floats. The bits of a finite half that is not negative, shifted left by 13,
are those of a float32 that is 2⁻¹¹² of its value, because the exponents of the two formats have different biases.
Kernels compute with these scaled values and multiply a result by `EXPONENT_SCALE`, 2¹¹².
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


def address(array: np.ndarray) -> int:
    """Address of the first number of a contiguous array."""
    if not array.flags.c_contiguous:
        raise ValueError("a borrowed array must be contiguous")
    return array.ctypes.data


@intrinsic
def borrowed(typing, pointer, count, kind):
    """The `count` numbers of a type (np.float32, np.uint16, …) at an address, as a flat array."""
    number = kind.dtype
    view = types.Array(number, 1, "C", readonly=True)

    def build(context, builder, signature, arguments):
        from numba.np.arrayobj import make_array, populate_array  # late: no stored kernel needs it

        def whole(value):
            return context.get_constant(types.intp, value)

        data = context.get_data_type(number).as_pointer()
        table = make_array(view)(context, builder)
        populate_array(table, data=builder.inttoptr(arguments[0], data), meminfo=None, parent=None,
                       itemsize=whole(number.bitwidth // 8), shape=cgutils.pack_array(builder, [arguments[1]]),
                       strides=cgutils.pack_array(builder, [whole(number.bitwidth // 8)]))
        return table._getvalue()

    return view(pointer, count, kind), build


EXPONENT_SCALE = 2.0**112       # value of a half over that of its shifted bits: biases 127 − 15


def as_bits(numbers: np.ndarray) -> np.ndarray:
    """The same memory: half floats viewed as uint16, other arrays as they are."""
    return numbers.view(np.uint16) if numbers.dtype == np.float16 else numbers


def scale_of(numbers: np.ndarray) -> np.float32:
    """Factor from `unscaled` elements of an array by `as_bits` to their values."""
    return np.float32(EXPONENT_SCALE if numbers.dtype == np.uint16 else 1.0)


@intrinsic
def unscaled(typing, number):
    """An element of an array by `as_bits` as float32, short of the factor `scale_of`."""
    def build(context, builder, signature, arguments):
        if number != types.uint16:
            return arguments[0]
        word = ir.IntType(32)
        bits = builder.shl(builder.zext(arguments[0], word), word(13))
        return builder.bitcast(bits, context.get_value_type(types.float32))

    return (types.float32 if number == types.uint16 else number)(number), build


@intrinsic
def prefetch(typing, line, pointer):
    """Request the cache line of line[place], an element of a contiguous array, without waiting for it."""
    def build(context, builder, signature, arguments):
        there = builder.gep(context.make_array(signature.args[0])(context, builder, arguments[0]).data, [arguments[1]])
        byte, number = ir.IntType(8).as_pointer(), ir.IntType(32)
        instruction = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(ir.VoidType(), [byte, number, number, number]), "llvm.prefetch.p0")
        builder.call(instruction, [builder.bitcast(there, byte), number(0), number(2), number(1)])  # read, kept, data
        return context.get_dummy_value()

    return types.void(line, types.intp), build


@intrinsic
def texel_sum(typing, numbers, places, down, across, depth):
    """Weighted sum of 4 × 4 texels, and the greatest distance of their fourth numbers from `depth`.

    numbers: half floats as bits, four to a texel. places (4): index of the first number of each line of four texels.
    down, across (4): float32 weights of lines and columns. → Σ down · across · texel (three numbers) and
    max |fourth − depth|, all short of EXPONENT_SCALE. Numba does not vectorise such sums over 16 numbers by itself.
    """
    def build(context, builder, signature, arguments):
        array, *fours, middle = arguments
        bits = context.make_array(signature.args[0])(context, builder, array).data
        places_, rows, columns = ([builder.extract_value(four, k) for k in range(4)] for four in fours)
        half = ir.VectorType(ir.IntType(16), 16)
        whole, real = ir.VectorType(ir.IntType(32), 16), ir.VectorType(ir.FloatType(), 16)

        def spread(scalars) -> ir.Value:
            vector = ir.Constant(real, ir.Undefined)
            for lane in range(16):
                vector = builder.insert_element(vector, scalars[lane // 4], ir.Constant(ir.IntType(32), lane))
            return vector

        def picked(vector, lanes) -> ir.Value:
            mask = ir.Constant(ir.VectorType(ir.IntType(32), len(lanes)), list(lanes))
            return builder.shuffle_vector(vector, vector, mask)

        def larger(a, b) -> ir.Value:
            return builder.select(builder.fcmp_ordered(">", a, b), a, b)

        away, summed = spread([middle] * 4), None
        farthest = None
        for place, row in zip(places_, rows, strict=True):
            there = builder.bitcast(builder.gep(bits, [place]), half.as_pointer())
            line = builder.bitcast(builder.shl(builder.zext(builder.load(there, align=2), whole),
                                               ir.Constant(whole, [13] * 16)), real)
            term = builder.fmul(line, spread([row] * 4), flags=("contract",))
            off = builder.fsub(line, away)
            off = larger(off, builder.fneg(off))
            summed = term if summed is None else builder.fadd(summed, term, flags=("contract",))
            farthest = off if farthest is None else larger(farthest, off)
        weighed = builder.fmul(summed, spread(columns))
        eight = builder.fadd(picked(weighed, range(8)), picked(weighed, range(8, 16)))
        four = builder.fadd(picked(eight, range(4)), picked(eight, range(4, 8)))
        two = larger(picked(farthest, (3, 7)), picked(farthest, (11, 15)))
        numbers_ = [builder.extract_element(four, ir.Constant(ir.IntType(32), k)) for k in range(3)]
        last = larger(*(builder.extract_element(two, ir.Constant(ir.IntType(32), k)) for k in range(2)))
        return context.make_tuple(builder, signature.return_type, [*numbers_, last])

    four = types.UniTuple(types.float32, 4)
    return four(numbers, types.UniTuple(types.intp, 4), four, four, types.float32), build
