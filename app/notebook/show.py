"""`lb.show`: lenses, cameras, scenes and pictures side by side, in a notebook or in the browser."""

import html
import tempfile
import webbrowser
from pathlib import Path
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.notebook.cards import camera_card, lens_card, picture_element, scene_card
from lensbench.app.notebook.picture import DEVELOPED, checked, png
from lensbench.app.notebook.render import notebook_display


class Page:
    """Things side by side, as HTML; what `show` returns."""

    def __init__(self, parts: list[str]):
        self.html = ('<div style="display:flex; flex-wrap:wrap; gap:16px; align-items:flex-start">'
                     + "".join(f"<div>{part}</div>" for part in parts) + "</div>")

    def _repr_html_(self) -> str:
        return self.html

    def save(self, path: str | Path) -> None:
        """Write the page to an HTML file that stands alone.

        Parameters
        ----------
        path : str or path
            Of the file.
        """
        Path(path).write_text(f'<!doctype html><meta charset="utf-8"><title>lensbench</title>{self.html}',
                              encoding="utf-8")


def show(*things: Any, exposure: float = 0.0, tone: str = "filmic", open_browser: bool | None = None) -> Page:
    """Show lenses, cameras, scenes and pictures side by side.

    Parameters
    ----------
    *things : Lens, Camera, Scene, array or str
        Lenses and cameras as a section with figures, scenes as a small picture with figures, pictures (h, w, 3)
        developed, text as a caption.
    exposure : float
        Stops, for the pictures in linear light.
    tone : str
        "none", "filmic" or "agx", for these.
    open_browser : bool or None
        Whether the page opens in the web browser; None: not in a notebook, which shows the page itself.

    Returns
    -------
    Page
        With `html` and `save(path)`.

    Raises
    ------
    TypeError
        For things of other kinds.
    """
    if not things:
        raise TypeError("show what? Give a lens, a camera, a scene or a picture")
    page = Page([_part(thing, exposure, tone) for thing in things])
    in_notebook = notebook_display() is not None
    if open_browser or (open_browser is None and not in_notebook):
        with tempfile.NamedTemporaryFile("w", suffix=".html", prefix="lensbench-", delete=False) as file:
            place = Path(file.name)
        page.save(place)
        webbrowser.open(place.as_uri())
    return page


def _part(thing: Any, exposure: float, tone: str) -> str:
    if isinstance(thing, str):
        return f"<p>{html.escape(thing)}</p>"
    if isinstance(thing, lb.Lens):
        return lens_card(thing)
    if isinstance(thing, lb.Camera):
        return camera_card(thing)
    if isinstance(thing, np.ndarray):
        data = png(checked(thing), exposure, tone) if getattr(thing, "tone", "") != DEVELOPED else png(
            thing, 0.0, DEVELOPED)
        return picture_element(data)
    if isinstance(thing, lb.Scene):
        return scene_card(thing)
    raise TypeError(f"{type(thing).__name__} cannot be shown: give a lens, a camera, a scene or a picture (h, w, 3)")
