"""The heap gives back to the system what is free in it."""

import sys
from pathlib import Path
from time import sleep

import pytest

from lensbench.app.workers.task import EVERY, Heap


def resident():
    """Anonymous memory of this process, kB."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(status.split("RssAnon:")[1].split()[0])


@pytest.mark.skipif(sys.platform != "linux", reason="the heaps of other systems are left as they are")
def test_what_is_free_between_what_is_held_goes_back_to_the_system():
    heap = Heap()
    before = resident()
    blocks = [bytearray(50_000) for _ in range(1200)]   # 60 MB, in blocks that the heap keeps
    kept = blocks[::100]                                # no end of the heap is free
    del blocks
    heap.advance(EVERY + 1.0)
    for _ in range(100):
        if resident() - before < 20_000:
            break
        sleep(0.02)
    assert resident() - before < 20_000 and len(kept) == 12
