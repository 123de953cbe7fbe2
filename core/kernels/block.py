"""The workbench: what a stage is, and where it finds the samples that it works on.

A *lane* is one sample on its way from a pixel to a colour. B lanes travel
together as a *block*: a compact piece of the film (`strips`), a sample for each
pixel. All that is known of a block lies in one flat array, cut into rows of B
numbers; a row holds one quantity for every lane. A *stage* reads some rows and
writes others, and a picture is a list of stages.

    @stage
    def pinhole(lanes, p, key):
        row = rows(lanes)
        x, y = row[X], row[Y]
        for i in range(B):
            ...

lanes  the workbench, float32 or float64
p      the parameters of this stage, numbers of the same type
key    which block this is (uint32): PIXEL, SAMPLE, SEED, and ALIVE, which a
       stage may set to 0 to have the gated steps after it skipped, or to LOST
       where no lane has any WEIGHT left: then all steps after it are

What makes a stage fast: one loop over range(B) for each idea, no branch
(choose by `a if c else b`), a lost ray is a NaN, a look-up in a table gets a
`gather` of its own, and a number that is neither lane nor parameter is written
real(0.5), where real = lanes.dtype.type. So float32 and float64 come from one
source, and float32 never widens by accident. (math.floor is such an accident: it
gives an integer, and an integer times a float32 is a float64. Use np.floor.)
"""

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

B = 512
PITCH = B + 16                  # from a row to the next: not a power of two, or all rows fall on the same cache lines

(U0, U1,                        # where in the pupil: two numbers in [0, 1)
 V0, V1,                        # where on a light: two numbers in [0, 1)
 TIME,                          # when, in [0, 1) of the shutter
 X, Y, Z, L, M, N,              # first X, Y in raster pixels; then the ray, a point (mm) and a unit direction
 WEIGHT,                        # what the camera lets through: 0 where the ray is lost
 CLEARANCE,                     # greatest (r / semi-diameter)² on the way through a lens; NaN or > 1 is blocked
 PIXEL_SIDE, PIXEL_SPREAD,      # of a pixel, or its part: side where the ray begins (mm), and by how much a mm adds
 PUPIL_RADIUS, PUPIL_SPREAD,    # of the pupil, or its part: radius where the ray begins (mm), and what a mm adds
 OX, OY, OZ,                    # in these radii: from the ray through the middle of such parts to the ray itself
 DEPTH, NX, NY, NZ,             # the nearest surface: distance along the ray (mm) and unit normal towards the ray
 EMITS,                         # above 0 where RED, GREEN, BLUE are emitted radiance, else they are albedo
 GLOSS,                         # 0 matte, (0, 1] a clear coat over it, METAL, GLASS
 SPECULAR,                      # 1 where the path was bent by a thing, and small lights that it meets now are black
 RED, GREEN, BLUE,              # albedo, or radiance; at last the colour of the sample
 TR, TG, TB,                    # what a mirrored path carries on to its next surface
 SR, SG, SB,                    # what a mirrored path has gathered so far
 A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, A11,  # anyone's scratch: worth nothing after the stage
 H0, H1, H2, H3, H4, H5, H6, H7, H8,            # held by a stage while others work in the frame of what moves
 BEAM,                                          # of no lane, but of all: where the rays of the block can reach
 ) = range(58)
ROWS = 58

METAL, GLASS = 2.0, 3.0         # values of GLOSS

PIXEL, SAMPLE, SEED, ALIVE = range(4)       # the entries of key
KEYS = 4
LOST = 2                        # a value of key[ALIVE]


class Step(NamedTuple):
    """One stage of a picture with its parameters; a gated step is skipped while key[ALIVE] is 0."""

    kernel: Any
    parameters: Any
    gated: bool = False


def stage(kernel):
    """Compile a stage: NaN and infinity keep their meaning, the rest is for speed."""
    return njit(fastmath={"contract", "nsz", "arcp"}, error_model="numpy", nogil=True, cache=True)(kernel)


def lane_buffer(real=np.float32) -> np.ndarray:
    """A fresh workbench for one thread: ROWS * PITCH numbers, on a cache line of its own.

    All are 0 but V0 and V1: where nobody draws a point of a light, its middle stands for it.
    """
    size = np.dtype(real).itemsize
    raw = np.zeros(ROWS * PITCH + 64 // size, real)
    skip = -raw.ctypes.data % 64 // size
    lanes = raw[skip:skip + ROWS * PITCH]
    lanes[V0 * PITCH:(V1 + 1) * PITCH] = 0.5
    return lanes


@intrinsic
def rows(typing, lanes):
    """See the workbench as ROWS rows whose places are known when compiling.

    To the compiler an ordinary two-dimensional array might overlap itself, and
    its loops then run one lane at a time: fifteen times slower.
    """
    view = types.Array(lanes.dtype, 2, "C")

    def build(context, builder, signature, arguments):
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
    """The addresses of many elements of one table, which the builder has no call for."""

    def __init__(self, block, number, table, index):
        super().__init__(block, ir.VectorType(table.type, index.type.count), "getelementptr", [table, index])
        self.number = number

    def descr(self, buf):
        """Write the instruction."""
        table, index = self.operands
        buf.append(f"getelementptr {self.number}, {table.type} {table.get_reference()}, "
                   f"{index.type} {index.get_reference()}\n")


@intrinsic
def gather(typing, out, table, index):
    """out[i] = table[int(index[i])] for all lanes; every index must be finite and within the table.

    A loop of this kind is not vectorised, for the compiler cannot know that
    the table does not overlap the lanes; the instruction for it exists.
    """
    def build(context, builder, signature, arguments):
        number, bits = context.get_value_type(signature.args[0].dtype), signature.args[0].dtype.bitwidth
        width, size, word = 512 // bits, bits // 8, ir.IntType(32)
        o, t, x = (make_array(kind)(context, builder, value).data
                   for kind, value in zip(signature.args, arguments, strict=True))
        many, chosen = ir.VectorType(number, width), ir.VectorType(ir.IntType(1), width)
        places = ir.VectorType(t.type, width)
        fetch = cgutils.get_or_insert_function(builder.module, ir.FunctionType(many, [places, word, chosen, many]),
                                               f"llvm.masked.gather.v{width}f{bits}.v{width}p0")
        with cgutils.for_range(builder, context.get_constant(types.intp, B // width)) as loop:
            at = builder.mul(loop.index, context.get_constant(types.intp, width))
            wanted = builder.load(builder.bitcast(builder.gep(x, [at]), many.as_pointer()), align=size)
            address = _Addresses(builder.block, number, t, builder.fptosi(wanted, ir.VectorType(word, width)))
            builder._insert(address)
            found = builder.call(fetch, [address, word(size), ir.Constant(chosen, [1] * width),
                                         ir.Constant(many, ir.Undefined)])
            builder.store(found, builder.bitcast(builder.gep(o, [at]), many.as_pointer()), align=size)
        return context.get_dummy_value()

    return types.none(out, table, index), build
