"""A kernel that another process compiles, and the process that does: `python -m lensbench.app.workers.kernel`.

The process imports little, so that it begins soon: it reads pickled kernels and answers each with a line.
"""

import gc
import pickle
import sys
from importlib import import_module
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

from numba.core import sigutils

from lensbench.core.kernels import cache  # noqa: F401 — it sets the processor for which numba compiles

PROCESS = "lensbench.app.workers.kernel"


class Kernel(NamedTuple):
    """A kernel as another process finds it: an attribute of a module, and the types of its arguments."""

    module: str
    name: str
    signature: Any

    @classmethod
    def of(cls, function: FunctionType, signature: Any) -> "Kernel":
        """The kernel of this function of a module."""
        return cls(function.__module__, function.__qualname__, signature)

    @property
    def key(self) -> tuple[str, str, str]:
        """What tells it from other kernels, and can be hashed."""
        return self.module, self.name, str(self.signature)

    def compile(self) -> Path:
        """Compile it in this process; its file, which is written again if it is gone."""
        kernel = getattr(import_module(self.module), self.name)
        kernel.compile(self.signature)
        path = kernel._cache.path(self.signature, kernel.targetctx.codegen())
        if not path.exists():
            arguments, _ = sigutils.normalize_signature(self.signature)
            kernel._cache.save_overload(self.signature, kernel.overloads[tuple(arguments)])
        return path


def serve() -> None:
    """Compile the kernels of standard input until it ends."""
    gc.disable()                                # an eighth of the time; the process ends with its window
    answers, sys.stdout = sys.stdout, sys.stderr
    while True:
        try:
            kernel = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        try:
            kernel.compile()
            print("compiled", file=answers, flush=True)
        except Exception as error:              # of any kind: the window compiles it, and shows its own error
            print(f"failed: {type(error).__name__}", file=answers, flush=True)


if __name__ == "__main__":
    serve()
