"""Presents render updates as tone-mapped textures, with histogram, difference and depth."""

import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from lensbench.app.bench.exposure import AppliedExposure, applied_exposure, exposed, look, meter_stops
from lensbench.app.bench.focus_plane import leans
from lensbench.app.bench.light_field_query import note, picture_settings
from lensbench.app.bench.tone import Difference, aov_codes, histogram
from lensbench.app.display.frame import Light, Mark, Picture, Pinned, View
from lensbench.app.display.gl_texture import SQUARES, Development, Screen, one_by_one, queue, softening
from lensbench.app.display.small_textures import Panorama
from lensbench.app.display.solid_view import Drawing, SolidView
from lensbench.app.drawing import theme
from lensbench.app.drawing.recorded import Memo
from lensbench.app.plots.blur import NONE, Blur
from lensbench.app.settings.setting_table import DEEP
from lensbench.app.settings.settings import RESTARTS_NOTHING, Settings
from lensbench.app.workers.light_field_worker import FieldPicture
from lensbench.app.workers.render_job import RenderUpdate
from lensbench.app.workers.render_worker import RenderWorker

SUBJECT = "lens", "scene", "camera"     # settings with which a picture shows something else
OFF_CENTRE = 0.35               # of the picture: farther from its middle nothing is marked as in focus


class Presenter:
    """Holds the newest picture; it stays until a newer one is there."""

    def __init__(self, worker: RenderWorker):
        self.update: RenderUpdate | None = None
        self.field_picture: FieldPicture | None = None  # of a light field, shown instead of the camera's picture
        self.pinned: RenderUpdate | None = None                 # the picture A
        self.light: NDArray[np.float32] = np.zeros((0, 0, 3), np.float32)  # on the screen, before the tone curve
        self._light_of: Any = None                      # the key of that light
        self._applied_exposure, self._off_meter = Memo(1), Memo(2)
        self.renderer = ""                              # GL's name of what draws
        self._worker = worker
        self._screen: Screen | None = None
        self._pinned_screen: Screen | None = None
        self._strip_screen: Screen | None = None
        self._solid_view: SolidView | None = None       # from when the 3-D view is first looked at
        self._panorama: Panorama | None = None          # from when one is first looked around in
        self._strip_of: Any = None                      # the key of its picture
        self._difference, self._apart, self._histogram = Memo(1), Memo(1), Memo(1)
        self._pins = 0                                  # counts the pictures A
        self._deep: RenderUpdate | None = None                  # the newest with a depth map
        self._exposure = 0.0                            # with which the scene on the screen is shown
        self._loaded: Any = None                        # the key of the loaded picture
        self._said: dict[Any, str] = {}                 # findings of the newest update

    def open(self) -> None:
        """Begin to draw in the current GL context."""
        moderngl.init_context()
        self.renderer = moderngl.get_context().info["GL_RENDERER"]
        self._screen = Screen(moderngl.get_context())
        if self.software:
            one_by_one(moderngl.get_context())

    def finish(self) -> None:
        """Wait for the processor that draws, if one does: other threads go on meanwhile."""
        waiting = queue(moderngl.get_context())
        if waiting is not None:
            waiting.finish()

    @property
    def software(self) -> bool:
        """Whether the processor draws, instead of a graphics card."""
        return any(name in self.renderer.lower() for name in ("llvmpipe", "softpipe", "swrast"))

    @property
    def drawn_by(self) -> str:
        """What draws the window, and what it leaves out, in a sentence."""
        without = ". No graphics card: the first samples are not softened" if self.software else ""
        return f"Drawn by {self.renderer}{without}."

    def take(self, view: View) -> None:
        """Take the newest update of the render worker."""
        update = self._worker.newest()
        if update is None or self._screen is None or update is self.update:
            return
        self.update = update
        self._say(update, view)
        if update.depth is not None:
            self._deep = update
            if view.mark is None:
                view.mark = _first_mark(update)

    def _say(self, update: RenderUpdate, view: View) -> None:
        """Show what the picture leaves out, until it no longer does.

        Figures follow the picture; a note that the user has dismissed does not come back with other figures.
        """
        # Not the text where it has figures: these change while the camera is dragged
        findings: dict[Any, str] = {(finding.kind if finding.figures else finding.message): finding.message[:1].upper()
                                    + finding.message[1:] for finding in update.findings}
        stale = {text for key, text in self._said.items() if findings.get(key) != text} & set(view.messages)
        view.notices.forget(lambda notice: notice.text in stale)
        for key, text in findings.items():
            if key not in self._said or self._said[key] in stale:
                view.say(text, note=True)
        self._said = findings

    def applied_exposure(self, settings: Settings) -> AppliedExposure | None:
        """The exposure of the picture in figures; None before the first picture."""
        update = self.update
        if update is None or update.raw:
            return None
        key = (update.key, look(settings), settings.shutter, settings.iso)
        return self._applied_exposure.of(key, lambda: applied_exposure(settings, update.image))

    def off_meter(self, settings: Settings) -> float | None:
        """Stops by which the camera's picture is brighter than its meter would have it; None for other quantities."""
        update = self.update
        if update is None or update.raw:
            return None
        key = (update.key, look(replace(settings, exposing="triangle")), settings.exposing, settings.shutter,
               settings.iso, settings.metering, settings.exposure)
        return self._off_meter.of(key, lambda: meter_stops(settings, update.image))

    def strip(self, image: NDArray[np.float32], of: Any, settings: Settings) -> int:
        """The GL name of a texture with a small linear picture for a panel, tone-mapped by these settings.

        of: its key; the texture is loaded again when the key changes.
        """
        self._strip_screen = self._strip_screen or Screen(moderngl.get_context(), self._screen)
        if self._strip_of != of:
            self._strip_of = of
            self._strip_screen.load(image)
        texture = self._strip_screen.developed(Development(settings.exposure, settings.tone))
        self._strip_screen.draw_at(SQUARES)
        return texture

    def solid_picture(self, drawing: Drawing, size: tuple[int, int]) -> int:
        """The GL name of a texture with the 3-D view, of this size in pixels."""
        self._solid_view = self._solid_view or SolidView(moderngl.get_context())
        return self._solid_view.picture(drawing, size)

    def pin(self, current: Settings) -> bool:
        """Keep the shown picture as A, exposed and tone-mapped by `current`; False if there is none yet."""
        if self.shown is None or self._screen is None:
            return False
        settings = replace(self.shown.settings, **{name: getattr(current, name) for name in RESTARTS_NOTHING})
        shown = self.shown if self.shown.plain is None else self.shown._replace(image=self.shown.plain)
        self._keep(shown._replace(settings=settings, image=_light(shown, current)))
        return True

    def repin(self, update: RenderUpdate, settings: Settings) -> None:
        """Show a newer update of A, exposed by A's own settings."""
        self._keep(update._replace(settings=settings, image=_light(update, settings)))

    def keep(self, image: NDArray[np.float32], settings: Settings) -> None:
        """Keep a picture of these settings as A."""
        self._keep(RenderUpdate(0, exposed(settings, image), settings.samples, 0.0, settings, 0.0))

    def keep_codes(self, codes: NDArray[np.float32], settings: Settings) -> None:
        """Keep a saved picture as A: codes of the screen (h, w, 3), from 0 to 1."""
        self._keep(RenderUpdate(0, codes, 0, 0.0, settings, 0.0, coded=True))

    def _keep(self, update: RenderUpdate) -> None:
        self.pinned = update
        self._pins += 1
        self._pinned_screen = self._pinned_screen or Screen(moderngl.get_context(), self._screen)
        self._pinned_screen.load(update.image)

    @property
    def shown(self) -> RenderUpdate | None:
        """The shown picture: the newest of the camera, or that of the light field."""
        if self.field_picture is None:
            return self.update
        field_picture = self.field_picture
        return RenderUpdate(0, field_picture.image, field_picture.recording.settings.samples, field_picture.seconds,
                            picture_settings(field_picture.recording, field_picture.look), 0.0,
                            coded=field_picture.coded, field_picture=field_picture.number)

    def picture(self, settings: Settings, view: View) -> Picture:
        """Contents of the render panel in this frame."""
        update, screen, waiting = self.shown, self._screen, self._worker.waiting
        if update is None or screen is None:
            return Picture(waiting=waiting, first=True)
        if update.settings.scene == settings.scene or self.field_picture is not None:
            self._exposure = settings.exposure
        settings = replace(settings, exposure=self._exposure)       # of the scene before, until the new one is there
        applied, off_meter = self.applied_exposure(settings), self.off_meter(settings)
        depth = self._distances(settings, update)
        of = (update.key, update.settings.view, look(settings))
        if of != self._light_of:
            self._light_of, self.light = of, _light(update, settings)
        deep = None if depth is None or self._deep is None else self._deep.generation
        if (of, deep) != self._loaded:
            self._loaded = (of, deep)
            screen.load(self.light, depth)
        texture = screen.developed(self._development(settings, view, update, depth is not None))
        pinned, difference = None, None
        if settings.compare != "off" and self.pinned is not None and self._pinned_screen is not None:
            pinned = self._other(self.pinned, self._pinned_screen, view)
            if settings.compare == "difference" and screen.size == pinned.size:
                a, b = self.pinned.image, self.light
                difference = self._difference.of((self._pins, of), lambda: Difference.of(a, b))
                texture = screen.apart(self._pinned_screen, difference.scale)
        around = self._around(settings, view, update, screen)
        texels = settings.pixels_x / screen.size[0] if self.field_picture is None else 1.0     # a coarse one: 2, 3, …
        screen.draw_at(view.scale * texels)
        light = Light(self.light, settings.exposure, "raw" if update.raw else settings.tone, settings.noise)
        if difference is not None and self.pinned is not None:
            apart = self._apart.of((self._pins, of), partial(_apart, self.pinned.image, self.light))
            light = Light(apart, tone="difference", scale=difference.scale)
        shares = None
        if view.histogram:
            tone = (settings.exposure, "raw" if update.raw else settings.tone, settings.noise)
            shares = self._histogram.of((of, tone), lambda: histogram(self.light, *tone))
        field = self.field_picture
        if field is not None:
            return Picture(texture, screen.size, update.samples, update.seconds, histogram=shares, pinned=pinned,
                           difference=difference, recorded=update.settings, light=light,
                           note=note(field.recording, field.look, field.has_depth),
                           applied=applied, off_meter=off_meter)
        return Picture(texture, screen.size, update.samples, update.seconds, self._worker.paused, waiting=waiting,
                       depth=self.depth(settings), histogram=shares, pinned=pinned, difference=difference, light=light,
                       applied=applied, around=around, off_meter=off_meter,
                       other=any(getattr(update.settings, name) != getattr(settings, name) for name in SUBJECT))

    def _around(self, settings: Settings, view: View, update: RenderUpdate, screen: Screen) -> int:
        """The GL name of the look around in a panorama; 0 if the picture is none, or is looked at as a whole."""
        if (view.look is None or settings.compare != "off" or self.field_picture is not None
                or not (settings.kind.panorama and update.settings.kind.panorama)):
            return 0
        shown = screen.shown
        if shown is None:
            return 0
        self._panorama = self._panorama or Panorama(moderngl.get_context())
        size = max(round(view.room[0]), 1), max(round(view.room[1]), 1)
        return self._panorama.picture(*shown, update.settings.layout, view.look, size)

    def depth(self, settings: Settings) -> NDArray[np.float32] | None:
        """The depth map (h, w) mm; None if there is none for the aim of these settings."""
        deep = self._deep
        return deep.depth if deep is not None and deep.settings.aim == settings.aim else None

    @staticmethod
    def _other(update: RenderUpdate, screen: Screen, view: View) -> Pinned:
        """The picture A, tone-mapped by its own settings."""
        own = update.settings
        texture = screen.developed(Development(own.exposure, "raw" if update.raw else own.tone, sensor=own.noise))
        screen.draw_at(view.scale)
        light = Light(update.image, own.exposure, "raw" if update.raw else own.tone, own.noise)
        return Pinned(texture, screen.size, update.samples, own, light)

    def _distances(self, settings: Settings, update: RenderUpdate) -> NDArray[np.float32] | None:
        """The depth map that the shaders need: for overlays, and to hide the noise of the first passes."""
        if self._deep is None or self.field_picture is not None or update.raw:
            return None
        is_needed = self._softening(update) > 0.0 or settings.overlay in DEEP
        return self._deep.depth if is_needed else None

    def _development(self, settings: Settings, view: View, update: RenderUpdate, deep: bool) -> Development:
        """Input of the shaders: the tone of the current settings, the blur of the picture's own settings."""
        if update.raw:
            return Development(0.0, "raw")
        if self.field_picture is not None:
            overlay = settings.overlay if settings.overlay == "clipping" else "none"
            return Development(settings.exposure, settings.tone, overlay, stripe=_stripe(view), sensor=settings.noise)
        blur = Blur.of(update.settings) if deep else NONE           # without a depth nothing uses it
        amber, nearer, farther = ((c[0], c[1], c[2]) for c in (theme.DARK.amber, theme.NEARER, theme.FARTHER))
        return Development(settings.exposure, settings.tone, settings.overlay, blur, _stripe(view), amber, nearer,
                           farther, settings.noise, self._softening(update) if deep else 0.0)

    def _softening(self, update: RenderUpdate) -> float:
        """The share of the softening; 0 where a processor draws, which takes longer for it than for a picture."""
        return 0.0 if self.software else softening(update.samples)


def _apart(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.abs(b - a)


def _stripe(view: View) -> float:
    """The width of the clipping zebra's stripes, in pixels of the picture."""
    return max(6.0 / max(view.scale, 0.05), 2.0)


def _light(update: RenderUpdate, settings: Settings) -> NDArray[np.float32]:
    """The image for the screen: linear light, exposed by these settings, or codes of other quantities."""
    if update.coded:
        return update.image
    return aov_codes(update.image, update.settings) if update.settings.sample_view else exposed(settings, update.image)


def _first_mark(update: RenderUpdate) -> Mark | None:
    """A place near the middle of the picture that is in focus, among many that are."""
    focus, depth = update.settings.focus_distance, update.depth
    if depth is None or not math.isfinite(focus) or leans(update.settings):     # sharp at other depths
        return None
    rows, columns = depth.shape
    sharp = np.abs(depth - focus) < 0.01 * focus
    y, x = np.nonzero(sharp)
    off = np.hypot(x / columns - 0.5, y / rows - 0.5)
    if not len(x) or off.min() > OFF_CENTRE:
        return None
    # The part of a square about each place that is in focus
    half = max(columns // 20, 1)
    sums = np.pad(np.pad(sharp, half).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    side = 2 * half + 1
    around = (sums[y + side, x + side] - sums[y, x + side] - sums[y + side, x] + sums[y, x]) / side**2
    nearest = int(np.argmax(around - off - 1e3 * (off > OFF_CENTRE)))
    return Mark((x[nearest] + 0.5) / columns, (y[nearest] + 0.5) / rows, focus, update.settings.aim)


def save_window(path: Path, size: tuple[int, int]) -> None:
    """Save a picture of the window as PNG; size: pixels across and down."""
    from PIL import Image

    screen = moderngl.get_context().screen
    screen.viewport = (0, 0, *size)
    pixels = np.frombuffer(screen.read(viewport=(0, 0, *size), components=3, alignment=1), np.uint8)
    Image.fromarray(np.ascontiguousarray(pixels.reshape(size[1], size[0], 3)[::-1])).save(path, "PNG")
