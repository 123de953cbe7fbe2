"""The threads of the workers: how many, and how urgent."""

import os
import sys
import threading

NICE = 10                   # of the rendering threads, so that the window keeps its pace


def lower_priority() -> None:
    """Let the calling thread alone step back behind the window, where the system can do that."""
    if sys.platform == "linux":
        try:
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICE)
        except OSError:                         # not allowed here: as it was
            pass


def thread_count() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
