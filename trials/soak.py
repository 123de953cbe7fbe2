"""Random use of the window by mouse and keyboard: does its memory grow, does anything fail, does a thread stay?

python -m trials.soak --minutes 120 --seed 1

The window needs no display; its folder is empty at first. A tour comes first: every layout and panel, every scene and
camera, more lenses than a cache holds, every way to develop a picture, the lens browser until it has all pictures. What
a first use takes is then there, and what grows later is growth. After the tour come clicks, drags, wheel turns, keys
and text, on every panel of every layout; now and then another lens, scene and camera.

Printed once a minute: resident memory, frames, actions, and the parts of that memory. What is shown at that moment
takes 50 MB more or less, so that every few minutes the first settings and layout come back, rest, and are measured
alone; moments and light fields that were kept are removed then, for these are the user's. At the end: growth after the
tour and after 10, 20 and 40 minutes from its end (least squares, with its standard error), of all samples and of those
at rest, exceptions, threads left. Ends with 1 for an exception or a thread. A run of less than 20 minutes has no tour,
unless it is to hurry: then the tour waits for no picture.
"""

import argparse
import ctypes
import gc
import math
import os
import sys
import tempfile
import threading
import traceback
from collections.abc import Sequence
from pathlib import Path
from time import monotonic
from typing import Any

from trials.hand import Hand

SIZE = (1280, 720)
AFTER = (0.0, 10.0, 20.0, 40.0)                         # minutes after the tour, from which on growth is measured
SHARED = ("pymp", "lensbench analysis_")                # threads that stay for the next analysis, at most two
HOME = 5.0                                              # least minutes between two samples at rest
SHORT = 20.0                                            # minutes: a shorter run has no tour


def memory() -> float:
    """Resident memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


class Mallinfo(ctypes.Structure):
    """What glibc says of its heap, bytes."""

    _fields_ = tuple((name, ctypes.c_size_t) for name in (  # noqa: RUF012
        "arena", "ordblks", "smblks", "hblks", "mapped", "usmblks", "fsmblks", "used", "free", "keepcost"))


def parts() -> str:
    """The parts of the resident memory in words: what C's heap holds, what is free in it, small Python objects."""
    library = ctypes.CDLL(None)
    if not hasattr(library, "mallinfo2"):
        return ""
    library.mallinfo2.restype = Mallinfo
    heap = library.mallinfo2()
    return (f"heap {(heap.used + heap.mapped) / 1e6:.1f} MB used, {heap.free / 1e6:.1f} free; "
            f"{sys.getallocatedblocks() / 1e3:.0f} thousand Python blocks")


def growth(samples: Sequence[tuple[float, float]], after: float) -> tuple[float, float]:
    """MB a minute, by least squares, of (minutes, MB) from a time on, and its standard error."""
    import numpy as np

    late = np.array([sample for sample in samples if sample[0] >= after]).reshape(-1, 2)
    if len(late) < 4:
        return math.nan, math.nan
    slope, variance = np.polyfit(late[:, 0], late[:, 1], 1, cov=True)
    return float(slope[0]), math.sqrt(float(variance[0, 0]))


Samples = list[tuple[float, float]]                     # minutes, MB


def soak(minutes: float, hand: Hand) -> tuple[Samples, Samples, list[str]]:
    """Memory once a minute, memory at rest from the end of the tour on, and what failed."""
    from lensbench.app.window import window

    failures: list[str] = []

    def failed(*error: Any, **ignored: Any) -> None:
        raised = next(value for value in error if isinstance(value, BaseException))
        failures.append(hand.doing + "".join(traceback.format_exception(raised)))
        print(failures[-1], flush=True)

    sys.excepthook = failed
    threading.excepthook = lambda failure: failed(failure.exc_type, failure.exc_value, failure.exc_traceback)
    traceback.print_exception = failed                  # the window shows it and goes on
    before = set(threading.enumerate())
    session = window.Session(window.Settings(pixels_x=480, pixels_y=320, samples=64), remember=False, threads=2)
    window.without_display()
    runner = window.parameters(session, SIZE)
    runner.fps_idling.enable_idling = False
    start = monotonic()
    steps, samples, frames = hand.script(session, HOME), [(0.0, memory())], [0]
    rests: Samples = []

    def step() -> None:
        frames[0] += 1
        now = (monotonic() - start) / 60.0
        if now >= samples[-1][0] + min(1.0, minutes / 20.0):
            samples.append((now, memory()))
            print(f"{now:6.1f} min {samples[-1][1]:7.1f} MB {frames[0]} frames {hand.actions} actions "
                  f"{len(failures)} exceptions; {parts()}{'' if hand.toured else '; on tour'}", flush=True)
        if now >= minutes:
            runner.app_shall_exit = True
        elif session.presenter.update is not None:      # from the first picture on
            next(steps)
            if len(hand.rests) > len(rests) + 1:
                rests.append((now, memory()))
                print(f"{now:6.1f} min {rests[-1][1]:7.1f} MB at rest; {parts()}", flush=True)

    runner.callbacks.after_swap = step
    try:
        window.show(runner)
    except Exception as error:
        failed(error)
    gc.collect()
    left = [thread.name for thread in set(threading.enumerate()) - before if not thread.name.startswith(SHARED)]
    return samples, rests, failures + [f"a thread is left: {name}" for name in left]


def at_home(minutes: float, hand: Hand) -> tuple[Samples, Samples, list[str]]:
    """`soak` in an empty folder of its own, which is the home of the user and the current one."""
    os.environ.setdefault("XDG_CACHE_HOME", str(Path.home() / ".cache"))        # the kernels
    with tempfile.TemporaryDirectory() as home:
        os.environ["HOME"] = os.environ["XDG_CONFIG_HOME"] = home
        os.chdir(home)
        return soak(minutes, hand)


def main() -> None:
    """Run the trial and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=120.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--hurry", action="store_true", help="tour in a short run too, and wait for no picture there")
    asked = parser.parse_args()
    hand = Hand(asked.seed, SIZE, asked.minutes < SHORT and not asked.hurry, asked.hurry)
    samples, rests, failures = at_home(asked.minutes, hand)
    print(f"seed {asked.seed}: {samples[-1][1]:.0f} MB after {samples[-1][0]:.0f} minutes, {len(failures)} failures")
    toured = rests[0][0] if rests and (asked.minutes >= SHORT or asked.hurry) else 0.0
    print(f"growth in MB a minute after a tour of {toured:.0f} minutes; nan where there are too few samples:")
    for after in (after_seconds for after_seconds in AFTER if toured + after_seconds < samples[-1][0]):
        (over_all, error), (resting, its_error) = (growth(series, toured + after) for series in (samples, rests))
        print(f"from {after:2.0f} minutes on {over_all:.3f} ± {error:.3f}, at rest {resting:.3f} ± {its_error:.3f}")
    print("\n".join(failures))
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
