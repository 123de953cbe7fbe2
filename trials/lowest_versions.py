"""Print the lowest version of each dependency that pyproject.toml allows, as constraints of pip, for `make compat`."""

import re
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parent.parent / "pyproject.toml"


def lowest() -> list[str]:
    """`name==version` of the dependencies and of those of the tests; those that only check the style stay free."""
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *project["optional-dependencies"]["test"]]
    found = (re.match(r"([\w-]+)>=([\d.]+)", each) for each in wanted)
    return [f"{each[1]}=={each[2]}" for each in found if each and each[1] not in ("ruff", "mypy")]


if __name__ == "__main__":
    print("\n".join(lowest()))
