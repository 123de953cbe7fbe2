"""Opening files that a user or another file names: ordinary files only, so that none blocks or never ends."""

import errno
import os
import stat
from typing import BinaryIO


def open_regular(path: str | os.PathLike[str]) -> BinaryIO:
    """A file opened for reading.

    Parameters
    ----------
    path : str or path
        Links are followed.

    Returns
    -------
    BinaryIO
        At the first byte.

    Raises
    ------
    OSError
        The file is missing or unreadable, or is a folder, pipe, device or socket: `strerror` states which. A pipe that
        nobody writes would block, and a device may have no end.
    """
    try:
        _check(os.stat(path).st_mode)       # before it is opened: that alone makes some devices act
    except ValueError as error:             # a NUL in the path
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)) from error
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        _check(os.fstat(handle).st_mode)    # another file may have taken its place
        return os.fdopen(handle, "rb")
    except BaseException:
        os.close(handle)
        raise


def _check(mode: int) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "this is a folder, not a file")
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "this is a pipe, device or socket: give an ordinary file")
