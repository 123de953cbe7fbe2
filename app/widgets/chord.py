"""Key chords: a key with modifiers, as imgui takes them."""

from functools import reduce
from operator import or_

from imgui_bundle import imgui


def chord(*keys: imgui.Key) -> int:
    """Keys pressed together, as one number.

    imgui.Key is a flag whose members share bits, and the `|` of Python 3.11.2 (Debian 12) fails on such members.
    """
    return reduce(or_, map(int, keys))
