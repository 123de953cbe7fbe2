"""Saving of an edited lens, with its comments, solves and pickups where the format holds them."""

from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from lensbench import lenses
from lensbench.app.state.build import prescription
from lensbench.app.state.lens_edit.editing import document_of, original
from lensbench.app.state.settings import Settings
from lensbench.lenses.editing.structure import kept_in_focus
from lensbench.optics.finding import Finding, Kind


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
    """What the reader of the lens's file assumed: no lens file holds that, so the new one would not say it again.

    An estimate of rims is held, as `estimates`; solves and pickups are those of the document.
    """
    assumed = [f for f in prescription(settings).findings if f.kind not in (Kind.RIM, Kind.RULE)]
    return tuple(replace(f, message=f"assumed when {Path(settings.lens).name} was read: {f.message}") for f in assumed)
