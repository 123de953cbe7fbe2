"""Settings as a short text that fits into a chat message: “lensbench:” and the settings that differ from the defaults.

The text is JSON of plain settings, deflated, in the letters of URLs. It names lenses and scenes, and holds no files.
"""

import base64
import binascii
import json
import zlib
from pathlib import Path

from lensbench.app.state.settings import Settings, SettingsError
from lensbench.kernels.quotation import excerpt

PREFIX = "lensbench:"
LONGEST = 1 << 16               # characters, and bytes of the JSON
DIGITS = 7                      # of a number: finer than any dial


def state_text(settings: Settings) -> str:
    """The settings as one word; numbers are rounded to DIGITS."""
    defaults = Settings().to_dict()
    plain = {name: _short(value) for name, value in settings.to_dict().items()
             if name == "version" or value != defaults[name]}
    packed = json.dumps(plain, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
    return PREFIX + base64.urlsafe_b64encode(deflate.compress(packed) + deflate.flush()).decode().rstrip("=")


def is_state_text(text: str) -> bool:
    """Whether a text claims to be one of `state_text`."""
    return text.strip().startswith(PREFIX)


def settings_of_text(text: str) -> Settings:
    """The settings of a `state_text`; SettingsError for another text, a cut one, or settings that cannot be."""
    word = "".join(text.split())
    if not word.startswith(PREFIX) or len(word) > LONGEST:
        raise SettingsError(f"“{excerpt(text[:60])}”: a state of lensbench begins with {PREFIX}")
    letters = word[len(PREFIX):]
    try:
        packed = base64.b64decode(letters + "=" * (-len(letters) % 4), altchars=b"-_", validate=True)
        inflate = zlib.decompressobj(-15)
        raw = inflate.decompress(packed, LONGEST)
        if not inflate.eof:
            raise ValueError("it ends too early")
        plain = json.loads(raw.decode())
    except (ValueError, binascii.Error, zlib.error, RecursionError) as error:
        raise SettingsError("this state of lensbench is incomplete or damaged: copy the whole text again") from error
    if not isinstance(plain, dict):
        raise SettingsError("this state of lensbench is damaged: it holds no settings")
    return Settings.from_dict(plain)


def left_behind(settings: Settings) -> list[str]:
    """Names of the files that the settings name, and that their text does not hold."""
    return [Path(name).name for name in (settings.lens, settings.scene, settings.stop_image)
            if Path(name).suffix and Path(name).is_file()]


def _short(value: object) -> object:
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    return [_short(part) for part in value] if isinstance(value, list | tuple) else value
