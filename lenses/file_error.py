"""What is wrong with a lens file, said in one line."""

from os import PathLike


class LensFileError(ValueError):
    """A lens file, or a name, that holds no lens: `path`, `line` (from 1; None: the whole file), `reason`."""

    def __init__(self, path: str | PathLike[str], line: int | None, reason: str):
        self.path, self.line, self.reason = str(path), line, reason
        super().__init__(f"{self.path}: {reason}" if line is None else f"{self.path}:{line}: {reason}")
