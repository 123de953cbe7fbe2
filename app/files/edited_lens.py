"""Saving of an edited lens, with its comments, solves and pickups where the format holds them."""

from dataclasses import replace
from pathlib import Path

from lensbench import lenses
from lensbench.app.files.export import replacing
from lensbench.app.state.build import prescription
from lensbench.app.state.lens_edit.editing import document_of, original
from lensbench.app.state.settings import Settings
from lensbench.lenses.editing.document import LensDocument
from lensbench.lenses.editing.document_text import lost_edits, to_text
from lensbench.lenses.stop_picture import with_picture_beside
from lensbench.optics.finding import Finding, Kind


def write_document(document: LensDocument, path: Path) -> tuple[Finding, ...]:
    """Write a document in the format of the suffix; what the format could not hold. LensFileError, ExportError."""
    if path.suffix.lower() != ".toml":
        return (*lenses.save(document.lens, path), *lost_edits(document))
    lens, placed = with_picture_beside(document.lens, path)
    with replacing(path) as part:
        part.write_text(to_text(replace(document, lens=lens)), encoding="utf-8")
    return tuple(placed)


def save_document(settings: Settings, path: Path) -> tuple[Settings, tuple[Finding, ...]]:
    """Save the edited lens of the settings.

    Parameters
    ----------
    settings : Settings
        With an edited lens.
    path : Path
        The file; its suffix says the format. An old file stays until the new one is complete.

    Returns
    -------
    tuple of Settings and tuple of Finding
        The settings with the file as their lens, without edits where the file holds all of them; and what the format
        could not hold.

    Raises
    ------
    LensFileError, ExportError
        Where the file cannot be written.
    """
    document = document_of(replace(settings, zoom=0.0))
    remarks = (*write_document(document, path), *_assumed(settings))
    saved = replace(settings, lens=str(path.resolve()), edited="", focal_length=None)
    try:
        holds_all = original(saved) == document
    except (ValueError, OSError):                       # a format whose reader refuses what its writer wrote
        holds_all = False
    return (saved if holds_all else settings), remarks


def _assumed(settings: Settings) -> tuple[Finding, ...]:
    """What the reader of the lens's file assumed: no lens file holds that, so the new one would not say it again.

    An estimate of rims is held, as `estimates`.
    """
    assumed = [f for f in prescription(settings).findings if f.kind is not Kind.RIM]
    return tuple(replace(f, message=f"assumed when {Path(settings.lens).name} was read: {f.message}") for f in assumed)
