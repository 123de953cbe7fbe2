"""One thing that looks wrong in a prescription."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """What looks wrong (`message`), where (`surface`, from 0; None: the whole lens) and of which kind.

    kind: "focal-length", "back-focus", "foci", "f-number", "solved-radius",
    "glass", "thickness", "edge", "crossing", "hemisphere", "ray", "position",
    "stop", "no-stop" or "reading".
    proposal: the one changed number, or the glass, that would explain it, or None.
    """

    kind: str
    surface: int | None
    message: str
    proposal: str | None = None
