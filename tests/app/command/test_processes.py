"""The command line as a process: interrupted, and with a reader that goes away."""

import os
import signal
import subprocess
import sys

import pytest

NEVER_DONE = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)        # what runs in the background is born to ignore it
from lensbench.app.command import main
from lensbench.app.session import export
add = export.lb.Rendering.add
def told(*given):
    print("rendering", flush=True)
    return add(*given)
export.lb.Rendering.add = told
sys.exit(main.main(["render", "pbrt-dgauss-50mm", "--samples", "999999999", "--size", "60x40", "-o", sys.argv[1]]))
"""


@pytest.mark.parametrize(("number", "code"), [
    pytest.param(signal.SIGINT, 130, marks=pytest.mark.slow), (signal.SIGTERM, 143)])
def test_an_interrupted_render_leaves_the_old_file_and_nothing_else(tmp_path, number, code):
    (tmp_path / "a.png").write_bytes(b"the old file")
    with subprocess.Popen([sys.executable, "-c", NEVER_DONE, str(tmp_path / "a.png")], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True) as running:
        assert running.stdout.readline() == "rendering\n"
        running.send_signal(number)
        _, err = running.communicate()
    assert running.returncode == code
    assert len(err.splitlines()) <= 1
    assert os.listdir(tmp_path) == ["a.png"]
    assert (tmp_path / "a.png").read_bytes() == b"the old file"


def test_a_reader_that_has_seen_enough_is_no_failure():
    with subprocess.Popen([sys.executable, "-m", "lensbench.app.command.main", "lenses", "--json"], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        running.stdout.close()
        assert running.stderr.read() == ""
    assert running.returncode == 0


MEASURED = """
import sys
from pathlib import Path
from lensbench.app.command import main
code = main.main(sys.argv[1:])
status = Path("/proc/self/status").read_text()      # ru_maxrss would count the process that began this one
print(code, 1024 * int(status.partition("VmHWM:")[2].split()[0]))
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="its figures of memory")
def test_a_picture_of_24_megapixels_takes_little_memory(tmp_path):
    """Sums and pixels of the whole picture alone take 576 MB; measured: 370 MB, 62 of them programs on the disk."""
    for size in ("60x40", "6000x4000"):         # the first one compiles
        run = subprocess.run([sys.executable, "-c", MEASURED, "render", "pbrt-dgauss-50mm", "--size", size, "--samples",
                              "1", "-o", str(tmp_path / "a.ppm")], capture_output=True, text=True, check=True)
        code, peak = map(int, run.stdout.splitlines()[-1].split())
        assert code == 0
    assert peak < 410e6


# The README
