"""A wheel carries every compiled function that lensbench needs on its own, and that list follows from the sources."""

import pickle
import subprocess
import sys

import pytest

from lensbench.app.workers.shipped_kernels import called_kernels, is_stage
from lensbench.core.design import tolerance_rays
from lensbench.core.kernels import sampling
from lensbench.core.optics import scalar_trace, surfaces
from lensbench.core.scenery.intersect import meshes
from lensbench.core.scenery.shading import illumination


@pytest.mark.slow
def test_the_functions_that_python_code_names_are_found_and_their_parts_are_not():
    kernels = called_kernels()
    names = {(kernel.py_func.__module__, kernel.py_func.__qualname__) for kernel in (
        meshes._distances, tolerance_rays.judge_copies, tolerance_rays.trace_copies, scalar_trace.trace_ray,
        surfaces._sags, sampling.sample_pixels)}
    assert names <= kernels.keys()
    for function in (sampling.mix, illumination.rise):          # of kernels alone, and also called without compilation
        assert (function.py_func.__module__, function.py_func.__qualname__) not in kernels
    assert is_stage(sampling.sample_pixels) and not is_stage(scalar_trace.trace_ray)


@pytest.mark.slow
@pytest.mark.long
def test_every_one_of_them_is_asked_for_where_a_wheel_is_built(tmp_path):
    """The wheel lacked seven: those of tolerances, of single rays, and of distances to meshes."""
    subprocess.run([sys.executable, "-m", "lensbench.app.workers.shipped_kernels", "--asked", str(tmp_path / "listed")],
                   check=True, capture_output=True)
    asked = pickle.loads((tmp_path / "listed").read_bytes())
    assert called_kernels().keys() <= {(kernel.module, kernel.name) for kernel in asked}
