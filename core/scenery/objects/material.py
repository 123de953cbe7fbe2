"""Materials, patterns and images. Colours are linear; radiance is relative to a white surface under a sky of 1."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lensbench.core.lazy import hashed_once
from lensbench.core.scenery.surface_codes import GLASS, MATTE, METAL
from lensbench.core.scenery.values import SceneError, Triple, check
from lensbench.core.text import excerpt, significant

MATERIALS = ("matte", "coat", "metal", "glass", "light", "lamp")
PATTERNS = ("checker", "grid", "star", "ruler", "image")
LARGEST_IMAGE = 8192    # texels along a side


@dataclass(frozen=True)
class Image:
    """A texture, compared by value.

    Args:
        width, height: Texels across and down, 2 to 8192 each.
        data: height × width × 3 linear float32 values (red, green, blue), the top row first.
    Raises:
        SceneError: If a side is out of range or `data` has another size.
    """

    width: int
    height: int
    data: bytes

    def __post_init__(self) -> None:
        if max(self.width, self.height) > LARGEST_IMAGE:
            raise SceneError(f"an image of {self.width} × {self.height} texels is too large: reduce it to at most "
                             f"{LARGEST_IMAGE} × {LARGEST_IMAGE}")
        if self.width < 2 or self.height < 2 or len(self.data) != self.width * self.height * 12:
            raise SceneError(f"an image of {self.width} × {self.height} needs at least 2 × 2 texels of 12 bytes")

    @classmethod
    def of(cls, values: np.ndarray) -> "Image":
        """Image from an array.

        Args:
            values: array_like, shape (height, width, 3). Linear red, green and blue, the top row first; stored as
                float32.
        Raises:
            SceneError: If a side is shorter than 2 or longer than 8192 texels.
        """
        values = np.asarray(values)
        if max(values.shape[:2]) > LARGEST_IMAGE:
            return cls(values.shape[1], values.shape[0], b"")       # refused before the values are copied
        return cls(values.shape[1], values.shape[0], np.ascontiguousarray(values, np.float32).tobytes())

    @cached_property
    def mean(self) -> np.ndarray:
        """Mean colour, (3,)."""
        return self.values.mean((0, 1), dtype=np.float64)

    @property
    def values(self) -> np.ndarray:
        """Linear colours, (height, width, 3) float32, read-only."""
        return np.frombuffer(self.data, np.float32).reshape(self.height, self.width, 3)


@dataclass(frozen=True)
class Pattern:
    """Second colour or image on a rectangle or disk.

    Args:
        kind: {"checker", "grid", "star", "ruler", "image"}. "checker": fields of `columns` × `rows`. "grid": `columns`
            × `rows` cells with lines between them. "star": Siemens star of `columns` pairs of sectors. "ruler":
            millimetre ticks along the lower edge. "image": `image` times the material's colour.
        colour: (r, g, b). Linear colour of the pattern; the material's colour fills the rest.
        columns, rows: Number of fields across and down. Of a "ruler", `columns` is the length of the longest tick in
            mm.
        line: Width of the lines or ticks in mm.
        image: Required for the kind "image", and for this kind only.
    Raises:
        SceneError: If a value is out of range.
    """

    kind: str
    colour: Triple = (0.02, 0.02, 0.02)
    columns: float = 8.0
    rows: float = 8.0
    line: float = 1.0
    image: Image | None = None

    def __post_init__(self) -> None:
        check(self, ("columns", "rows", "line"))
        if self.kind not in PATTERNS:
            raise SceneError(f"pattern {excerpt(self.kind)}: choose one of {', '.join(PATTERNS)}")
        if (self.kind == "image") != (self.image is not None):
            raise SceneError("a pattern has an image if and only if its kind is image")


@hashed_once
@dataclass(frozen=True)
class Material:
    """Reflection and emission of a surface.

    Args:
        colour: (r, g, b). Linear albedo in [0, 1]; for "metal" and "glass" the tint; for "light" and "lamp" the emitted
            radiance.
        kind: {"matte", "coat", "metal", "glass", "light", "lamp"}. "matte": diffuse. "coat": clear coat of index 1.5
            over matte, which reflects lamps, sky and floor (never patterns). "metal": mirror; a dark colour looks like
            polished stone. "glass": index 1.5. "light": emits, but is too small to illuminate its surroundings. "lamp":
            emits and illuminates.
        gloss: Of a "coat", in (0, 1]. 1 reflects sharply; below 1 the slopes of the coat's facets are 1 − gloss wide.
        pattern: Second colour or image; on rectangles and disks only.
    Raises:
        SceneError: If a value is out of range.
    """

    colour: Triple = (0.5, 0.5, 0.5)
    kind: str = "matte"
    gloss: float = 1.0
    pattern: Pattern | None = None

    def __post_init__(self) -> None:
        check(self, ("gloss",))
        if self.kind not in MATERIALS:
            raise SceneError(f"material {excerpt(self.kind)}: choose one of {', '.join(MATERIALS)}")
        if self.gloss > 1.0:
            raise SceneError(f"gloss {significant(self.gloss)}: it must lie between 0 and 1")
        if min(self.colour) < 0.0:
            raise SceneError(f"colour {self.colour}: no component can be negative")
        if not self.shines and max(self.colour) > 1.0:
            raise SceneError(f"colour {self.colour}: a surface cannot reflect more light than it receives")

    @property
    def shines(self) -> bool:
        """Whether the surface emits light."""
        return self.kind in ("light", "lamp")

    def finish(self, radius: float = 0.0) -> float:
        """How the surface reflects, as the number that the stages read (`scenery/surface_codes.py`).

        Args:
            radius: Of a ball of glass, mm; 0 for a pane, and SOLID for a mesh.
        """
        return {"coat": self.gloss, "metal": METAL, "glass": GLASS + radius}.get(self.kind, MATTE)
