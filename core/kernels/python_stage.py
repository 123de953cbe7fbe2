"""Stages in Python: functions of numpy that work on the lanes of a block, for what is not worth a kernel.

One compiled stage calls back into Python for every block of B lanes. The interpreter runs one block at a time, whatever
the number of threads. An exception ends the block; `raise_pending` raises it after the run, on the thread that ran.
"""

import ctypes
import threading
from collections.abc import Callable
from itertools import count
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from lensbench.kernels.block import ALIVE, KEYS, LOST, PITCH, ROWS, WEIGHT, B, Step, stage

ADDRESS, NUMBER = range(2)              # integers of `call_python`: address of the callback, number of the function


class PythonStage:
    """Function of the rows (ROWS, B) of a block, which it reads and writes."""

    def __init__(self, function: Callable[[np.ndarray], None]):
        self.function = function
        self._number = next(_NUMBERS)
        _STAGES[self._number] = self

    @property
    def step(self) -> Step:
        """Step that calls the function."""
        return Step(call_python, (), (_ADDRESS, self._number), calls=self)


_NUMBERS = count(1)
_STAGES: "WeakValueDictionary[int, PythonStage]" = WeakValueDictionary()
_pending = threading.local()


def raise_pending() -> None:
    """Raise the first exception of a Python stage on this thread since the last call, if there was one."""
    error = getattr(_pending, "error", None)
    _pending.error = None
    if error is not None:
        raise error


def _dispatch(number: int, lanes: int, size: int, key: int) -> None:
    """Run the function with this number on the block at these addresses; size: bytes of a number in the lanes."""
    memory: Any = (ctypes.c_char * (ROWS * PITCH * size)).from_address(lanes)
    table = np.frombuffer(memory, f"f{size}").reshape(ROWS, PITCH)[:, :B]
    try:
        if getattr(_pending, "error", None) is None:
            _STAGES[number].function(table)
            return
    except BaseException as error:          # KeyboardInterrupt too: C cannot pass it on
        _pending.error = error
    table[WEIGHT] = 0.0
    memory = (ctypes.c_char * (KEYS * 4)).from_address(key)
    np.frombuffer(memory, "u4")[ALIVE] = LOST


_CALLBACK = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 4)(_dispatch)
_ADDRESS = ctypes.cast(_CALLBACK, ctypes.c_void_p).value


@intrinsic
def _call(typing, address, number, lanes, size, key):
    """Call the C function void (int64 number, int64 lanes, int64 size, int64 key) at this address."""
    def build(context, builder, signature, arguments):
        word = ir.IntType(64)
        kind = ir.FunctionType(ir.VoidType(), [word] * 4)
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])
        return context.get_dummy_value()

    return types.none(types.int64, types.int64, types.int64, types.int64, types.int64), build


@stage
def call_python(lanes, p, ints, key):
    """Call the function of a PythonStage on this block. ints: ADDRESS, NUMBER."""
    _call(ints[ADDRESS], ints[NUMBER], np.int64(lanes.ctypes.data), np.int64(lanes.itemsize), np.int64(key.ctypes.data))
