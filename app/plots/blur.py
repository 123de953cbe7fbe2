"""The blur of every pixel, and the circle of confusion as curves against distance.

Lengths in mm, camera frame. What a pixel sees `depth` before the film has a circle of confusion of the diameter gain ·
|1/(focus − offset) − 1/(depth − offset)| pixels, `offset` being the distance of the entrance pupil, or of the
front principal plane, from the film. For a centred lens and film the three numbers are those of its first order,
and the same for all pixels. Before a tilted film they change with the position: in closed form for ideal lenses. A
lens that is traced, or has tilted or decentred elements, has them from traced beams: no formula knows its field
curvature there.

Distances in metres from the film, beyond a window into water as well; diameters in micrometres on the film.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import Bench, bench_of
from lensbench.app.bench.camera_kinds import focused_lens, readings
from lensbench.app.bench.focus_plane import lens_leans
from lensbench.app.bench.readouts import Readings, blur_limit
from lensbench.app.bench.tone import round_above
from lensbench.app.bench.water_window import port_of
from lensbench.app.scenes.asset_files import Stamp, file_stamp
from lensbench.app.settings.dial_scales import WHOLE_STOPS
from lensbench.app.settings.settings import Settings
from lensbench.core.analysis.focus_wedge import Beams, beams
from lensbench.core.cameras.flat_port import FlatPort
from lensbench.core.text import fixed, significant

ACROSS, DOWN = 9, 7                    # nodes of traced beams
FINE = 49                               # nodes along each side of a curved film behind an ideal lens
FAR_PUPIL = 100.0                       # × the distance from film to first vertex
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
        """The same blur for all pixels; focus: one over the distance of what is in focus beyond the offset (1/mm)."""
        return cls(np.array([[[gain * focus, gain, offset]]]), sharp)

    @cached_property
    def blurs(self) -> bool:
        """Whether anything is blurred."""
        return bool((self.nodes[..., 1] > 0.0).any())

    def pixels(self, depth: float, share: tuple[float, float]) -> float:
        """The diameter (pixels) of a point at a depth (mm, or inf) that a part of the picture shows."""
        position = np.array(share) * (np.array(self.nodes.shape[1::-1]) - 1)
        low = np.clip(np.floor(position).astype(int), 0, np.maximum(np.array(self.nodes.shape[1::-1]) - 2, 0))
        (u, v), (i, j) = np.clip(position - low, 0.0, 1.0), low
        corners = self.nodes[j:j + 2, i:i + 2]
        weights = np.outer([1.0 - v, v], [1.0 - u, u])[:corners.shape[0], :corners.shape[1]]
        focused, gain, offset = np.einsum("ji,jic->c", weights, corners).tolist()
        return abs(focused - (0.0 if math.isinf(depth) else gain / max(depth - offset, 1.0)))

    @classmethod
    def of(cls, settings: Settings) -> "Blur":
        """The blur of these settings; none where nothing is blurred, or where there is no lens."""
        try:
            return _blur(settings.optics, file_stamp(settings.lens))
        except (ValueError, OSError, ZeroDivisionError):
            return NONE


NONE = Blur.even(0.0, 0.0)


def sharp_range(settings: Settings) -> str:
    """Near and far limit in the middle of the picture, such as "1.16 to 1.24 m"; "" where nothing is in focus."""
    got = readings(settings)
    if got.near_limit is None or got.far_limit is None:
        return ""
    near, far = got.near_limit / 1000.0, got.far_limit / 1000.0
    if not 0.0 < far < math.inf:
        return f"{significant(near, 3)} m to infinity"
    digits = max(2 if near < 2.0 else 1, min(6, -math.floor(math.log10(max(far - near, 1e-6)))))
    return f"{fixed(near, digits)} to {fixed(far, digits)} m"


def focus_words(settings: Settings) -> str:
    """What is sharp, and how blurred the far background is, in a sentence; "" where the camera has no focus."""
    limits = sharp_range(settings)
    if not limits:
        return ""
    got, blur = readings(settings), Blur.of(settings)
    middle = " in the middle" if settings.film_pose.is_tilted else ""
    share = 100.0 * blur.pixels(math.inf, (0.5, 0.5)) / settings.film.pixels_x
    behind = "background sharp" if share * settings.film.width <= 100.0 * blur_limit(settings) else \
        f"background blur {significant(share, 1 if share < 10.0 else 2)} % of the frame"
    return f"{'Sharpest' if got.soft else 'Sharp'}{middle} from {limits}; {behind}"


@lru_cache(maxsize=16)
def _blur(settings: Settings, lens: Stamp) -> Blur:
    if not settings.has_f_number:
        return NONE
    pitch, sharp = settings.film.pitch, blur_limit(settings)
    pose = settings.film_pose
    if lens_leans(settings) or settings.follows_lens and (pose.is_tilted or pose.is_curved):
        built = bench_of(settings)
        return Blur(_through(built.port, _traced(settings), settings, built.first_order.efl), sharp / pitch)
    if settings.kind.ideal_lens:
        port, efl = port_of(settings), readings(settings).efl or 50.0
        focus, gain = 1.0 / port.apparent(settings.focus_distance), efl * efl / (settings.f_number or math.inf) / pitch
        return Blur(_through(port, np.array([[[gain * focus, gain, 0.0]]]), settings, efl), sharp / pitch)
    built = bench_of(settings)
    count = FINE if pose.is_curved else 2 if pose.is_tilted else 1
    behind = np.zeros((count, count)) if count == 1 else \
        pose.points(_film_places(settings, count, count).reshape(-1, 2))[:, 2].reshape(count, count)
    return Blur(_through(built.port, _of_lens(built, behind) / [pitch, pitch, 1.0], settings, built.first_order.efl),
                sharp / pitch)


def _of_lens(built: Bench, behind: np.ndarray) -> np.ndarray:
    """Nodes (rows, columns, 3) of a centred lens, in mm, for film points so much farther from it (mm).

    A point at t from the entrance pupil, of the diameter D, is as wide on the film as D m |t′ − t| / t, t′ the distance
    in focus and m its magnification. A pupil that is far from the lens, or beyond the focus, has the formula of the
    thin lens in the front principal plane.
    """
    fo, focused = built.first_order, built.focus_distance
    if built.refused:                                   # not focused as set
        focused = lb.focused_distance(built.lens, built.film_distance)
    plane = fo.entrance_pupil.z
    diameter = 2.0 * fo.entrance_pupil.radius * built.lens.iris.equivalent_radius
    if not (abs(plane) < FAR_PUPIL * built.film_z and focused > built.film_z - plane):
        plane, diameter = fo.front_principal, fo.efl / fo.f_number
    offset, magnification = built.film_z - plane, lb.magnification(built.lens, built.film_distance, focused)
    image = magnification * (focused - offset) if math.isfinite(focused) else built.lens.front_index * fo.efl
    return np.stack([diameter * (magnification + behind / fo.efl),
                     diameter * (image + behind * (plane - fo.ffl) / fo.efl), np.full(behind.shape, offset)], -1)


def _through(port: FlatPort, nodes: np.ndarray, settings: Settings, efl: float) -> np.ndarray:
    """The nodes of a camera in air for depths behind its window into water.

    What is at the depth d appears at w + (d − w) / n: beyond another offset, with another gain. n is the mean of the
    two foci of a beam aslant; equal nodes are spread over the picture for it.
    """
    if port.index == 1.0:
        return nodes
    if nodes.shape[:2] == (1, 1):
        nodes = np.broadcast_to(nodes, (DOWN, ACROSS, 3))
    rows, columns = nodes.shape[:2]
    slope = np.hypot(*np.moveaxis(_film_places(settings, columns, rows), 2, 0)) / efl
    index = port.stretch(slope)
    focused, gain, offset = np.moveaxis(nodes, 2, 0)
    return np.stack([focused, gain * index, port.window - index * (port.window - offset)], -1)


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
    built, film_xy = bench_of(settings), _film_places(settings, ACROSS, DOWN)
    film = settings.film_pose.points(film_xy.reshape(-1, 2))
    narrow = beams(built.lens, built.film_distance, film)
    whole = beams(built.lens, built.film_distance, film - [0.0, 0.0, built.focusing.shift], whole=True)
    focused = narrow if built.focusing.method == "paraxial" else whole
    directions, starts = (values.reshape(DOWN, ACROSS, 3) for values in (narrow.directions, narrow.starts))
    steps = film_xy[0, 1, 0] - film_xy[0, 0, 0], film_xy[1, 0, 1] - film_xy[0, 0, 1]

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


NEIGHBOURS = (-1, 2, 5)         # stops from the current f-number, drawn faint
SMALLEST = 1e-4                 # µm: least diameter at the focus, below every plot
SLACK = 1e-3                    # of the ends of the plot, which are rounded outwards


@dataclass(frozen=True, eq=False)
class Curves:
    """Diameters (µm) at distances (m) from the film; real is None for a lens model that traces no rays."""

    distances: np.ndarray
    thin: np.ndarray
    thick: np.ndarray | None
    real: np.ndarray | None
    neighbours: tuple[tuple[float, np.ndarray], ...]


def plot_range(got: Readings) -> tuple[float, float, float, float]:
    """Distances (m) and diameters (µm) of the plot of a lens, the same for every stop and focus.

    The diameters get a decade more where a near focus blurs distant objects beyond the plot.
    """
    nearest = (got.nearest_focus or 4.0 * (got.efl or 50.0)) / 1000.0
    widest = got.widest_f_number or min(got.f_number or 2.8, 2.8)
    efl = got.efl or 50.0
    reach = efl * efl / (widest * (got.limit or 0.03)) / 1000.0
    low = _round_down(max(nearest, 0.01))
    high = round_above(min(max(1.1 * reach, 60.0 * low, 20.0), 1000.0), SLACK)
    top = round_above(max(3000.0 * efl * efl / (widest * max(1000.0, 4.0 * efl)), 300.0), SLACK)
    magnification = got.magnification or 0.0
    if 1000.0 * efl * magnification / (got.f_number or widest) > top:
        top *= 10.0
    return low, high, 2.0, top


def curves(settings: Settings, low: float, high: float) -> Curves:
    """The curves of these settings between two distances (m); ValueError or OSError if there are none."""
    return _curves(settings, low, high, file_stamp(settings.lens))


@lru_cache(maxsize=32)
def _curves(settings: Settings, low: float, high: float, lens: Stamp) -> Curves:
    got = readings(settings)
    if got.efl is None or got.f_number is None:
        raise ValueError(got.reason or "A pinhole has no circle of confusion")
    focus = settings.focus_distance
    distances = np.geomspace(low, high, 72) * 1000.0
    if math.isfinite(focus):
        steps = np.geomspace(1e-3, 0.3, 16)
        distances = np.concatenate([distances, [focus], focus * (1.0 - steps), focus * (1.0 + steps)])
        distances = np.unique(distances[(distances >= 1000.0 * low) & (distances <= 1000.0 * high)])
    if not settings.focuses:
        raise ValueError("A pinhole has no focus: hole and diffraction blur all distances nearly equally")
    if not settings.has_lens:
        port = port_of(settings)
        thin = lb.circle_of_confusion(*focused_lens(settings), port.apparent(focus), port.apparent(distances))
        return Curves(distances / 1000.0, _micrometres(thin), None, None, _neighbours(got, thin))
    lens_setup = bench_of(settings)
    offset, metres = lens_setup.principal_offset, distances / 1000.0
    distances = lens_setup.port.apparent(distances)
    from_lens = np.maximum(distances - offset, 1e-3)
    s_f = max(lens_setup.focus_distance, lb.nearest_focus(lens_setup.lens)) - offset
    thin = np.where(distances > offset,
                    lb.circle_of_confusion(got.efl, lens_setup.at_infinity.f_number, s_f, from_lens), np.nan)
    thick = lb.thick_circle_of_confusion(lens_setup.lens, lens_setup.film_distance, distances)
    real = None
    if settings.follows_lens:
        real = _micrometres(lb.real_circle_of_confusion(lens_setup.lens, lens_setup.film_distance, distances)[0])
    return Curves(metres, _micrometres(thin), _micrometres(thick), real, _neighbours(got, thick))


def _micrometres(millimetres: np.ndarray) -> np.ndarray:
    return np.maximum(1000.0 * millimetres, SMALLEST)


def _neighbours(got: Readings, coc: np.ndarray) -> tuple[tuple[float, np.ndarray], ...]:
    """The curve at neighbouring whole stops: a diameter is proportional to 1 / f-number."""
    f_number = got.f_number
    assert f_number is not None
    nearest = min(range(len(WHOLE_STOPS)), key=lambda i: abs(math.log(WHOLE_STOPS[i] / f_number)))
    neighbours = []
    for step in NEIGHBOURS:
        if 0 <= nearest + step < len(WHOLE_STOPS):
            neighbour = WHOLE_STOPS[nearest + step]
            if 0.98 * (got.widest_f_number or 0.0) <= neighbour <= max(32.0, f_number):
                neighbours.append((neighbour, _micrometres(coc * f_number / neighbour)))
    return tuple(neighbours)


def main_curve(shown: Curves) -> np.ndarray:
    """The curve that the rendered picture follows."""
    return shown.real if shown.real is not None else shown.thick if shown.thick is not None else shown.thin


def _round_down(value: float) -> float:
    decade = 10.0 ** math.floor(math.log10(value))
    return max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= value * 1.05)
