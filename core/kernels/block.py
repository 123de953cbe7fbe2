"""Stages and the lane buffer that they work on.

A *lane* is one sample on its way from a pixel to a colour. B lanes travel together as a *block*: a compact piece of the
film (`sampling`), a sample for each pixel. All values of a block lie in one flat array, the *lane buffer*, cut into
rows of B numbers; a row holds one quantity for every lane. A *stage* reads some rows and writes others, and a picture
is a list of stages.

    CENTRE, RADIUS, COLOUR, BALL = offsets(3, 1, 3)

    def ball_parameters(ball):
        return pack(BALL, {CENTRE: ball.centre, RADIUS: ball.radius, COLOUR: ball.colour})

    @stage
    def balls(lanes, p, ints, key):
        row = rows(lanes)
        x, (cx, cy, cz) = row[X], vector(p, CENTRE)
        for i in range(B):
            ...

lanes  the lane buffer, float32 or float64
p      the parameters of this stage, numbers of the same type, by the names of their offsets: module-level integers,
       which the compiler knows
ints   the integers of this stage (int64): counts, indices and kinds, which float32 holds exactly up to 2²⁴ only
key    which block this is (uint32): PIXEL, SAMPLE, SEED; and ALIVE and LIT. A stage sets ALIVE to 0 to skip the gated
       steps after it, or to LOST, where every WEIGHT is 0, to skip all; LIT to 0 to skip the steps after it that add
       light to an albedo

A stage is fast if it has one loop over range(B) for each idea and no branch (choose by `a if c else b`), marks a
blocked ray by NaN, looks up tables by `gather`, and writes constants as real(0.5), where real = lanes.dtype.type. So
float32 and float64 come from one source, and float32 is never widened. (math.floor widens: it returns an integer, and
an integer times a float32 is a float64. Use np.floor.)
"""

from collections.abc import Mapping
from functools import partial
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import ArrayLike

from lensbench.core.kernels.cache import njit


class Packed(NamedTuple):
    """Parameters and integers of a stage, or of a part of one."""

    parameters: np.ndarray
    integers: ArrayLike = ()


def join(*parts: Packed) -> Packed:
    """The parameters of all parts, one after the other, and their integers."""
    return Packed(np.concatenate([np.zeros(0), *(packed.parameters for packed in parts)]),
                  np.concatenate([np.zeros(0, np.int64), *(np.asarray(packed.integers, np.int64) for packed in parts)]))


def offsets(*widths: int) -> tuple[int, ...]:
    """First indices of consecutive fields of these widths, then the total width."""
    return tuple(accumulate((0, *widths)))


def pack(size: int, fields: Mapping[int, ArrayLike]) -> np.ndarray:
    """Array of `size` numbers with each field at its offset, the rest 0."""
    packed = np.zeros(size)
    for offset, values in fields.items():
        if isinstance(values, float | int):             # most are: ten times as fast as an array of one
            packed[offset] = values
            continue
        numbers = np.atleast_1d(values)
        packed[offset:offset + numbers.size] = numbers
    return packed


@njit(inline="always")
def vector(p, k):
    """Three consecutive numbers."""
    return p[k], p[k + 1], p[k + 2]


B = 512
PITCH = B + 16                  # numbers from row to row; with a power of two all rows would share cache lines

(U0, U1,                        # pupil sample, in [0, 1)²
 V0, V1,                        # light sample, in [0, 1)²
 TIME,                          # first in [0, 1) of the shutter, then in seconds since it opens
 X, Y, Z,                       # first X, Y in raster pixels; then a point of the ray (mm)
 L, M, N,                       # direction of the ray, a unit vector
 WEIGHT,                        # what the camera lets through; 0 for a lost ray
 CLEARANCE,                     # greatest (r / semi-diameter)² of the ray in a lens; NaN or > 1: blocked
 PIXEL_SIDE, PIXEL_SPREAD,      # footprint of a pixel, or of its part: side at the ray's origin (mm), growth per mm
 PUPIL_RADIUS, PUPIL_SPREAD,    # footprint of the pupil, or of its part: radius at the origin (mm), growth per mm
 OX, OY, OZ,                    # offset of this ray from the middle of its part of the pupil, in these radii
 DEPTH, NX, NY, NZ,             # nearest surface: distance along the ray (mm), unit normal towards the ray
 EMITS,                         # what the surface emits, a number of `scenery/surface_codes.py`
 FINISH,                        # how the surface reflects, a number of `scenery/surface_codes.py`
 PATH,                          # what the path has met, a number of `scenery/surface_codes.py`
 RED, GREEN, BLUE,              # albedo or radiance; at last the colour of the sample
 TR, TG, TB,                    # throughput of a path after specular bounces
 SR, SG, SB,                    # sum of the radiance that a path has gathered so far
 A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, A11,  # scratch; undefined after a stage
 H0, H1, H2, H3, H4, H5, H6, H7, H8,            # saved by a stage while others work in the frame of a moving object
 BEAM,                                          # of the block, not of its lanes: bounds of its rays
 ) = range(58)
ROWS = 58
# Scratch rows that a stage leaves for later ones, which the stages between keep (`test_scratch_rows`). SHADOW_RAY: of
# lit lanes the lit point (mm), the unit direction to a light, and its distance (mm); ARRIVING: the light along it,
# which shadows darken; TINT: its colour where lanes differ; ONWARD: where a path goes on: point (mm), unit direction,
# and a mark
SHADOW_RAY, ARRIVING, TINT = (A0, A1, A2, A3, A4, A5, A6), A7, (A8, A9, A10)
ONWARD = (H0, H1, H2, H3, H4, H5, H6)

PIXEL, SAMPLE, SEED, ALIVE, LIT, KEYS = range(6)        # entries of key, and their number
LOST = 2                        # value of key[ALIVE] where no lane has a WEIGHT


class Step(NamedTuple):
    """A stage with its parameters and integers; a gated step is skipped while key[ALIVE] is 0.

    calls: the `PythonStage` that the step calls, which must live as long as the step; None for compiled stages.
    kept: arrays whose addresses are among the integers (`borrowed`). lights: skipped while key[LIT] is 0.
    """

    kernel: Any
    parameters: Any = ()
    integers: Any = ()
    gated: bool = False
    calls: Any = None
    kept: Any = ()
    lights: bool = False


def stage(kernel=None, *, inlined=False, allocates=False):
    """A stage compiled for speed, in which NaN and infinity keep their meaning.

    One that was typed at a prompt or in a notebook is compiled once in every session; the others are cached.
    inlined: a function that stages call, which becomes a part of their code. Without it a process that compiled the
    function by itself calls that code, rounded otherwise in the last place than the copy that the stage carries.
    allocates: the stage makes arrays of its own (np.empty, an array expression), as those of users may. For all other
    stages numba counts no references to arrays (`_nrt`), a fourteenth of the time to compile them.
    """
    if kernel is None:
        return partial(stage, inlined=inlined, allocates=allocates)
    kept = Path(kernel.__code__.co_filename).is_file()
    own = kernel.__module__.partition(".")[0] == __name__.partition(".")[0]
    return njit(fastmath={"contract", "nsz", "arcp"}, error_model="numpy", nogil=True, cache=kept,
                forceinline=inlined, _nrt=allocates or not own)(kernel)


def lane_buffer(real=np.float32) -> np.ndarray:
    """A lane buffer for one thread: ROWS * PITCH numbers that begin on a cache line.

    All are 0 but V0 and V1, which are 0.5: the middle of a light, for scenes without soft shadows.
    """
    size = np.dtype(real).itemsize
    raw = np.zeros(ROWS * PITCH + 64 // size, real)
    skip = -raw.ctypes.data % 64 // size
    lanes = raw[skip:skip + ROWS * PITCH]
    lanes[V0 * PITCH:(V1 + 1) * PITCH] = 0.5
    return lanes


@intrinsic
def rows(typing, lanes):
    """The lane buffer as a table of ROWS rows with pitch and count known at compile time.

    An ordinary two-dimensional array might overlap itself as far as the compiler knows;
    its loops would not be vectorised, and run fifteen times slower.
    """
    view = types.Array(lanes.dtype, 2, "C")

    def build(context, builder, signature, arguments):
        from numba.np.arrayobj import make_array, populate_array  # late: no stored kernel needs it

        def number(n):
            return context.get_constant(types.intp, n)

        size = lanes.dtype.bitwidth // 8
        flat = make_array(lanes)(context, builder, arguments[0])
        table = make_array(view)(context, builder)
        populate_array(table, data=flat.data, meminfo=None, parent=None, itemsize=number(size),
                       shape=[number(ROWS), number(PITCH)], strides=[number(PITCH * size), number(size)])
        return table._getvalue()

    return view(lanes), build


class _Addresses(ir.Instruction):
    """Addresses of many elements of a table: a vector instruction that llvmlite's builder lacks."""

    def __init__(self, block, number, table, index):
        super().__init__(block, ir.VectorType(table.type, index.type.count), "getelementptr", [table, index])
        self.number = number

    def descr(self, buf):
        """Write the instruction as LLVM text."""
        table, index = self.operands
        buf.append(f"getelementptr {self.number}, {table.type} {table.get_reference()}, "
                   f"{index.type} {index.get_reference()}\n")


@intrinsic
def weigh_four(typing, table, places, shares):
    """Σ shares[k] · table[places[k] : places[k] + 4], k = 0 … 3, as a tuple of four numbers.

    Each four numbers are one load: faster than `gather` where they lie side by side.
    """
    number = table.dtype

    def build(context, builder, signature, arguments):
        from numba.np.arrayobj import make_array  # late: no stored kernel needs it

        kind, size = context.get_value_type(number), number.bitwidth // 8
        four = ir.VectorType(kind, 4)
        data = make_array(signature.args[0])(context, builder, arguments[0]).data
        total = None
        for k in range(4):
            offset = builder.zext(builder.extract_value(arguments[1], k), ir.IntType(64))
            texel = builder.load(builder.bitcast(builder.gep(data, [offset]), four.as_pointer()), align=size)
            share, spread = builder.extract_value(arguments[2], k), ir.Constant(four, ir.Undefined)
            for i in range(4):
                spread = builder.insert_element(spread, share, ir.Constant(ir.IntType(32), i))
            term = builder.fmul(spread, texel, flags=("contract", "nsz"))
            total = term if total is None else builder.fadd(total, term, flags=("contract", "nsz"))
        elements = [builder.extract_element(total, ir.Constant(ir.IntType(32), i)) for i in range(4)]
        return context.make_tuple(builder, signature.return_type, elements)

    return types.UniTuple(number, 4)(table, places, shares), build


@intrinsic
def gather(typing, out, table, index):
    """out[i] = table[int(index[i])] for all lanes; every index must be finite and within the table.

    The compiler does not vectorise such a loop, since the table might overlap the
    lanes; this emits the processor's gather instruction.
    """
    def build(context, builder, signature, arguments):
        from numba.np.arrayobj import make_array  # late: no stored kernel needs it

        number, bits = context.get_value_type(signature.args[0].dtype), signature.args[0].dtype.bitwidth
        width, size, word = 512 // bits, bits // 8, ir.IntType(32)
        o, t, x = (make_array(kind)(context, builder, value).data
                   for kind, value in zip(signature.args, arguments, strict=True))
        vector, chosen = ir.VectorType(number, width), ir.VectorType(ir.IntType(1), width)
        places = ir.VectorType(t.type, width)
        fetch = cgutils.get_or_insert_function(builder.module, ir.FunctionType(vector, [places, word, chosen, vector]),
                                               f"llvm.masked.gather.v{width}f{bits}.v{width}p0")
        with cgutils.for_range(builder, context.get_constant(types.intp, B // width)) as loop:
            offset = builder.mul(loop.index, context.get_constant(types.intp, width))
            indices = builder.load(builder.bitcast(builder.gep(x, [offset]), vector.as_pointer()), align=size)
            address = _Addresses(builder.block, number, t, builder.fptosi(indices, ir.VectorType(word, width)))
            builder._insert(address)
            values = builder.call(fetch, [address, word(size), ir.Constant(chosen, [1] * width),
                                         ir.Constant(vector, ir.Undefined)])
            builder.store(values, builder.bitcast(builder.gep(o, [offset]), vector.as_pointer()), align=size)
        return context.get_dummy_value()

    return types.none(out, table, index), build
