"""Lens prescriptions as data: the shipped library, and readers and writers of lens files.

    from lensbench import lenses
    lens = lenses.load("pbrt-dgauss-50mm")
    lenses.save(lens, "mine.toml")

Lengths are millimetres; a file of another unit is converted as it is read.
"""

from lensbench.lenses.catalogue import Card, describe, names
from lensbench.lenses.check import Finding, Kind, Severity, check
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.formats import FORMATS, READERS, WRITERS, Format
from lensbench.lenses.lens_file import load, save

__all__ = ["FORMATS", "READERS", "WRITERS", "Card", "Finding", "Format", "Kind", "LensFileError", "Severity", "check",
           "describe", "load", "names", "save"]
