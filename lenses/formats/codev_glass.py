"""Media of a CODE V sequence file (.seq): glasses of catalogues, codes, indices, and private glasses.

    PRV                         private glasses until END
    PWL 656.3 587.6 486.1       wavelengths (nm)
    'MYGLASS' 1.51 1.52 1.53    index at each of them
    END

Private glasses that are given by a formula are not read.
"""

from decimal import Decimal

from lensbench.lenses import glass_catalogue, media
from lensbench.lenses.design import Design
from lensbench.lenses.encoding import file_number, is_number, plain_number
from lensbench.lenses.rows import RowError
from lensbench.optics.finding import Kind
from lensbench.optics.glass import AIR, Glass


class Glasses:
    """The private glasses so far, and the media that the names in a file mean."""

    def __init__(self, design: Design):
        self.design = design
        self.is_open = False                    # whether a definition (PRV) has not ended yet
        self.wavelengths: list[float] = []      # µm
        self.private: dict[str, Glass] = {}

    def define(self, key: str, words: list[str], values: list[str]) -> None:
        """Process a line between PRV and END: the wavelengths (nm), or the indices of a glass at them."""
        if key == "END":
            self.is_open = False
        elif key == "PWL":
            self.wavelengths = [_micrometres(word) for word in values]
        elif values and media.code(words[0].strip("'\"")) is None:     # a code says n_d and V_d itself
            name = words[0].strip("'\"")
            kind = values[0].upper()
            if kind in ("LAU", "GMS", "GML", "HAR", "CAU", "SEL") or not is_number(values[0]):
                self.design.found(Kind.GLASS, f"the private glass {name} is given by a formula ({kind}), which is not "
                                              "read")
                return
            indices = [file_number(word, "index") for word in values]
            points = sorted({w: n for w, n in zip(self.wavelengths, indices, strict=False) if w > 0.0}.items())
            self.private[name.upper()] = media.tabulated(name, points)

    def medium(self, words: list[str]) -> Glass:
        """Medium after the current surface. RowError: a mirror, or a glass in no catalogue."""
        name = words[0].strip("'\"") if words else ""
        if name.upper() in media.MIRROR_NAMES:
            raise RowError(f"S{len(self.design.rows) - 1} is a mirror ({name.upper()}): only lenses are traced")
        if name.upper() in self.private:
            return self.private[name.upper()]
        coded = media.code(name) if name else AIR
        if coded is not None:
            return coded
        if is_number(name):
            return media.model(file_number(name, "index"), 0.0)
        glass, _, maker = (name, "", "") if glass_catalogue.makers(name) else name.partition("_")
        found, assumed = media.named(glass, maker or None)
        self.design.assume_glass(assumed)
        return found


def _micrometres(word: str) -> float:
    """Wavelength in µm from the digits of one in nm; 0, which no glass has, for one near 0."""
    return float(Decimal(plain_number(word)).scaleb(-3)) if file_number(word, "PWL") else 0.0
