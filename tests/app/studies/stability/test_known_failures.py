"""Every known failure of another system has a test here, or a reason why it does not apply."""

import ast
import json
from functools import cache
from pathlib import Path

import pytest

from lensbench.app.studies.stability.plots import known_failures, table

TESTS = Path(__file__).parents[3]
FAILURES = known_failures()
THREADS = json.loads((TESTS / "data/known_threads.json").read_text(encoding="utf-8"))["threads"]


@cache
def functions(file: str) -> set[str]:
    tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("failure", FAILURES, ids=[failure.id for failure in FAILURES])
def test_a_failure_has_a_test_or_a_reason(failure):
    assert failure.fails and bool(failure.reason) != bool(failure.test) and bool(failure.test) == bool(failure.ours)
    if failure.test:
        file, name = failure.test.split("::")
        assert name in functions(file)


def test_every_thread_that_was_collected_is_listed_and_no_test_stands_for_two_failures():
    ids = [failure.id for failure in FAILURES]
    assert len(set(ids)) == len(ids) and set(THREADS) <= set(ids)
    tests = [failure.test for failure in FAILURES if failure.test]
    assert len(set(tests)) == len(tests)
    assert len(table()) == len(ids) + 2 and all(row.count("|") == 5 for row in table())


def test_the_page_of_known_failures_has_every_row():
    page = (TESTS.parent / "docs/known-failures.md").read_text(encoding="utf-8")
    assert page.endswith("\n".join(table()) + "\n")
