"""Numbers, texts and lists as TOML writes them; a float with as many digits as it takes to read it back."""

import json
from typing import Any


def listed(values: Any) -> str:
    """Numbers, or tuples of them, as TOML writes a list."""
    return f"[{', '.join(listed(v) if isinstance(v, tuple) else digits(v) for v in values)}]"


def digits(value: float) -> str:
    """A number, to the last bit."""
    return repr(float(value))


def quoted(text: str) -> str:
    """A text in quotes."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
