"""Lens prescriptions as data: the shipped library, and readers and writers of lens files.

    from lensbench import lenses
    lens = lenses.load("pbrt-dgauss-50mm")
    lenses.save(lens, "mine.toml")

Names are imported when they are first used: the headers of the library (`describe`) need neither numpy nor numba.
Lengths are millimetres; a file of another unit is converted as it is read.
"""

from typing import TYPE_CHECKING

from lensbench.core.lazy import lazy_names

if TYPE_CHECKING:               # the public names; each is imported when it is first used
    from lensbench.core.optics.finding import Finding, Kind, Severity
    from lensbench.lenses.checks import check
    from lensbench.lenses.file_error import LensFileError
    from lensbench.lenses.formats.table import FORMATS, READERS, WRITERS, Format
    from lensbench.lenses.lens_file import load, load_document, save
    from lensbench.lenses.library.catalogue import Card, card, describe, names

__getattr__, __dir__, __all__ = lazy_names(__name__)
