"""What is wrong with a lens file, said in one line."""

from os import PathLike


class LensFileError(ValueError):
    """A lens file, or a name, that holds no lens: `path`, `line` (from 1; None: the whole file), `reason`."""

    def __init__(self, path: str | PathLike[str], line: int | None, reason: str):
        self.path, self.line, self.reason = str(path), line, _one_line(reason)
        place = _one_line(self.path) if line is None else f"{_one_line(self.path)}:{line}"
        super().__init__(f"{place}: {self.reason}")


def _one_line(text: str) -> str:
    """The text without line ends, its middle left out where it is long (a damaged file can hold anything)."""
    text = " ".join(text.split("\n"))
    return text if len(text) <= 300 else f"{text[:150]} … {text[-140:]}"
