"""The picture as the render panel gets it, and what the panel remembers of its view."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lensbench.app.state.comparison import Difference
from lensbench.app.state.request import Request
from lensbench.app.state.settings import Settings


@dataclass(frozen=True)
class Mark:
    """Where the picture was focused, as parts of its width and height, at which distance, and what it looked at."""

    x: float
    y: float
    distance: float
    aim: Settings

    def holds(self, settings: Settings) -> bool:
        """Whether what was focused on still stands there, in focus."""
        return settings.focuses and self.distance == settings.focus_distance and self.aim == settings.aim


@dataclass(frozen=True)
class Pinned:
    """The picture that is kept as A: its texture, as it was developed then."""

    texture: int                                    # GL name
    size: tuple[int, int]
    samples: int
    settings: Settings


@dataclass(frozen=True)
class Picture:
    """What there is to be shown in this frame."""

    texture: int = 0                                # GL name, 0: nothing yet
    size: tuple[int, int] = (0, 0)                  # pixels across and down
    samples: int = 0
    seconds: float = 0.0
    paused: bool = False
    waiting: float = 0.0                            # seconds since the settings changed without a picture of them
    first: bool = False                             # the kernels are not known to be compiled yet
    depth: NDArray[np.float32] | None = None        # (h, w) mm from the film along the axis
    histogram: NDArray[np.float64] | None = None    # (4, bins) red, green, blue, luminance
    pinned: Pinned | None = None                    # the picture A, where it is compared with
    difference: Difference | None = None            # from A, where `texture` shows it
    recorded: Settings | None = None                # of a light field's picture: the camera's that would be focused so
    note: str = ""                                  # what such a picture is


@dataclass
class View:
    """What the panel remembers from frame to frame; no part of the settings."""

    zoom: float | None = None                       # screen pixels for a pixel of the picture; None: all that fits
    centre: tuple[float, float] = (0.5, 0.5)        # the part of the picture in the middle of the panel
    focus_pick: bool = True
    histogram: bool = False
    mark: Mark | None = None
    pending: tuple[float, float] | None = None      # a click that waits for the depth map, parts of the picture
    cross: tuple[int, int] | None = None            # the pixel of a light field that is looked at
    line: bool = False                              # and whether its line is, too
    hover: tuple[float, float] | None = None        # the raster point under the mouse
    picked: tuple[int, int] | None = None           # a pixel of a light field that was clicked on, across and down
    pointed: tuple[float, float] | None = None      # the raster point that the mouse was on last
    scale: float = 1.0                              # screen pixels for a pixel of the picture, as drawn last
    covered: tuple[float, float, float, float] | None = None    # by the picture: left, top, right, bottom on the screen
    pinned: Settings | None = None                  # those of the picture A
    dragged: bool = False
    requests: set[Request] = field(default_factory=set) # of the window
    messages: list[str] = field(default_factory=list)   # what went wrong or was done, until it is dismissed
    done: set[str] = field(default_factory=set)         # those of them that tell of something done

    def say(self, message: str, done: bool = False) -> None:
        """Show a message until it is dismissed; the same one only once. done: nothing went wrong."""
        if message not in self.messages:
            self.messages.append(message)
        (self.done.add if done else self.done.discard)(message)
