"""The stamp of a file: it changes when the file is rewritten, and is the key of caches of its content."""

from pathlib import Path

Stamp = tuple[int, int]


def file_stamp(path: str | Path) -> Stamp:
    """Time of the last change (ns) and size (bytes); (0, 0) where there is no such file."""
    try:
        found = Path(path).stat()
    except (OSError, ValueError):               # no name that a file may have
        return 0, 0
    return found.st_mtime_ns, found.st_size
