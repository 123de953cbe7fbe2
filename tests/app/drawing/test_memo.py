"""The caches of a panel: how often they compute, what they forget, and how often they hash their keys."""

import pytest

from lensbench.app.drawing.recorded import FrameMemo, Memo


class Key(str):
    """A text that counts how often it is hashed."""

    hashed = 0

    def __hash__(self):
        Key.hashed += 1
        return super().__hash__()


def test_the_newest_values_stay_and_each_is_computed_once_until_it_goes():
    made, memo = [], Memo(2)

    def value(name):
        return memo.of(name, lambda: made.append(name) or name.upper())

    assert [value(name) for name in "abacab"] == list("ABACAB")
    assert made == ["a", "b", "c", "b"]                 # b was the oldest when c came, then c


def test_none_is_a_value_and_an_error_leaves_the_others():
    memo = Memo(1)
    assert memo.of("a", lambda: None) is None and memo.of("a", lambda: 1) is None
    with pytest.raises(ZeroDivisionError):
        memo.of("b", lambda: 1 // 0)
    assert memo.of("a", lambda: 1) is None


def test_a_large_key_is_hashed_as_seldom_as_possible():
    memo, key = Memo(4), Key("cards")
    memo.of((key,), lambda: 1)
    before = Key.hashed
    memo.of((key,), lambda: 1)
    assert Key.hashed - before == 2                     # to take it out and to put it last


def test_what_a_frame_uses_stays_for_the_next_one_and_nothing_else_does():
    made, memo = [], FrameMemo()

    def value(name):
        return memo.of(name, lambda: made.append(name) or name.upper())

    def frame(names):
        memo.begin_frame()
        assert [value(name) for name in names] == list(names.upper())

    frame("abca")
    frame("ab")
    assert made == ["a", "b", "c"] and len(memo) == 3
    frame("ab")
    assert made == ["a", "b", "c"] and len(memo) == 2
    frame("c")
    assert made == ["a", "b", "c", "c"]
    frame("")
    frame("")
    assert len(memo) == 0


def test_none_is_drawn_once_and_an_error_again():
    memo = FrameMemo()
    memo.begin_frame()
    assert memo.of("a", lambda: None) is None and memo.of("a", lambda: 1) is None
    with pytest.raises(ZeroDivisionError):
        memo.of("b", lambda: 1 // 0)
    memo.begin_frame()
    assert memo.of("a", lambda: 1) is None and memo.of("b", lambda: 2) == 2


def test_a_large_key_that_is_drawn_again_is_hashed_as_seldom_as_possible():
    memo, key = FrameMemo(), Key("cards")
    for _ in range(2):
        memo.begin_frame()
        before = Key.hashed
        memo.of((key,), lambda: 1)
    assert Key.hashed - before == 2                     # to take it out of the frame before and to put it into this one
