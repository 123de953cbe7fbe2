"""Large arrays that stages read where they lie: textures, skies and trees of triangles.

Parameters are copied into the type of the lanes for every program that uses them. An array of hundreds of megabytes is
not: a step names its address in the integers, and keeps the array alive in `Step.kept`.

    step = Step(wall, parameters, [address(texels), texels.size], kept=(texels,))

    @stage
    def wall(lanes, p, ints, key):
        texels = borrowed(ints[0], ints[1], np.uint16)
"""

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


def address(array: np.ndarray) -> int:
    """Address of the first number of a contiguous array."""
    if not array.flags.c_contiguous:
        raise ValueError("a borrowed array must be contiguous")
    return array.ctypes.data


@intrinsic
def borrowed(typing, place, count, kind):
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

    return view(place, count, kind), build
