"""What a start to the first picture imports, and what it leaves for later."""

import subprocess
import sys

LATE = {"numba.np.arrayobj", "numba.np.arraymath", "lensbench.app.studies.charts.sheet"}


def test_a_start_imports_no_code_of_numba_for_arrays_and_no_chart():
    done = subprocess.run([sys.executable, "-X", "importtime", "-m", "lensbench.app.command.start", "0"],
                          capture_output=True, text=True, check=True, timeout=300)
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines() if line.startswith("import time")}
    assert float(done.stdout.split()[-1]) > 0.0                # the time of a first picture
    assert {"numba", "imgui_bundle", "lensbench.app.window.window"} < imported
    assert not LATE & imported
