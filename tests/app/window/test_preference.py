"""Preferences of a window whose file was damaged, by hand or by another version."""

import pytest

from lensbench.app.window import state as module
from lensbench.app.window.state import preference, texts


@pytest.mark.parametrize(("kept", "read"), [
    ("", []), ("null", []), ("3", []), ("{", []), ('{"a": 1}', []), ('"text"', []), ("[]", []),
    ('["/a.png", "/b.png"]', ["/a.png", "/b.png"]), ('["/a.png", 3, null, ["/b.png"]]', ["/a.png"])])
def test_a_damaged_list_of_recent_files_leaves_out_what_it_does_not_know(monkeypatch, kept, read):
    """A number instead of the list kept the window from opening at all."""
    monkeypatch.setattr(module.hello_imgui, "load_lasting_pref", lambda name: kept if name == "recent" else "")
    assert texts(preference("recent", [])) == read


@pytest.mark.parametrize(("kept", "read"), [("", {}), ("3", {}), ("[1]", {}), ('{"a": "b"}', {"a": "b"})])
def test_a_damaged_table_is_empty(monkeypatch, kept, read):
    monkeypatch.setattr(module.hello_imgui, "load_lasting_pref", lambda name: kept)
    assert preference("folded", {}) == read
    assert texts(preference("folded", {}).get("a")) == []
