"""The threads of the workers: how many, and how urgent."""

import os
import sys
import threading

NICE = 10                   # of the rendering threads, so that the window keeps its pace


def lower_priority() -> None:
    """Lower the priority of the calling thread, below the window's, if the system allows it; never raise it."""
    if sys.platform == "linux":
        thread = threading.get_native_id()
        try:
            os.setpriority(os.PRIO_PROCESS, thread, max(NICE, os.getpriority(os.PRIO_PROCESS, thread)))
        except OSError:                         # not allowed here: unchanged
            pass


def thread_count() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
