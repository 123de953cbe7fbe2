"""Print the lowest version of each dependency that pyproject.toml allows, as constraints of pip, for `make compat`."""

import re
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parent.parent / "pyproject.toml"


def lowest() -> list[str]:
    """`name==version` of the dependencies and of those of the tests; those that only check the style stay free."""
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    requirements = [*project["dependencies"], *project["optional-dependencies"]["test"]]
    floors = (re.match(r"([\w-]+)>=([\d.]+)", requirement) for requirement in requirements)
    return [f"{floor[1]}=={floor[2]}" for floor in floors if floor and floor[1] not in ("ruff", "mypy")]


if __name__ == "__main__":
    print("\n".join(lowest()))
