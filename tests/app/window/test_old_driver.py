"""A driver whose OpenGL is too old for the window, as Mesa can pretend to be."""

import os
import subprocess
import sys

import pytest


@pytest.mark.slow
@pytest.mark.parametrize("offered, driver", [("2.1", {"MESA_GL_VERSION_OVERRIDE": "2.1"}),
                                             ("3.2", {"MESA_GL_VERSION_OVERRIDE": "3.2"}),
                                             ("none", {"__EGL_VENDOR_LIBRARY_FILENAMES": "/no-such-driver"})])
def test_an_old_driver_is_named_with_what_the_window_needs(offered, driver, tmp_path):
    done = subprocess.run([sys.executable, "-m", "lensbench.app.command.main", "view", "--screenshot",
                           str(tmp_path / "window.png")], capture_output=True, text=True,
                          env={**os.environ, "LIBGL_ALWAYS_SOFTWARE": "1", **driver})
    assert done.returncode == 2 and "IM_ASSERT" not in done.stderr and "Traceback" not in done.stderr
    *glfw, said = done.stderr.splitlines()
    assert said == (f"lensbench: the window needs OpenGL 3.3, and this driver offers {offered}: install a newer one; "
                    "`lensbench render` needs none")
    assert all(line.startswith("Glfw Error") for line in glfw)
