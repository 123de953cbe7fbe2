"""Lens file formats, one row each: to add a format, write its file and add its row."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.lens_surface import Shape
from lensbench.core.optics.prescription import Lens
from lensbench.lenses.file_error import LensFileError, RowError
from lensbench.lenses.formats import (
    codev, codev_writer, deeplens, flaresim, lens_explorer, lenshh, lensoptics, optical_bench, optiland, oslo,
    oslo_writer, pbrt_format, rayoptics, toml_format, toml_header, zemax, zemax_writer
)
from lensbench.lenses.formats.losses import (
    COMMON, NAMED, ROTATIONAL, STOP, SYSTEM, TITLED, lost_fields, lost_poses, lost_shapes, lost_system
)

Reader = Callable[[str, str], Lens]                         # text and path → lens; LensFileError
Writer = Callable[[Lens], tuple[str, Sequence[Finding]]]    # lens → text, and findings about losses of its own
TORUS = "the torus of the same two curvatures is written"


@dataclass(frozen=True)
class Format:
    """A format of lens files: its reader, its writer, and what it can hold.

    Args:
        suffix: Of its files, with the dot.
        name: Of the program, shown to the user.
        read: (text, path) → Lens; LensFileError names the path, the line and the mistake.
        write: lens → text, and findings about losses that its row does not tell; None for a format that is only read.
        shapes: Surfaces that it holds.
        instead: What is written instead of other surfaces.
        fields: Of `Lens` and `Surface`, those that it holds besides the ones that every format has, see `lost_fields`.
        system: Parts of the system data that it holds, see `lost_system`.
        has_positions: Whether it holds the zoom and focus positions of a lens.
        has_poses: Whether it holds the decentres and tilts of surfaces.
        is_utf8: Whether its files are UTF-8; other programs use the encoding of their machine.
        recognises: text → bool. If several formats share a suffix, a file is read by the first that accepts its text.
    """

    suffix: str
    name: str
    read: Reader
    write: Writer | None = None
    shapes: frozenset[Shape] = COMMON
    instead: str = "its other terms are written"
    fields: frozenset[str] = NAMED
    system: frozenset[str] = SYSTEM
    has_positions: bool = True
    has_poses: bool = False
    is_utf8: bool = False
    recognises: Callable[[str], bool] = lambda text: True

    def text_of(self, lens: Lens) -> tuple[str, tuple[Finding, ...]]:
        """Text of a lens in this format.

        Args:
            lens: Any lens; the format must have a writer.
        Returns:
            The text, and what the format cannot hold.
        """
        assert self.write is not None, f"{self.name} files are only read"
        text, remarks = self.write(lens)
        findings = [*lost_shapes(lens, self.shapes, self.instead), *remarks, *lost_fields(lens, self.fields),
                    *lost_system(lens.system, self.system)]
        if not self.has_poses:
            findings += lost_poses(lens)
        if lens.positions is not None and not self.has_positions:
            findings.append(note(Kind.POSITION, "its zoom and focus positions are left out: the lens is written in the "
                                                "current one"))
        return text, tuple(dict.fromkeys(findings))


OWN = frozenset({*toml_header.FIELDS.values(), *STOP, "front_index", "coating"})
FORMATS = (
    Format(".toml", "lensbench", toml_format.read, toml_format.write, fields=OWN, has_poses=True, is_utf8=True),
    Format(".dat", "pbrt", pbrt_format.read, pbrt_format.write, frozenset({Shape.SPHERE}),
           "its sphere alone is written", TITLED | {"kind", "year", "source"}, frozenset(), has_positions=False,
           is_utf8=True),
    Format(".zmx", "Zemax", zemax.read, zemax_writer.write, fields=TITLED, has_poses=True),
    Format(".seq", "CODE V", codev.read, codev_writer.write, COMMON - {Shape.ASPHERE},
           "its terms in r⁴, r⁶ … alone are written", has_poses=True),
    Format(".txt", "Optical Bench", optical_bench.read, optical_bench.write, ROTATIONAL,
           "only its section y–z is written", TITLED | {"stated_efl", "stated_f_number"},
           frozenset({"fields", "object distance"})),
    Format(".len", "OSLO", oslo.read, oslo_writer.write, COMMON - {Shape.TOROID}, TORUS),
    Format(".json", "Lens Explorer", lens_explorer.read, recognises=lens_explorer.is_one),
    Format(".json", "DeepLens", deeplens.read, recognises=deeplens.is_one),
    Format(".json", "Optiland", optiland.read, optiland.write, COMMON - {Shape.TOROID},
           "Optiland adds the arcs of its two sections", has_positions=False),
    Format(".roa", "rayoptics", rayoptics.read, rayoptics.write, COMMON - {Shape.TOROID}, TORUS, has_positions=False),
    Format(".lhlt", "LensHH", lenshh.read),
    Format(".fx", "lensoptics", lensoptics.read),
    Format(".lens", "FlareSim", flaresim.read),
)


def _reader(suffix: str) -> Reader:
    rows = [row for row in FORMATS if row.suffix == suffix]

    def read(text: str, path: str) -> Lens:
        try:
            return next(row for row in rows if row.recognises(text)).read(text, path)
        except RowError as error:                   # of a value without a line, such as the name
            raise LensFileError(path, None, str(error)) from None

    return read


READERS: dict[str, Reader] = {row.suffix: _reader(row.suffix) for row in FORMATS}
WRITERS: dict[str, Callable[[Lens], tuple[str, tuple[Finding, ...]]]] = {
    row.suffix: row.text_of for row in FORMATS if row.write is not None}
UTF8_SUFFIXES = frozenset(row.suffix for row in FORMATS if row.is_utf8)
