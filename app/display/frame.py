"""The picture that the render panel shows, and the state of its view."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lensbench.app.bench.exposure import AppliedExposure
from lensbench.app.bench.pose import LookAround
from lensbench.app.bench.tone import Difference
from lensbench.app.plots.pixel_rays import Pointed
from lensbench.app.session.notices import Notice, NoticeKind, Notices, Request
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.compilers import Part

Box = tuple[float, float, float, float]     # left, top, right, bottom on the screen (pixels)


@dataclass(frozen=True)
class Mark:
    """The focused point (parts of width and height), its distance, and the aim of the camera at that time.

    remark: why the point is not sharp, or "".
    """

    x: float
    y: float
    distance: float
    aim: Settings
    remark: str = ""

    def holds(self, settings: Settings) -> bool:
        """Whether the camera still aims and focuses at this point."""
        return settings.focuses and self.distance == settings.focus_distance and _any_size(self.aim) == _any_size(
            settings.aim)


@dataclass(frozen=True)
class SharpPicks:
    """Points of the world (mm) to be made sharp, where the picture shows them, and the settings that aimed it then."""

    points: tuple[tuple[float, float, float], ...]
    marks: tuple[Mark, ...]
    settings: Settings

    def holds(self, settings: Settings) -> bool:
        """Whether the picture still shows the points there."""
        return _any_size(self.settings.aim) == _any_size(settings.aim)


@dataclass(frozen=True)
class Click:
    """A click in the picture (parts of width and height) that waits for the depth map, and the camera's aim then."""

    x: float
    y: float
    aim: Settings

    def holds(self, settings: Settings) -> bool:
        """Whether the camera still aims as when it was clicked: another lens or scene shows something else there."""
        return _any_size(self.aim) == _any_size(settings.aim)


def _any_size(settings: Settings) -> Settings:
    return settings.plain("pixels_x", "pixels_y")


@dataclass(frozen=True, eq=False)
class Light:
    """Linear light of a picture (h, w, 3), as its texture was developed from it: exposure in stops, tone, sensor.

    tone: a key of settings.TONES, "raw" for codes of the screen, or "difference", of which `scale` is shown white.
    """

    values: NDArray[np.float32]
    exposure: float = 0.0
    tone: str = "raw"
    sensor: bool = False
    scale: float = 1.0


@dataclass(frozen=True)
class Pinned:
    """The picture A: its texture, tone-mapped by its own settings."""

    texture: int                                    # GL name
    size: tuple[int, int]
    samples: int
    settings: Settings
    light: Light


@dataclass(frozen=True)
class Picture:
    """Contents of the render panel in one frame."""

    texture: int = 0                                # GL name, 0: nothing yet
    size: tuple[int, int] = (0, 0)                  # pixels across and down
    samples: int = 0
    seconds: float = 0.0
    paused: bool = False
    held: str = ""                                  # the work for which it pauses; "": for none
    other: bool = False                             # of another lens, scene or camera than that of the settings
    waiting: float = 0.0                            # seconds since the settings changed, until their first picture
    first: bool = False                             # no picture yet: the kernels may be compiling
    depth: NDArray[np.float32] | None = None        # (h, w) mm from the film along the axis
    histogram: NDArray[np.float64] | None = None    # (4, bins) red, green, blue, luminance
    pinned: Pinned | None = None                    # the picture A, while it is compared
    difference: Difference | None = None            # from A, while `texture` shows it
    recorded: Settings | None = None                # of a light field's picture: of a camera with this focus
    note: str = ""                                  # describes such a picture
    light: Light | None = None                      # that the texture shows, without overlays
    plan: tuple[Part, ...] = ()                     # what is compiled for the first picture
    applied: AppliedExposure | None = None          # exposure of the camera's picture
    around: int = 0                                 # GL name of the look around in a panorama; 0: none
    off_meter: float | None = None                  # stops by which it is brighter than the meter would have it


@dataclass
class View:
    """State of the render panel between frames; no part of the settings."""

    zoom: float | None = None                       # screen pixels for a pixel of the picture; None: all that fits
    centre: tuple[float, float] = (0.5, 0.5)        # the part of the picture in the middle of the panel
    focus_pick: bool = True
    pin_pick: bool = False                          # a click pins a pixel, and does not focus
    sharp_pick: bool = False                        # a click adds a point that is made sharp
    picks: SharpPicks | None = None                 # the points so far
    histogram: bool = False
    mark: Mark | None = None
    pending: Click | None = None
    cross: tuple[int, int] | None = None            # the chosen pixel of a light field
    line: bool = False                              # and whether its line is marked
    links: Pointed = field(default_factory=Pointed)     # the pixel, ray and surfaces under the mouse
    picked: tuple[int, int] | None = None           # a pixel of a light field that was clicked on, across and down
    pointed: tuple[float, float] | None = None      # the last raster point under the mouse
    magnifier: int = 0                              # steps of magnification at the mouse; 0: none
    scale: float = 1.0                              # screen pixels for a pixel of the picture, as drawn last
    covered: Box | None = None                      # by the picture
    plates: list[Box] = field(default_factory=list)     # of notes and legends at the picture's lower edge in this frame
    pinned: Settings | None = None                  # those of the picture A
    program: str = ""                               # the mode P, A or S that the meter serves; "": none of them
    follows: bool = False                           # the render has as many pixels as the window shows of it
    room: tuple[float, float] = (0.0, 0.0)          # for the picture, in pixels of the screen
    locked: bool = False                            # A follows the dials that are turned in B
    dragged: bool = False
    look: LookAround | None = None                  # inside a panorama; None: the whole of it is shown
    offers_trials: bool = False                     # three pictures to begin with, at the lower edge
    requests: set[Request] = field(default_factory=set)     # to the window
    notices: Notices = field(default_factory=Notices)

    def say(self, message: str, done: bool = False, note: bool = False, lens: str = "",
            file: str = "", change: bool = False, about: str = "") -> None:
        """Show a message; an error, which stays until it is dismissed, unless it is a success or a note.

        done: it reports a success. note: it needs no answer. lens: a note on the lens of this setting, which goes with
        the lens. file: the file that it says cannot be read. change: it is about the settings that this frame sets,
        and goes when undo takes them back. about: the kind of work that it reports, whose next report replaces it.
        """
        kind = NoticeKind.DONE if done else NoticeKind.NOTE if note or lens else NoticeKind.ERROR
        self.notices.say(Notice(message, kind, lens, file, change, about=about))

    @property
    def messages(self) -> list[str]:
        """The texts of all notices, the oldest first."""
        return self.notices.texts
