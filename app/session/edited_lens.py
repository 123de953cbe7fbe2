"""The lens of the settings as a document that is edited, saved and improved.

The settings hold the text of the document, so that one undo covers lens and settings, and a picture carries its lens.
A lens that is scaled to a focal length is edited at that size.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import document_of_text, prescription, published
from lensbench.app.scenes.asset_files import Stamp, file_stamp, keeps_last_good
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.finding import Finding, Kind
from lensbench.lenses.editing.document import EditError, LensDocument, to_text
from lensbench.lenses.editing.solves import settled
from lensbench.lenses.editing.structure import kept_in_focus, scaled

if TYPE_CHECKING:
    from lensbench.core.design.goal import Goal
    from lensbench.core.design.improve import Cell, Improvement, Step


@lru_cache(maxsize=64)
def _read(text: str, name: str) -> LensDocument:
    return settled(document_of_text(text, name))


@keeps_last_good(16)
def _original(name: str, stamp: Stamp) -> LensDocument:
    document = lenses.load_document(name)
    lens = document.lens.at(zoom=0.0, close=0.0)
    if not lens.estimates and any(finding.kind is Kind.RIM for finding in lens.findings):
        lens = replace(lens, estimates="rims")          # the text of a document holds no findings of its reader
    return settled(replace(document, lens=lens))


def document_named(name: str) -> LensDocument:
    """The document of a lens of the library, or of a file; errors are those of loading it."""
    return _original(name, file_stamp(name))


def original(settings: Settings) -> LensDocument:
    """The document as the file or the library has it; errors are those of loading the lens."""
    return _original(settings.lens, file_stamp(settings.lens))


def document_of(settings: Settings) -> LensDocument:
    """The document of the lens, at the size that the settings give it; LensFileError, LensError or OSError."""
    document = _read(settings.edited, settings.lens) if settings.edited else original(settings)
    if settings.focal_length is not None:
        lens = prescription(settings)
        efl = lb.first_order(lens).efl
        document = scaled(document, settings.focal_length / efl)
    lens = document.lens
    return replace(document, lens=lens.at(zoom=settings.zoom)) if lens.zooms and settings.zoom else document


def with_document(settings: Settings, document: LensDocument) -> Settings:
    """The settings with an edited lens; without edits where the document is the original again."""
    lens = document.lens
    if lens.positions is not None:
        document = replace(document, lens=lens.at(zoom=0.0 if lens.zooms else None,
                                                  close=0.0 if lens.has_focus_groups else None))
    try:
        unedited = document == original(settings)
    except (ValueError, OSError):                       # the file of the lens is gone; its edits are not
        unedited = False
    return replace(settings, edited="" if unedited else to_text(document), focal_length=None)


def edited(settings: Settings, edit: Callable[[LensDocument], LensDocument]) -> tuple[Settings, tuple[Finding, ...]]:
    """The settings after an edit of the lens, and what the edit assumed; EditError where it is not allowed."""
    before = document_of(settings)
    try:
        after = edit(before)
    except lb.LensError as error:
        raise EditError(str(error)) from None
    if after == before:
        return settings, ()
    said = tuple(f for f in after.findings if f not in before.findings and f.kind is not Kind.UNSOLVED)
    changed = with_document(settings, after)
    return replace(changed, zoom=settings.zoom if after.lens.zooms else 0.0), said


def reverted(settings: Settings) -> Settings:
    """The settings with the lens as its file or the library has it."""
    return replace(settings, edited="")


@lru_cache(maxsize=32)
def faults_of(document: LensDocument) -> tuple[Finding, ...]:
    """Why a lens cannot be built or gives no picture, by surface."""
    from lensbench.lenses.editing.faults import faults  # loads all checks: not at the start of the window

    return faults(document)


def lens_faults(settings: Settings) -> tuple[Finding, ...]:
    """The faults of an edited lens; none of a published one, whose check the lens card shows."""
    return faults_of(document_of(settings)) if settings.edited and settings.has_lens else ()


def can_save_in_place(settings: Settings) -> bool:
    """Whether the lens comes from a file that can be written again."""
    path = Path(settings.lens)
    return path.suffix.lower() in lenses.WRITERS and path.is_file()


def edit_mark(settings: Settings) -> str:
    """A mark behind the name of a lens with unsaved edits, or ""."""
    return " *" if settings.edited else ""


def save_document(settings: Settings, path: Path) -> tuple[Settings, tuple[Finding, ...]]:
    """Save the lens of the settings, with its comments, solves and pickups, to a file, whose suffix is the format.

    An old file stays until the new one is complete. Returns the settings, for an edited lens with the file as their
    lens, without edits where the file holds all of them; and what the format could not hold. A lens without edits is
    saved scaled and zoomed. LensFileError or ExportError where the file cannot be written.
    """
    if not settings.edited:
        return settings, lenses.save(replace(document_of(settings), lens=published(settings)), path)
    document, moved = document_of(replace(settings, zoom=0.0)), tuple[Finding, ...]()
    with suppress(ValueError, OSError):                 # the file of the lens is gone
        document, moved = kept_in_focus(original(settings).lens, document)
    remarks = (*moved, *lenses.save(document, path), *_assumed(settings))
    saved = replace(settings, lens=str(path.resolve()), edited="", focal_length=None)
    try:
        holds_all = original(saved) == document
    except (ValueError, OSError):                       # a format whose reader refuses what its writer wrote
        holds_all = False
    return (saved if holds_all else settings), remarks


def _assumed(settings: Settings) -> tuple[Finding, ...]:
    """What the lens's reader assumed, which no lens file holds; estimated rims, solves and pickups are held."""
    assumed = [f for f in prescription(settings).findings if f.kind not in (Kind.RIM, Kind.RULE)]
    return tuple(replace(f, message=f"assumed when {Path(settings.lens).name} was read: {f.message}") for f in assumed)


def free_cells(document: LensDocument, vary: str) -> tuple["Cell", ...]:
    """The numbers that a word names ("radii", "thicknesses" or "all") and that no rule holds."""
    from lensbench.core.design.improve import variables

    return tuple(cell for cell in variables(document.lens, vary) if document.rule(*cell) is None)


def improved(document: LensDocument, cells: Sequence["Cell"], goal: "Goal", glasses: Sequence[lb.Glass] | None,
             progress: Callable[["Step"], None], cancelled: Callable[[], bool]) -> "Improvement":
    """The improvement of the lens of a document, whose solves and pickups are kept; LensError.

    glasses: those that may replace the glasses of the lens; None leaves them. Other arguments: as for `improve`.
    """
    from lensbench.core.design.improve import improve, substitute

    def rules(lens: lb.Lens) -> lb.Lens:
        return settled(replace(document, lens=lens)).lens

    cells = [cell for cell in cells if document.rule(*cell) is None]
    if glasses is None:
        return improve(document.lens, cells, goal, rules=rules, progress=progress, cancelled=cancelled)
    return substitute(document.lens, cells, goal, glasses, rules=rules, progress=progress, cancelled=cancelled)
