"""Compiled code that is stored and read again."""

import gc
import pickle

import numpy as np
from numba import njit
from numba.core import serialize
from numba.core.environment import Environment

from lensbench.core.kernels.compiled_code import CodeReducer


def test_a_stored_kernel_keeps_the_constants_of_the_functions_that_it_calls_alive():
    @njit
    def total(values):
        return values.sum()

    assert total(np.arange(4.0)) == 6.0
    made = total.overloads[total.signatures[0]]
    stored = serialize.dumps(CodeReducer().reduce(made))
    payload = pickle.loads(stored)
    assert payload[-1]                                      # that of the sum of an array
    assert all(type(each) is tuple for each in payload[-1])
    result = CodeReducer().rebuild(total.targetctx, payload)
    gc.collect()
    assert [each.env_name for each in result.referenced_envs] == [name for _, _, name in payload[-1]]
    assert all(isinstance(each, Environment) for each in result.referenced_envs)
    assert result.entry_point(np.arange(5.0)) == 10.0
