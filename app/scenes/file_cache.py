"""Caches of files: the stamp of a file as their key, and the last good content while a file cannot be read."""

import os
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

from lensbench.core.kernels.byte_cache import buffers, byte_cache, total

MOST_KEPT = 1 << 30     # bytes
Stamp = tuple[int, int]
Content = TypeVar("Content")


def file_stamp(path: str | Path) -> Stamp:
    """Time of the last change (ns) and size (bytes); (0, 0) where there is no such file, as for a library name."""
    if "." not in (name := str(path)) and os.sep not in name:       # asked for many times a frame
        return 0, 0
    try:
        status = Path(path).stat()
    except (OSError, ValueError):               # no name that a file may have
        return 0, 0
    return status.st_mtime_ns, status.st_size


def keeps_last_good(size: int) -> Callable[[Callable[[str, Any], Content]], Callable[[str, Any], Content]]:
    """Decorator of load(name, stamp), which reads the file `name`: it is read once for each stamp.

    size: stamps kept, and names whose last content is, as long as they hold MOST_KEPT bytes at most. If a file that has
    been read cannot be read after a change, such as one that is half written, the content read last is returned. A file
    that has never been read raises what `load` raises.
    """
    def decorate(load: Callable[[str, Any], Content]) -> Callable[[str, Any], Content]:
        good: dict[str, tuple[Content, dict[int, int]]] = {}         # with its buffers
        bad: dict[str, Any] = {}                # stamps that could not be read
        cached = byte_cache(MOST_KEPT, size)(load)

        @wraps(load)
        def loaded(name: str, stamp: Any) -> Content:
            if name in good and bad.get(name) == stamp:
                return good[name][0]
            try:
                content = cached(name, stamp)
            except (ValueError, OSError):
                if name not in good:
                    raise
                bad[name] = stamp
                return good[name][0]
            known = good.pop(name, None)
            if known is not None and known[0] is content:
                good[name] = known              # the newest name is last
                return content
            for last in list(good)[-1:]:        # its content may have grown by cached properties
                good[last] = good[last][0], buffers(good[last][0])
            good[name] = content, buffers(content)
            while len(good) > 1 and (len(good) > size or total(kept for _, kept in good.values()) > MOST_KEPT):
                forgotten = next(iter(good))
                del good[forgotten]
                bad.pop(forgotten, None)
            return content

        return loaded

    return decorate
