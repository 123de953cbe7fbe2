"""The blur of every pixel, for the overlays, the softening of the first passes, and the figures of a pixel.

Lengths in mm, camera frame. What a pixel sees `depth` before the film has a circle of confusion of the diameter gain ·
|1/(focus − offset) − 1/(depth − offset)| pixels, `offset` being the distance of the entrance pupil, or of the
front principal plane, from the film. For a lens and a film in line the three numbers are those of the formula of the
thin lens, and the same for all pixels. Before a film out of line they change with the place: in closed form for ideal
lenses. A lens that is traced, or out of line, has them from traced beams: no formula knows its field curvature there.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from lensbench.analysis.traced_focus import Beams, beams
from lensbench.app.state.build import setup
from lensbench.app.state.figures import blur_limit, readings
from lensbench.app.state.file_cache import Stamp, file_stamp
from lensbench.app.state.settings import Settings
from lensbench.app.state.view_camera import lens_leans

ACROSS, DOWN = 9, 7                    # nodes of traced beams
FINE = 49                               # nodes along each side of a curved film behind an ideal lens
DIAMETER = 2.0 * math.sqrt(2.0)         # of a disc over its rms radius


@dataclass(frozen=True, eq=False)
class Blur:
    """The circles of confusion over a picture: pixels = |focused − gain / (depth − offset)|.

    nodes (rows, columns, 3): focused = gain / (focus − offset) (pixels), gain (pixels · mm) and offset (mm) at places
    evenly from the picture's upper left corner to its lower right one, linear between them. sharp: the diameter up to
    which a pixel counts as in focus.
    """

    nodes: np.ndarray
    sharp: float = 1.5

    @classmethod
    def even(cls, gain: float, focus: float, offset: float = 0.0, sharp: float = 1.5) -> "Blur":
        """The blur of all pixels alike; focus: one over the distance of what is in focus beyond the offset (1/mm)."""
        return cls(np.array([[[gain * focus, gain, offset]]]), sharp)

    @cached_property
    def blurs(self) -> bool:
        """Whether anything is blurred."""
        return bool((self.nodes[..., 1] > 0.0).any())

    def pixels(self, depth: float, part: tuple[float, float]) -> float:
        """The diameter (pixels) of a point at a depth (mm, or inf) that a part of the picture shows."""
        at = np.array(part) * (np.array(self.nodes.shape[1::-1]) - 1)
        low = np.clip(np.floor(at).astype(int), 0, np.maximum(np.array(self.nodes.shape[1::-1]) - 2, 0))
        (u, v), (i, j) = np.clip(at - low, 0.0, 1.0), low
        here = self.nodes[j:j + 2, i:i + 2]
        weights = np.outer([1.0 - v, v], [1.0 - u, u])[:here.shape[0], :here.shape[1]]
        focused, gain, offset = np.einsum("ji,jic->c", weights, here).tolist()
        return abs(focused - (0.0 if math.isinf(depth) else gain / max(depth - offset, 1.0)))

    @classmethod
    def of(cls, settings: Settings) -> "Blur":
        """The blur of these settings; none where nothing is blurred, or where there is no lens."""
        try:
            return _blur(settings.optics, file_stamp(settings.lens))
        except (ValueError, OSError, ZeroDivisionError):
            return NONE


NONE = Blur.even(0.0, 0.0)


@lru_cache(maxsize=16)
def _blur(settings: Settings, lens: Stamp) -> Blur:
    if not (settings.has_stop and settings.kind.f_number):
        return NONE
    pitch, sharp = settings.film.pitch, blur_limit(settings)
    pose = settings.film_pose
    if lens_leans(settings) or settings.follows_lens and (pose.is_tilted or pose.is_curved):
        return Blur(_traced(settings), sharp / pitch)
    if settings.kind.ideal_lens:
        offset, efl, f_number = 0.0, readings(settings).efl or 50.0, settings.f_number or math.inf
    else:
        built = setup(settings)
        offset, efl, f_number = built.principal_offset, built.first_order.efl, built.first_order.f_number
    focus = 1.0 / max(settings.focus_distance - offset, 1.01 * abs(efl))
    gain = efl * efl / f_number / (1.0 - efl * focus) / pitch
    if settings.kind.ideal_lens or not (pose.is_tilted or pose.is_curved):
        return Blur.even(gain, focus, offset, sharp / pitch)
    # A film point that lies so much farther behind the rear principal plane, in parts: the formula of its own film
    behind = built.film_distance - built.first_order.rear_principal
    count = FINE if pose.is_curved else 2
    places = pose.points(_film_places(settings, count, count).reshape(-1, 2))
    lean = places[:, 2].reshape(count, count) / behind
    return Blur(np.stack([gain * (focus + lean / efl), gain * (1.0 + lean), np.full(lean.shape, offset)], -1),
                sharp / pitch)


def _film_places(settings: Settings, across: int, down: int) -> np.ndarray:
    """Film points (down, across, 2) of the nodes, in the frame of the film."""
    x, y = np.meshgrid(np.linspace(0.5, -0.5, across), np.linspace(-0.5, 0.5, down))
    return np.stack([x * settings.film.width, y * settings.film.height], -1)


def _traced(settings: Settings) -> np.ndarray:
    """Nodes of a lens whose beams are traced: where they are narrowest, and how wide the stop makes them.

    A thing at the distance t from the entrance pupil of a beam is as wide on the film as the beam is there, seen from
    the pupil, times the way of the image for a turn of the beam. Both come from beams side by side, which turn about
    the pupil.
    """
    built, places = setup(settings), _film_places(settings, ACROSS, DOWN)
    film = settings.film_pose.points(places.reshape(-1, 2))
    narrow = beams(built.lens, built.film_distance, film)
    whole = beams(built.lens, built.film_distance, film, whole=True)
    focused = whole if built.focusing.method == "real" else narrow
    directions, starts = (values.reshape(DOWN, ACROSS, 3) for values in (narrow.directions, narrow.starts))
    steps = places[0, 1, 0] - places[0, 0, 0], places[1, 0, 1] - places[0, 0, 1]

    def slopes(values: np.ndarray) -> np.ndarray:
        """Changes (n, 3, 2) for a mm across and down the film, across the beam."""
        change = np.stack([np.gradient(values, steps[0], axis=1), np.gradient(values, steps[1], axis=0)], -1)
        along = (change * directions[..., None]).sum(2, keepdims=True)
        return np.asarray((change - directions[..., None] * along).reshape(-1, 3, 2))

    turns, moves = slopes(directions), slopes(starts)
    good = np.isfinite(turns).all((1, 2)) & np.isfinite(moves).all((1, 2)) & np.isfinite(focused.nearness)
    good &= np.isfinite(whole.nearness)
    if not good.any():
        raise ValueError("no light reaches the film")
    turns, moves = turns[good], moves[good]
    pupil = -(turns * moves).sum((1, 2)) / (turns * turns).sum((1, 2))          # along the beams, from where they begin
    image = np.linalg.pinv(turns)                                               # mm on the film for a turn
    across = _across(whole, pupil, good)
    size = DIAMETER * np.sqrt(np.trace(image @ across @ image.transpose(0, 2, 1), axis1=1, axis2=2))
    depth = -(narrow.starts[good] + pupil[:, None] * narrow.directions[good])[:, 2]
    gain = size * -narrow.directions[good, 2] / settings.film.pitch
    nearness = focused.depth_nearness[good]
    nodes = np.empty((len(film), 3))
    # 1/(f − o) of a focus that may lie at infinity, and beyond
    nodes[good] = np.stack([gain * nearness / (1.0 - nearness * depth), gain, depth], -1)
    away = np.linalg.norm(film[:, None] - film[good], axis=2).argmin(1)         # dark nodes: as the nearest
    return np.asarray(nodes[good][away].reshape(DOWN, ACROSS, 3))


def _across(whole: Beams, pupil: np.ndarray, good: np.ndarray) -> np.ndarray:
    """Mean squares and products (n, 3, 3) of the places of rays in their pupils, mm²."""
    t, mixed = pupil[:, None, None], whole.mixed[good]
    return np.asarray(whole.across[good] + t * (mixed + mixed.transpose(0, 2, 1)) + t * t * whole.slopes[good])
