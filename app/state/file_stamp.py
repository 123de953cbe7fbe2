"""The stamp of a file: what changes when a file is written anew, so that caches of its content are keyed by it."""

from pathlib import Path

Stamp = tuple[int, int]


def file_stamp(path: str | Path) -> Stamp:
    """Time of the last change (ns) and size (bytes); (0, 0) where there is no such file."""
    try:
        found = Path(path).stat()
    except (OSError, ValueError):               # no name that a file may have
        return 0, 0
    return found.st_mtime_ns, found.st_size
