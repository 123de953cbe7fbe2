"""State of the surface table between frames, and the way of every edit into the settings."""

from collections.abc import Callable
from dataclasses import dataclass, field

from lensbench.app.session.edited_lens import edited
from lensbench.app.session.notices import Request
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.study_workers import ImprovementWorker
from lensbench.lenses.editing.document import EditError, LensDocument, Places

Shown = tuple[str, str]         # the setting of the lens, and its edits
Cell = tuple[int, str]          # surface, and quantity or "glass", "comment", "asphere", "pose"


@dataclass
class Entry:
    """The text that a user types into a cell."""

    cell: Cell
    text: str
    fresh: bool = True
    error: str = ""


@dataclass
class Scrub:
    """A press on a cell: the value at its start, the pixels dragged since, and the last x of the mouse."""

    cell: Cell
    value: float
    mouse: float
    pixels: float = 0.0
    dragged: bool = False


@dataclass
class Attachment:
    """What the dialog of another lens shows: its search, the name of the lens, the side "front" or "behind"."""

    search: str = ""
    lens: str = ""
    side: str = "front"
    is_reversed: bool = False


@dataclass
class LensTableState:
    """State of the panel of one window.

    requests: of the window. said: sentences for the user about the latest edits. parted: whether the change of this
    frame begins a step of undo of its own. ghost: whether the original lens lies under the section.
    """

    requests: set[Request] = field(default_factory=set)
    first: int = 0                      # selected surfaces, first and last
    last: int = 0
    entry: Entry | None = None
    scrub: Scrub | None = None
    glass_of: int = -1                  # surface whose glass is chosen
    body: tuple[int, int] | None = None # surfaces that a number of the place moves as one; None: not chosen
    search: str = ""
    maker: str = ""
    pasting: str | None = None          # the text of the paste dialog
    attaching: Attachment | None = None         # the dialog of another lens
    problem: str = ""                   # why the latest edit was refused
    shown: Shown = ("", "")             # as drawn last
    moves: dict[tuple[Shown, Shown], Places] = field(default_factory=dict)      # by edits, and by their undo
    said: list[str] = field(default_factory=list)
    parted: bool = False
    ghost: bool = False
    number: float = 0.0                 # typed in a menu
    worker: ImprovementWorker = field(default_factory=ImprovementWorker)
    ticked: set[Cell] = field(default_factory=set)          # numbers that an improvement may change
    hold_back_focus: bool = False
    try_glasses: bool = False
    aim: str = "spot"                       # of an improvement, one of AIMS
    begun: bool = False                 # an improvement begins: its steps are one undo
    stepped: bool = False               # the lens of this frame is a step of an improvement
    expected: str = ""                  # the edited lens of the settings while an improvement runs
    at: Cell | None = None              # the cell that has the keyboard
    keyed: bool = False                 # the table has the keyboard in this frame
    tabbed: int = 0                     # cells to the right, to which Tab goes from the text that it has ended

    def selected(self, surface: int) -> bool:
        """Whether a row is selected."""
        return self.first <= surface <= self.last

    def select(self, surface: int, extend: bool = False) -> None:
        """Select a row, or the rows up to it."""
        if extend:
            self.first, self.last = min(self.first, surface), max(self.last, surface)
        else:
            self.first = self.last = surface

    def follow(self, settings: Settings) -> None:
        """Before the panels of each frame: after an edit, an undo or a redo, ticks go with their surfaces and gaps."""
        shown = settings.lens, settings.edited
        if shown == self.shown:
            return
        places = self.moves.get((self.shown, shown))
        if places is not None:
            self.ticked = {(at, name) for i, name in self.ticked if (at := places.of(i, name)) is not None}
        self.problem, self.shown = "", shown            # why an edit of another lens was refused

    def apply(self, settings: Settings, edit: Callable[[LensDocument], LensDocument], part: bool = True) -> Settings:
        """The settings after an edit; the same ones, and a reason in `problem`, where it is refused.

        part: it is a step of undo of its own.
        """
        places: Places | None = None

        def followed(document: LensDocument) -> LensDocument:
            nonlocal places
            made = edit(document)
            places = made.places
            return made

        try:
            changed, found = edited(settings, followed)
        except EditError as error:
            self.problem = str(error)
            return settings
        self.problem = ""
        if places is not None:
            before, after = (settings.lens, settings.edited), (changed.lens, changed.edited)
            self.moves |= {(before, after): places, (after, before): places.undone()}
        self.said += [str(finding) for finding in found]
        self.parted = self.parted or part and changed is not settings
        return changed
