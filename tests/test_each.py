"""A folded law runs all cases and names each that fails."""

import pytest

from tests.each import for_each


def test_a_folded_law_runs_all_cases_and_names_those_that_fail():
    seen = []

    @for_each(["a", "b", "c"])
    def law(case):
        seen.append(case)
        assert case != "b", "not b"
        if case == "c":
            raise ValueError("an error of c")

    with pytest.raises(pytest.fail.Exception, match=r"2 of 3 cases fail(.|\n)*b: AssertionError: not b(.|\n)*c: Val"):
        law()
    assert seen == ["a", "b", "c"]
