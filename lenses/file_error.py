"""The error of a lens file, in one line."""

from os import PathLike

from lensbench.kernels.quotation import cut, escaped


class LensFileError(ValueError):
    """A lens file that holds no lens or cannot be written, or an unknown lens name.

    Parameters
    ----------
    path : str or path
        The file, or the name.
    line : int or None
        Line from 1; None: the whole file.
    reason : str
        What is wrong and what to do, in one sentence.
    """

    def __init__(self, path: str | PathLike[str], line: int | None, reason: str):
        self.path, self.line, self.reason = str(path), line, _one_line(reason)
        place = _one_line(self.path) if line is None else f"{_one_line(self.path)}:{line}"
        super().__init__(f"{place}: {self.reason}")


def _one_line(text: str) -> str:
    """The text with line ends and control characters escaped, cut if long: a damaged file can contain anything."""
    return cut(escaped(text), 300)
