"""Numbers, texts and lists in TOML; a float has enough digits to read back equal."""

import json
from typing import Any


def listed(values: Any) -> str:
    """A TOML list of numbers, or of tuples of numbers."""
    return f"[{', '.join(listed(v) if isinstance(v, tuple) else digits(v) for v in values)}]"


def digits(value: float) -> str:
    """A number with all its digits."""
    return repr(float(value))


def quoted(text: str) -> str:
    """A text in quotes."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
