"""A cache of files that outlives a bad moment: while a file cannot be read, its last good content stays in use."""

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import Any, TypeVar

Content = TypeVar("Content")


def keeps_last_good(size: int) -> Callable[[Callable[[str, Any], Content]], Callable[[str, Any], Content]]:
    """Decorator of load(name, stamp), which reads the file `name`: it is read once for each stamp. size: stamps kept.

    If a file that has been read cannot be read after a change, such as one that is half written, the content read last
    is returned. A file that has never been read raises what `load` raises.
    """
    def decorate(load: Callable[[str, Any], Content]) -> Callable[[str, Any], Content]:
        good: dict[str, Content] = {}
        bad: dict[str, Any] = {}                # stamps that could not be read
        cached = lru_cache(maxsize=size)(load)

        @wraps(load)
        def loaded(name: str, stamp: Any) -> Content:
            if name in good and bad.get(name) == stamp:
                return good[name]
            try:
                good[name] = cached(name, stamp)
            except (ValueError, OSError):
                bad[name] = stamp
                if name not in good:
                    raise
            return good[name]

        return loaded

    return decorate
