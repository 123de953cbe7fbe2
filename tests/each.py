"""A law that holds for each of many cases, as one test: all cases run, and all failures are listed with their names."""

from collections.abc import Callable, Iterable

import pytest


def for_each(cases: Iterable) -> Callable[[Callable], Callable[[], None]]:
    """A decorator that makes one test of a function of a case."""
    cases = list(cases)

    def decorate(law: Callable) -> Callable[[], None]:
        def test() -> None:
            failures = []
            for case in cases:
                try:
                    law(case)
                except Exception as error:          # of any kind: the other cases still run
                    failures.append(f"{case}: {type(error).__name__}: {error}")
            if failures:
                pytest.fail(f"{len(failures)} of {len(cases)} cases fail\n" + "\n".join(failures), pytrace=False)

        test.__name__, test.__doc__, test.__module__ = law.__name__, law.__doc__, law.__module__
        return test

    return decorate
