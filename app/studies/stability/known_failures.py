"""Failures that are known of other systems, and what this one does in their place."""

import tomllib
from dataclasses import dataclass
from importlib.resources import files


@dataclass(frozen=True)
class KnownFailure:
    """One of them.

    id: the thread of a project, or the subject. fails: what goes wrong there. here: what this program does, "" where
    the failure does not apply, and `beside` says why. test: the file and function, under tests/, that shows it.
    """

    id: str
    fails: str
    here: str = ""
    test: str = ""
    beside: str = ""


def known_failures() -> tuple[KnownFailure, ...]:
    """All that were collected."""
    text = files("lensbench.app.studies.stability").joinpath("known_failures.toml").read_text(encoding="utf-8")
    return tuple(KnownFailure(**row) for row in tomllib.loads(text)["failure"])


def table() -> list[str]:
    """As a table of Markdown."""
    rows = [(failure.id, failure.fails, failure.here or f"does not apply: {failure.beside}",
             f"`{failure.test.partition('::')[0]}`" if failure.test else "") for failure in known_failures()]
    return ["| where | what fails there | here | test |", "|---|---|---|---|",
            *(f"| {' | '.join(row)} |" for row in rows)]
