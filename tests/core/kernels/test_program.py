"""Programs: a stage that numba has lost the machine code of."""

from types import SimpleNamespace

import numpy as np
import pytest

from lensbench.core.kernels.program import stage_address


def test_a_stage_without_machine_code_is_an_error_and_no_crash():
    library = SimpleNamespace(get_pointer_to_function=lambda name: 0)       # what numba answers where it knows none
    made = SimpleNamespace(library=library, fndesc=SimpleNamespace(llvm_func_name="lost"))
    kernel = SimpleNamespace(compile=lambda signature: None, get_compile_result=lambda signature: made, __name__="lost")
    with pytest.raises(RuntimeError, match="machine code of the stage lost"):
        stage_address.__wrapped__(kernel, np.float32)
