"""Pictures as arrays that a notebook shows, developed and saved; and `lb.render`, with a progress bar in a notebook."""

import io
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from numbers import Integral
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.bench import tone as tones
from lensbench.app.scenes.scene_file import find_scene
from lensbench.app.session.export import ExportError, save_picture, write_png
from lensbench.app.settings.setting_table import TONES
from lensbench.app.settings.settings import Settings
from lensbench.core.rendering.progressive import Rendering
from lensbench.core.text import fixed

LINEAR_SUFFIXES = (".exr", ".pfm")
DEVELOPED = "raw"               # tone of values that are screen codes


class Picture(np.ndarray):
    """Picture that a notebook shows as it looks on the screen; an array like any other.

    Args:
        values: (h, w, 3) array. Red, green and blue. The picture is a view of it, not a copy.
        tone: Tone curve with which it is shown: "filmic" for linear light; "raw" for a picture that is developed. It
            stays as the attribute `tone`.
    """

    tone: str

    def __new__(cls, values: Any, tone: str = Settings.tone) -> "Picture":
        """Picture of an array, of which it takes no copy."""
        picture = np.asarray(values).view(cls)
        picture.tone = tone
        return picture

    def __array_finalize__(self, other: Any) -> None:
        self.tone = getattr(other, "tone", Settings.tone)

    def __array_wrap__(self, values, context=None, return_scalar: bool = False):
        """Results that are no pictures, such as a mean, as plain numbers and arrays."""
        if return_scalar or values.ndim == 0:
            return values[()]
        return super().__array_wrap__(values, context) if values.shape == self.shape else values.view(np.ndarray)

    @property
    def is_shown(self) -> bool:
        """Whether the array has the shape of a picture: a part of one, such as a channel, is shown as numbers."""
        return self.ndim == 3 and self.shape[2] == 3 and min(self.shape[:2]) > 0

    def _repr_png_(self) -> bytes | None:
        return png(self, 0.0, self.tone) if self.is_shown else None


def develop(image, exposure: float = 0.0, tone: str = "filmic") -> Picture:
    """Developed picture: exposure, a tone curve and sRGB, as in the window.

    Args:
        image: (h, w, 3) array. Linear light, as `render` returns it. NaN becomes black.
        exposure: Stops; +1 doubles the light.
        tone: "none", "filmic" or "agx".
    Returns:
        (h, w, 3) sRGB values in [0, 1], float64.
    Raises:
        ValueError: For an array of another shape, an exposure that is not finite or an unknown tone curve.
    """
    return Picture(_developed(checked(image), exposure, tone), DEVELOPED)


def save(image, path: str | os.PathLike[str], exposure: float = 0.0, tone: str = "filmic", bits: int = 8) -> None:
    """Write a picture to a file; an older file is replaced when the new one is complete.

    Args:
        image: (h, w, 3) array. Linear light, as `render` returns it, or what `develop` returns.
        path: ".png" and ".ppm" hold the developed picture, ".exr" and ".pfm" linear light.
        exposure: Stops; for developed pictures only.
        tone: "none", "filmic" or "agx"; for developed pictures only.
        bits: 8 or 16, of a PNG or PPM.
    Raises:
        ExportError: For another suffix or depth, errors of the disk, and a developed picture in a format of linear
            light.
        ValueError: As `develop`.
    """
    picture, path = checked(image), Path(path)
    linear = path.suffix.lower() in LINEAR_SUFFIXES
    if getattr(image, "tone", "") == DEVELOPED:
        if linear:
            raise ExportError(f"{path}: this picture is developed, and {path.suffix} holds linear light: save the "
                              "picture that was rendered")
        if exposure != 0.0:
            raise ValueError("this picture is developed: give the exposure to develop, or save the rendered picture")
        return save_picture(path, picture, _settings(0.0, DEVELOPED), bits, described=False)
    if linear and (exposure != 0.0 or tone != "filmic"):
        raise ValueError(f"{path}: linear light is written as it is, without exposure and tone curve: leave them out")
    save_picture(path, picture, _settings(exposure, tone), bits, described=False)


def png(image, exposure: float = 0.0, tone: str = "filmic") -> bytes:
    """PNG of 8 bits of a picture (h, w, 3); tone "raw" for one that is developed."""
    file, picture = io.BytesIO(), checked(image)
    write_png(file, (picture.shape[0], picture.shape[1]), [picture], _settings(exposure, tone))
    return file.getvalue()


def checked(image) -> np.ndarray:
    """The picture as a plain array of floats; ValueError where it is no picture."""
    array = np.asarray(image)
    if array.ndim != 3 or array.shape[2] != 3 or not min(array.shape):
        raise ValueError(f"an array of the shape {array.shape} is not a picture: it must be (height, width, 3)")
    if array.dtype.kind != "f":
        raise ValueError(f"a picture of {array.dtype}: it must hold linear light as floats, with 1 as white")
    return array


def _developed(image: np.ndarray, exposure: float, tone: str) -> np.ndarray:
    settings = _settings(exposure, tone)
    return tones.develop(np.nan_to_num(image, nan=0.0, posinf=1e9, neginf=0.0), settings.exposure, settings.tone)


def _settings(exposure: float, tone: str) -> Settings:
    """Settings with this exposure (stops) and tone curve; ValueError for invalid ones."""
    if tone == DEVELOPED:
        return Settings(tone=DEVELOPED)
    if tone not in TONES:
        raise ValueError(f"tone curve {tone!r}: choose one of {', '.join(TONES)}")
    return Settings(exposure=float(exposure), tone=tone).checked()


# Rendering with a progress bar


SILENT = 1.0                    # seconds before a bar appears


def notebook_display() -> Any:
    """The function `IPython.display.display` in a notebook; None elsewhere, as in a terminal."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    if shell is None or not hasattr(shell, "kernel"):
        return None
    from IPython.display import display  # type: ignore[import-not-found]
    return display


class _Html:
    def __init__(self, html: str):
        self._html = html

    def _repr_html_(self) -> str:
        return self._html


@contextmanager
def shown_progress(progress: bool | Callable[[float], object] | None) -> Iterator[Callable[[float], object] | None]:
    """Function to call with the share that is done, 0 to 1; None where no progress is shown.

    wanted: a function of the caller; True or False for a bar; None: a bar in a notebook alone.
    """
    if callable(progress):
        yield progress
        return
    display = notebook_display()
    if progress is False or display is None:
        yield None
        return
    started, handle = perf_counter(), None

    def show(share: float) -> None:
        nonlocal handle
        passed = perf_counter() - started
        if handle is None and passed > SILENT:
            handle = display(_Html(_bar(share, passed)), display_id=True)
        elif handle is not None:
            handle.update(_Html(_bar(share, passed)))

    try:
        yield show
    finally:
        if handle is not None:
            handle.update(_Html(""))


def _bar(share: float, passed: float) -> str:
    left = f"{fixed(passed / share - passed, 0)} s left" if share > 0.02 else ""
    return f'<progress value="{fixed(share, 3)}"></progress> {fixed(100.0 * share, 0)} % {left}'


MOST_BATCH = 16                 # samples between two steps of the progress bar


def render(camera: "lb.Camera | str | os.PathLike[str]", scene: "lb.Scene | str | os.PathLike[str]",
           samples: int = 64, seed: int = 0, threads: int | None = None,
           progress: bool | Callable[[float], object] | None = None, flare: "lb.Flare | None" = None) -> Picture:
    """Picture of a scene.

    Args:
        camera: Any camera; a LensCamera of the model "auto" takes the model that the scene needs. The name of a lens or
            the path of its file means that lens as `lensbench render` takes it: wide open, on its own film, in front of
            the scene's subject.
        scene: The scene, world frame, mm; or the name of a built-in scene or the path of a scene file.
        samples: Samples per pixel, at least 1.
        seed: Sampler seed.
        threads: Number of threads; None: one for each core. The picture is the same, bit for bit, for any number.
        progress: Whether a progress bar is shown; None: in a notebook, for a picture that takes more than a second. A
            function receives the part that is done, 0 to 1, between passes over the picture.
        flare: Ghosts and stars of the sun and of small lights, such as `lb.Flare("single-layer", stars=1.0)`; None:
            none.
    Returns:
        float32 (h, w, 3), linear RGB, the top row first: an array that a notebook shows developed.
    Raises:
        ValueError: For fewer than one sample, and for ghosts of a camera or scene that can have none.
        TypeError: For a number of samples that is not whole; for what is neither a camera nor the name of a lens, or
            neither a scene nor the name of one; and for the name of a lens with a scene that has no name, in which its
            place is not known.
        LensFileError, SceneFileError, CameraError: Names and files that are not found or cannot be read; cameras that
            cannot be rendered.
    """
    if not isinstance(samples, Integral):
        raise TypeError(f"{samples!r} samples a pixel: it must be a whole number")
    if samples < 1:
        raise ValueError(f"{samples} samples a pixel: at least 1 is needed")
    scene_name = os.fspath(scene) if isinstance(scene, str | Path) else None
    world = find_scene(scene_name) if scene_name is not None else scene
    if not isinstance(world, lb.Scene):
        raise TypeError(f"{_kind(scene)} is not a scene: give an lb.Scene, the name of a built-in scene "
                        f"({', '.join(lb.SCENES)}) or the path of a scene file")
    view = _camera(camera, world, scene_name)
    if flare is not None and lb.why_no_ghosts(view, world):
        raise ValueError(lb.why_no_ghosts(view, world))
    rendering = Rendering(view, world, seed, flare=flare)
    with shown_progress(progress) as show:
        if show is None:
            rendering.add(samples, threads=threads)
        while rendering.samples < samples:
            rendering.add(min(max(rendering.samples, 1), MOST_BATCH, samples - rendering.samples), threads=threads)
            assert show is not None
            show(rendering.samples / samples)
    return Picture(rendering.image())


def _camera(camera: Any, scene: "lb.Scene", scene_name: str | None) -> "lb.Camera":
    """The camera, or the one of a lens's name."""
    if isinstance(camera, lb.Camera):
        return camera
    if isinstance(camera, lb.Lens):
        raise TypeError("a lens is no camera yet: lb.LensCamera(lens, lb.Film(), focus_distance) puts it before a film")
    if not isinstance(camera, str | Path):
        raise TypeError(f"{_kind(camera)} is not a camera: give a camera such as lb.LensCamera, the name of a lens or "
                        "the path of its file")
    from lensbench.app.bench.camera_kinds import camera as camera_of
    from lensbench.app.bench.lens_choice import with_lens
    from lensbench.app.settings.settings import Settings

    name = scene_name or next((name for name in lb.SCENES if lb.builtin_scene(name) is scene), None)
    if name is None:
        raise TypeError("the name of a lens alone does not place the camera in a scene of your own: give "
                        "lb.LensCamera(lenses.load(name), lb.Film(), focus_distance)")
    return camera_of(with_lens(Settings(scene=name), os.fspath(camera)))


def _kind(value: Any) -> str:
    return type(value).__name__


def load_scene(name_or_path: str | os.PathLike[str]) -> "lb.Scene":
    """Scene of a name or of a file.

    Args:
        name_or_path: A name of `SCENES`, or the path of a scene file (TOML).
    Raises:
        SceneFileError: An unknown name, or a file that cannot be read; it describes the fault in one line.
    """
    return find_scene(os.fspath(name_or_path))
