"""Findings about a lens prescription: what a reader assumed, what a writer could not keep, what a check doubts."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from lensbench.core.text import escaped


class Severity(StrEnum):
    """Severity of a finding."""

    NOTE = "note"                           # something is assumed, converted or left out; the lens itself is unchanged
    WARNING = "warning"                     # the prescription is doubtful, or the written file holds another lens


class Kind(StrEnum):
    """Subject of a finding."""

    # Doubts of a check
    FOCAL_LENGTH = "focal-length"
    BACK_FOCUS = "back-focus"
    FOCI = "foci"                           # of the two sections of an anamorphic lens
    F_NUMBER = "f-number"
    SOLVED_RADIUS = "solved-radius"
    THICKNESS = "thickness"
    EDGE = "edge"
    CROSSING = "crossing"
    HEMISPHERE = "hemisphere"
    SLOPE = "slope"                         # of a surface, too steep to be made
    RAY = "ray"
    BLUR = "blur"                           # of a point on the axis, traced at full aperture
    FIELD = "field"                         # the stated field is not lit

    # Causes that a check names: with the change, the lens is good
    SIGN = "sign"                           # of a radius
    DIGIT = "digit"                         # a digit misread, two swapped, a decimal point moved
    CONIC = "conic"                         # constants given as 1 + k
    ASPHERE = "asphere"                     # coefficients at other powers of the height
    MEDIUM = "medium"                       # before the lens: water
    COVER_GLASS = "cover-glass"             # left out of the table, as the stack of a sensor is
    SCALE = "scale"

    # Of a check, of a reader or of a writer
    GLASS = "glass"
    STOP = "stop"
    NO_STOP = "no-stop"
    POSITION = "position"                   # of zoom or focus groups

    # Of a reader
    NEAR_OBJECT = "near-object"             # the lens is designed for an object at a finite distance
    IMAGE = "image"
    UNIT = "unit"
    CONVENTION = "convention"               # one of two ways to read the table was chosen
    RIM = "rim"                             # a clear aperture is estimated, or ends the light
    STOP_SIZE = "stop-size"                 # the file has two sizes of the stop, or one that no stop has
    NOT_READ = "not-read"                   # keywords and sections that the reader does not know

    # Of a reader or of a writer
    SHAPE = "shape"                         # a surface is replaced by one of another shape
    LEFT_OUT = "left-out"
    TEXT = "text"                           # names and notes are written in another form
    BESIDE = "beside"                       # a file that is written beside that of the lens: nothing is lost

    # Of an edited lens
    RULE = "rule"                           # a solve or pickup of the file, whose number is kept as it is
    UNSOLVED = "unsolved"                   # a solve or pickup that has no solution
    NO_IMAGE = "no-image"                   # no real image behind the lens
    MOVED_STOP = "moved-stop"               # an edit has taken away the stop, or moved it

    # Of an analysis
    ASSUMED = "assumed"                     # a condition, and its source
    DARK = "dark"                           # fields that no light reaches
    SAMPLING = "sampling"                   # too few samples, or an approximation beyond its range

    # Of a picture
    SCENE = "scene"                         # what the reader of its scene assumed or changed
    NO_GHOSTS = "no-ghosts"                 # they are wanted, and cannot be traced
    DIM_LIGHTS = "dim-lights"               # lights that have no ghosts, beyond the brightest ones
    NO_DIFFRACTION = "no-diffraction"       # it would blur by more than a pixel


@dataclass(frozen=True)
class Change:
    """One change of a prescription that a check proposes.

    quantity: "radius", "thickness", "n_d", "V_d", "conic", "aspheric power", "semi_diameter", "stop_index",
    "front_index", "scale" or "cover glass"; surface: its index, None for all or the whole lens. before, after: the
    value of the table and the proposed one (mm, or without unit), those of the first of several surfaces, the thickness
    of a plate that is added.
    """

    quantity: str
    surface: int | None
    before: float
    after: float


@dataclass(frozen=True)
class Finding:
    """One thing found in a lens prescription; its text is `str(finding)`.

    Args:
        kind: Subject. Programs test this and `severity`, never the text.
        surface: The surface, numbered from 0; None: the whole lens.
        message: One sentence for a person.
        proposal: The one changed number, or the glass, that would explain the finding.
        severity: NOTE or WARNING.
        figures: The numbers of the sentence by their names; lengths in mm. Those of a proposed change have its result
            under the name and "_after".
        change: The proposal in numbers.
    """

    kind: Kind
    surface: int | None
    message: str
    proposal: str | None = None
    severity: Severity = Severity.WARNING
    figures: Mapping[str, float] = field(default_factory=dict, hash=False)
    change: Change | None = None

    def __post_init__(self) -> None:
        # Names in a file may hold line ends and terminal escapes
        object.__setattr__(self, "message", escaped(self.message))
        if self.proposal is not None:
            object.__setattr__(self, "proposal", escaped(self.proposal))

    def __str__(self) -> str:
        return self.message


def note(kind: Kind, message: str, surface: int | None = None, **figures: float) -> Finding:
    """A finding of severity NOTE."""
    return Finding(kind, surface, message, severity=Severity.NOTE, figures=figures)
