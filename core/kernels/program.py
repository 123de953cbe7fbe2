"""Programs: lists of stages that run over blocks of lanes.

The driver receives stages as addresses of machine code: it is compiled once for all pictures, and contains no copy of a
stage. What is not worth a kernel is a `PythonStage`, a function of numpy that one compiled stage calls for every block;
the interpreter runs one block at a time, whatever the number of threads. An exception ends the block; `raise_pending`
raises it after the run, on the thread that ran.
"""

import ctypes
import threading
from collections.abc import Callable, Sequence
from functools import cache
from itertools import count
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np
from llvmlite import ir
from numba import from_dtype, int64, types, uint32, void
from numba.core import cgutils
from numba.extending import intrinsic

from lensbench.core.kernels.block import (
    ALIVE, BLUE, GREEN, KEYS, LIT, LOST, PITCH, PIXEL, RED, ROWS, SAMPLE, SEED, V0, V1, WEIGHT, B, Step, lane_buffer,
    rows, stage
)
from lensbench.core.kernels.cache import is_compiled, njit

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


def stage_signature(real):
    """Signature of a stage for lanes of the type `real`."""
    number = from_dtype(np.dtype(real))
    return void(number[::1], number[::1], int64[::1], uint32[::1])


@cache
def stage_address(kernel, real) -> int:
    """Address of the machine code of a stage, for lanes of the type `real`; RuntimeError where numba knows none."""
    kernel.compile(stage_signature(real))
    made = kernel.get_compile_result(stage_signature(real))
    address: int = made.library.get_pointer_to_function(made.fndesc.llvm_func_name)
    if not address:                         # a call of it would end the process
        raise RuntimeError(f"the machine code of the stage {kernel.__name__} is lost: start lensbench again")
    return address


def is_stage_compiled(kernel, real) -> bool:
    """Whether `stage_address` finds the machine code of a stage and need not compile it."""
    return is_compiled(kernel, stage_signature(real))


@intrinsic
def call_stage(typing, address, lanes, p, ints, key):
    """Call the stage at this address."""
    def build(context, builder, signature, arguments):
        kinds, convention = signature.args[1:], context.call_conv
        pointer = convention.get_function_type(types.none, kinds).as_pointer()
        status, _ = convention.call_function(builder, builder.inttoptr(arguments[0], pointer),
                                             types.none, kinds, arguments[1:])
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return context.get_dummy_value()

    return types.none(address, lanes, p, ints, key), build


class Code(NamedTuple):
    """The steps of a Program as the driver reads them."""

    addresses: np.ndarray       # of the machine code of each stage
    gated: np.ndarray           # whether each waits for ALIVE,
    lights: np.ndarray          # and for LIT
    numbers: np.ndarray         # parameters of all steps, one after the other
    integers: np.ndarray        # integers of all steps
    ends: np.ndarray            # (2, steps + 1): where those of each step begin and end in both


class Program:
    """Steps packed for the driver, with parameters of the type `real`."""

    def __init__(self, steps: Sequence[Step], real=np.float32):
        numbers = [np.ravel(np.asarray(step.parameters, real)) for step in steps]
        integers = [np.ravel(np.asarray(step.integers, np.int64)) for step in steps]
        self.real = real
        self._called = [step.calls for step in steps if step.calls is not None]
        self.kept = [step.kept for step in steps]
        self.code = Code(np.array([stage_address(step.kernel, real) for step in steps], np.int64),
                         np.array([step.gated for step in steps], np.bool_),
                         np.array([step.lights for step in steps], np.bool_),
                         np.concatenate([*numbers, np.zeros(1, real)]), np.concatenate([*integers, [0]]),
                         np.array([np.cumsum([0] + [row.size for row in parts]) for parts in (numbers, integers)]))

    def expose(self, film: np.ndarray, lanes: np.ndarray, first: int, last: int, sample: int | np.ndarray,
               samples: int | np.ndarray, seed: np.uint32, origin: int = 0, weight: float | np.ndarray = 1.0) -> None:
        """Add samples `sample` … `sample` + `samples` − 1 to the blocks first … last − 1 of the film, (blocks, 3 B).

        sample, samples, and the weight of each in the sums: numbers, or arrays (last − first,) with one for each block.
        origin: the block that is the first one in `film`.
        """
        spans = np.empty((2, last - first), np.int64)
        weights = np.empty(last - first, self.real)
        spans[0], spans[1], weights[:] = sample, samples, weight
        _expose(film, lanes, self.code, first, last, spans, weights, seed, origin)
        if self._called:
            raise_pending()

    def run(self, inputs: dict[int, np.ndarray], outputs: Sequence[int], n: int) -> np.ndarray:
        """The rows `outputs`, (len(outputs), n), of n lanes after one run of the steps.

        inputs: {row: (n,) values}; the other rows begin as in `lane_buffer`. The last block is filled up with the last
        lane.
        """
        table = np.zeros((len(inputs), n), self.real)
        for j, values in enumerate(inputs.values()):
            table[j] = values
        out = np.empty((len(outputs), n), self.real)
        _run(table, np.array(list(inputs), np.int64), out, np.array(list(outputs), np.int64), lane_buffer(self.real),
             self.code)
        if self._called:
            raise_pending()
        return out


@stage
def accumulate(lanes, film, share):
    """Add the weighted colours of a block, times a share, to the film's sums: B each of red, green and blue."""
    real = lanes.dtype.type
    row = rows(lanes)
    weight, red, green, blue = row[WEIGHT], row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        w = share * weight[i]
        alive = w > real(0)
        film[i] += w * red[i] if alive else real(0)
        film[B + i] += w * green[i] if alive else real(0)
        film[2 * B + i] += w * blue[i] if alive else real(0)


@njit(nogil=True, cache=True, error_model="numpy")
def run_steps(lanes, code, key):
    """Run the steps of a Program, given by its code, over one block."""
    key[ALIVE] = key[LIT] = uint32(1)
    numbers, integers = code.ends
    for s in range(code.addresses.size):
        if key[ALIVE] == LOST:
            return
        if (key[ALIVE] != 0 or not code.gated[s]) and (key[LIT] != 0 or not code.lights[s]):
            call_stage(code.addresses[s], lanes, code.numbers[numbers[s]:numbers[s + 1]],
                       code.integers[integers[s]:integers[s + 1]], key)


@njit(nogil=True, cache=True, error_model="numpy")
def _expose(film, lanes, code, first, last, samples, weights, seed, origin):
    """samples: (2, last - first), the number of the first sample of each block, and how many it has."""
    key = np.empty(KEYS, np.uint32)
    key[SEED] = seed
    for i in range(last - first):
        key[PIXEL] = (first + i) * B
        for k in range(samples[0, i], samples[0, i] + samples[1, i]):
            key[SAMPLE] = k
            run_steps(lanes, code, key)
            accumulate(lanes, film[first + i - origin], weights[i])


@njit(nogil=True, cache=True, error_model="numpy")
def _run(table, inputs, out, outputs, lanes, code):
    key = np.zeros(KEYS, np.uint32)
    n = out.shape[1]
    for start in range(0, n, B):
        key[PIXEL] = start
        lanes[:] = 0
        lanes[V0 * PITCH:(V1 + 1) * PITCH] = 0.5
        for j in range(inputs.size):
            for i in range(B):
                lanes[inputs[j] * PITCH + i] = table[j, min(start + i, n - 1)]
        run_steps(lanes, code, key)
        for j in range(outputs.size):
            for i in range(min(B, n - start)):
                out[j, start + i] = lanes[outputs[j] * PITCH + i]
