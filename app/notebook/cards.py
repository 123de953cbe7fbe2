"""Lenses, cameras, scenes and pictures as HTML, and `lb.show`, which puts them side by side.

A card has a section or a picture, and the numbers that people ask for.
"""

import base64
import html
import math
import tempfile
import webbrowser
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.notebook.render import DEVELOPED, checked, notebook_display, png, render
from lensbench.app.plots.section import elements, surface_curves
from lensbench.core.text import fixed, significant

WIDTH = 460                     # of a section, in pixels
PREVIEW, PREVIEW_SAMPLES = (300, 200), 8    # pixels of the picture of a scene
FOV = 0.45                      # of it (radians, up and down), where the scene states no subject
RAYS, TRIED = 7, 201            # of the axial fan, and heights on the first surface from which they are chosen
BEFORE = 0.25                   # of the section's length that is shown of the rays before the lens
GLASS, LINE, RAY, STOP, FILM = "#cfe3f3", "#4a6a85", "#d08a2c", "#222222", "#7a7a7a"


def section(lens: lb.Lens, film_distance: float | None = None, film_height: float = 0.0,
            focus_distance: float = math.inf) -> str:
    """Section of a lens as SVG: glass, stop, film and the rays of an axial object point.

    Args:
        lens: The lens as it stands.
        film_distance: Last vertex to film (mm); None: the paraxial focus, or no film where there is none.
        film_height: Half of the film's diagonal (mm).
        focus_distance: From the film to the object point on the axis (mm).
    Returns:
        An element `svg`, upright, the scene on the left.
    """
    curves = surface_curves(lens)
    behind = film_distance
    if behind is None:
        behind = lb.first_order(lens).bfl
        behind = behind if math.isfinite(behind) and 0.0 < behind < 20.0 * max(lens.length, 1.0) else None
    end = lens.length + (behind or 0.1 * max(lens.length, 1.0))
    left = min(float(np.concatenate(curves)[:, 0].min()), 0.0)
    before = BEFORE * (end - left)
    left, right = left - before, end
    tall = max([s.semi_diameter for s in lens.surfaces] + [film_height]) * 1.06
    scale = WIDTH / (right - left)
    parts = []

    def path(points: np.ndarray, style: str) -> None:
        where = " ".join(f"{fixed((z - left) * scale, 1)},{fixed((tall - y) * scale, 1)}"
                         for z, y in points[np.isfinite(points).all(1)])
        parts.append(f'<polyline points="{where}" {style}/>')

    for element in elements(lens):
        path(np.concatenate([element.outline, element.outline[:1]]), f'fill="{GLASS}" stroke="{LINE}"')
    for i, curve in enumerate(curves):          # surfaces in air, such as mirrors of glass left out: thin lines
        if i != lens.stop_index and all(lens.surfaces[k].glass.n_d == 1.0 for k in (i - 1, i) if k >= 0):
            path(curve, f'fill="none" stroke="{LINE}" stroke-dasharray="2 2"')
    path(np.array([[left, 0.0], [right, 0.0]]), f'stroke="{FILM}" stroke-width="0.5" stroke-dasharray="6 3"')
    for ray in _axial_rays(lens, end, focus_distance, left):
        path(ray, f'fill="none" stroke="{RAY}" stroke-width="0.8"')
    stop, z = lens.stop.semi_diameter, lens.vertices[lens.stop_index]
    for side in (1.0, -1.0):
        path(np.array([[z, side * stop], [z, side * min(1.3 * stop + 1.0, tall)]]),
             f'stroke="{STOP}" stroke-width="2"')
    if behind is not None:
        half = film_height or 0.6 * tall
        path(np.array([[end, -half], [end, half]]), f'stroke="{FILM}" stroke-width="3"')
    name = html.escape(lens.name or "lens")
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{fixed(2.0 * tall * scale, 0)}" '
            f'role="img" aria-label="Section of {name}">{"".join(parts)}</svg>')


def _axial_rays(lens: lb.Lens, end: float, focus_distance: float, left: float) -> list[np.ndarray]:
    """Paths (n, 2) of (z, y) of rays from the object point on the axis that the lens passes, from z = left to end."""
    heights = np.linspace(-1.0, 1.0, TRIED) * lens.surfaces[0].semi_diameter
    slopes = np.zeros(TRIED) if math.isinf(focus_distance) else heights / max(focus_distance - end, 1e-6)
    zero = np.zeros(TRIED)
    t = lb.trace(lens, np.stack([zero, heights + left * slopes, zero + left], 1),
                 np.stack([zero, slopes, zero + 1.0], 1), record=True)
    passed = np.flatnonzero(t.fate == lb.Fate.PASSED)
    assert t.paths is not None
    paths = []
    for k in passed[np.unique(np.linspace(0, len(passed) - 1, RAYS).round().astype(int))] if len(passed) else ():
        (_, y, z), (_, m, n) = t.points[k], t.directions[k]
        paths.append(np.array([*t.paths[k][:, [2, 1]], [end, y + (end - z) * m / n]]))
    return paths


def lens_card(lens: lb.Lens) -> str:
    """Section and figures of a lens as HTML."""
    fo = lb.first_order(lens)
    glasses = sum(surface.glass.n_d != 1.0 for surface in lens.surfaces)
    rows = [("Focal length", _length(fo.efl)), ("f-number", significant(fo.f_number, 3)),
            ("Back focus", _length(fo.bfl)), ("Length", _length(lens.length)),
            ("Surfaces", f"{len(lens.surfaces)}, {glasses} glasses")]
    if lens.positions is not None:
        rows.append(("Positions", "zoom or focus groups: lens.at(zoom, close)"))
    return _card(lens.name or "Lens", section(lens), rows)


def camera_card(camera: lb.Camera) -> str:
    """Figures of a camera as HTML, with the section of its lens if it has one."""
    film = camera.film
    rows = [("Film", f"{significant(film.width)} × {significant(film.height)} mm, "
             f"{film.pixels_x} × {film.pixels_y} pixels")]
    picture, title = "", type(camera).__name__
    if isinstance(camera, lb.LensCamera):
        title = f"{camera.lens.name or 'Lens'}, model {camera.model}"
        picture = section(camera.lens, camera.film_distance, 0.5 * film.diagonal, camera.focus_distance)
        fo = camera.first_order
        rows += [("Focal length", _length(fo.efl)), ("f-number", significant(fo.f_number, 3)),
                 ("Focus", "infinity" if math.isinf(camera.focus_distance) else
                  f"{significant(camera.focus_distance / 1000.0)} m from the film"),
                 ("Film distance", _length(camera.film_distance))]
    else:
        known = [field.name for field in fields(camera)]
        for name in ("fov", "width", "lens_radius", "focus_distance", "projection", "layout", "distance", "radius"):
            if name in known:
                value = getattr(camera, name)
                text = value if isinstance(value, str) else (
                    f"{significant(math.degrees(value))}°" if name == "fov" else _length(value))
                rows.append((name.replace("_", " ").capitalize(), text))
    rows.append(("Shutter", f"{significant(camera.exposure_time)} s, weights {camera.weights}"))
    return _card(title, picture, rows)


def scene_card(scene: lb.Scene) -> str:
    """Picture of a scene by a pinhole at the origin, framed on its subject, and its figures, as HTML."""
    fov = FOV if scene.subject is None else 2.0 * math.atan(0.5 * scene.subject[1] / scene.subject[0])
    film = lb.Film(pixels_x=PREVIEW[0], pixels_y=PREVIEW[1])
    picture = picture_element(png(render(lb.PerspectiveCamera(film, fov), scene, PREVIEW_SAMPLES, progress=False)))
    triangles = sum(len(mesh.triangles) for mesh in scene.meshes)
    lit = sum(shape.material.kind in ("light", "lamp") for shape in scene.objects)
    rows = [("Spheres", f"{len(scene.spheres)}"), ("Rectangles and disks", f"{len(scene.plates)}"),
            ("Meshes", f"{len(scene.meshes)}, {triangles} triangles"), ("Of these shine", f"{lit}"),
            ("Around them", ", ".join([*["floor"][:scene.floor is not None], *["sun"][:scene.sun is not None],
                                       "sky with a picture" if isinstance(scene.sky, lb.ImageSky) else "sky"]))]
    if scene.subject is not None:
        away, high = (significant(value / 1000.0) for value in scene.subject)
        rows.append(("Subject", f"at {away} m, {high} m high"))
    return _card(scene.name, picture, rows)


def picture_element(data: bytes) -> str:
    """An element `img` that holds a PNG."""
    return f'<img src="data:image/png;base64,{base64.b64encode(data).decode("ascii")}" alt="picture">'


def _length(value: float) -> str:
    return "infinity" if math.isinf(value) else f"{significant(value)} mm"


def _card(title: str, picture: str, rows: list[tuple[str, str]]) -> str:
    cells = "".join(f"<tr><td>{html.escape(name)}</td><td>{html.escape(text)}</td></tr>" for name, text in rows)
    return f"<div><strong>{html.escape(title)}</strong><br>{picture}<table>{cells}</table></div>"


class Page:
    """Things side by side, as HTML; what `show` returns."""

    def __init__(self, parts: list[str]):
        self.html = ('<div style="display:flex; flex-wrap:wrap; gap:16px; align-items:flex-start">'
                     + "".join(f"<div>{element}</div>" for element in parts) + "</div>")

    def _repr_html_(self) -> str:
        return self.html

    def save(self, path: str | Path) -> None:
        """Write the page to an HTML file that stands alone.

        Args:
            path: Of the file.
        """
        Path(path).write_text(f'<!doctype html><meta charset="utf-8"><title>lensbench</title>{self.html}',
                              encoding="utf-8")


def show(*things: Any, exposure: float = 0.0, tone: str = "filmic", open_browser: bool | None = None) -> Page:
    """Show lenses, cameras, scenes and pictures side by side.

    Args:
        *things: Lenses and cameras as a section with figures, scenes as a small picture with figures, pictures (h, w,
            3) developed, text as a caption.
        exposure: Stops, for the pictures in linear light.
        tone: "none", "filmic" or "agx", for these.
        open_browser: Whether the page opens in the web browser; None: not in a notebook, which shows the page itself.
    Returns:
        With `html` and `save(path)`.
    Raises:
        TypeError: For things of other kinds.
    """
    if not things:
        raise TypeError("show what? Give a lens, a camera, a scene or a picture")
    page = Page([_element(thing, exposure, tone) for thing in things])
    in_notebook = notebook_display() is not None
    if open_browser or (open_browser is None and not in_notebook):
        with tempfile.NamedTemporaryFile("w", suffix=".html", prefix="lensbench-", delete=False) as file:
            path = Path(file.name)
        page.save(path)
        webbrowser.open(path.as_uri())
    return page


def _element(thing: Any, exposure: float, tone: str) -> str:
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
