"""Preferences that are kept as JSON beyond a session, in the file of imgui's own settings."""

import json
from typing import Any

from imgui_bundle import hello_imgui


def preference(name: str, otherwise: Any) -> Any:
    """The kept value; `otherwise` where none was kept, where it is damaged, and where it is of another type."""
    try:
        kept = json.loads(hello_imgui.load_lasting_pref(name) or "null")
    except ValueError:
        return otherwise
    return kept if isinstance(kept, type(otherwise)) else otherwise


def texts(values: Any) -> list[str]:
    """The texts of a list that was kept; what is none is left out, and all of it where it is no list."""
    return [value for value in values if isinstance(value, str)] if isinstance(values, list) else []
