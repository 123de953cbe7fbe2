"""Known failures of other systems, and what this program does instead."""

import tomllib
from dataclasses import dataclass
from importlib.resources import files


@dataclass(frozen=True)
class KnownFailure:
    """One known failure of another system.

    id: thread of a project, or the subject. fails: what goes wrong there. here: what this program does; "" if the
    failure does not apply, for the reason `beside`. test: file and function under tests/ that shows it.
    """

    id: str
    fails: str
    here: str = ""
    test: str = ""
    beside: str = ""


def known_failures() -> tuple[KnownFailure, ...]:
    """All collected failures."""
    text = files("lensbench.app.studies.stability").joinpath("known_failures.toml").read_text(encoding="utf-8")
    return tuple(KnownFailure(**row) for row in tomllib.loads(text)["failure"])


def table() -> list[str]:
    """The known failures as lines of a Markdown table."""
    rows = [(failure.id, failure.fails, failure.here or f"does not apply: {failure.beside}",
             f"`{failure.test.partition('::')[0]}`" if failure.test else "") for failure in known_failures()]
    return ["| where | what fails there | here | test |", "|---|---|---|---|",
            *(f"| {' | '.join(row)} |" for row in rows)]
