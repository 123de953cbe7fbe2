"""Foreign text in messages: one line of visible characters, cut to a length."""

import unicodedata

import pytest
from hypothesis import given, strategies as st

from lensbench.core.text import MOST_CHARACTERS, cut, escaped, excerpt

anything = st.text(st.characters(), max_size=200)


@given(anything)
def test_an_escaped_text_is_one_line_of_visible_characters_and_loses_none(text):
    shown = escaped(text)
    assert not any(unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp") for c in shown)
    assert len(shown.splitlines()) <= 1
    visible = [c for c in text if c.isprintable()]
    rest = iter(shown)
    assert all(c in rest for c in visible)              # in their order


@pytest.mark.parametrize(("text", "shown"), [
    ("a\x1b[31mred", r"a\x1b[31mred"), ("one\ntwo\r", r"one\ntwo\r"), ("\u202egnp.exe", r"\u202egnp.exe"),
    ("f/2.8 – 50\u202fmm, 3\u00a0m", "f/2.8 – 50\u202fmm, 3\u00a0m"), ("\udcff", r"\udcff"), ("", "")])
def test_line_ends_terminal_escapes_and_direction_marks_are_quoted_and_spaces_stay(text, shown):
    assert escaped(text) == shown


@given(anything | st.lists(anything) | st.integers() | st.floats() | st.binary(max_size=300) | st.none())
def test_a_quoted_value_has_at_most_sixty_characters_on_one_line(value):
    shown = excerpt(value)
    assert len(shown) <= MOST_CHARACTERS and len(shown.splitlines()) == 1
    assert shown == repr(value) or len(repr(value)) > MOST_CHARACTERS or "…" in repr(value)


@pytest.mark.parametrize("value", ["x" * 10**6, [["y"] * 9] * 9999, 10**5000, [10**5000], {"a": "b" * 999}],
                         ids=["text", "list", "number", "in a list", "table"])
def test_values_of_any_size_are_quoted_short(value):
    assert 0 < len(excerpt(value)) <= MOST_CHARACTERS


def test_a_cut_text_keeps_its_beginning_and_its_end():
    text = "".join(chr(0x4E00 + i) for i in range(500))
    assert len(cut(text)) == MOST_CHARACTERS and "…" in cut(text)
    assert cut(text)[0] == text[0] and cut(text)[-1] == text[-1]
    assert cut(text[:MOST_CHARACTERS]) == text[:MOST_CHARACTERS]
