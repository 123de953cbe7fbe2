"""Images of point lights, measured independently of `model_choice`.

Through the lens: rays of the scalar reference from the light to a fine grid before the front, on to the film. Through
an ideal model: its closed form, place by place of its pupil. Through a polynomial: Newton's method on the film
point, for a grid of points on the plane of the rear vertex, within the regions that the camera samples. Film points in
the camera frame, mm; the lights lie in the plane of the axis and +x of the film.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.core.imaging.spectrum import WAVELENGTHS
from lensbench.core.kernels.block import U0, U1, WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.optics.glass import D_LINE
from lensbench.core.pupils.radial_sampler import SECTORS, PupilTable
from tests.library import CLASSICS

FIELDS = np.array([0.03, 0.3, 0.55, 0.8, 0.97])     # of half the diagonal, or of its lit part; the first: the axis
COARSE, ZOOMS, FINE = 56, 2, 96                     # a side of the grid before the lens, while it is aimed, and then
REAR, PLACES = 72, 40                               # sides of the grids on the rear plane, and of the ideal pupil
ROUNDS = 12                                         # of Newton's method
STEEPEST = 0.2                                      # cosine: beyond it a depth along the axis is taken for a distance
HUES = tuple(row[4] for row in WAVELENGTHS.values())      # the middle one of each channel
LIT = 0.95                                          # of the radius where the light ends: so far out lights are set
BROAD = 0.1                                         # of half the diagonal: a wider blur is not measured, for of that
GRAIN = 0.002                                       # the grids leave so much as an error
FAINT = 0.1                                         # of the axis: a light that is fainter has no brightness to compare


class Images(NamedTuple):
    """Of lights (n,): middles along +x of the film, twice the deviations along x and y, and the light, summed."""

    middle: np.ndarray
    along: np.ndarray
    across: np.ndarray
    light: np.ndarray


def _sums(x, y, weights) -> np.ndarray:
    """(4, n) sums of w, w x, w x², w y² over the rays (n, m)."""
    return np.stack([(weights * q).sum(1) for q in (np.ones_like(x), x, x * x, y * y)])


def _of_sums(sums) -> Images:
    light, first, along, across = sums
    with np.errstate(invalid="ignore", divide="ignore"):
        middle = first / light
        return Images(middle, 2.0 * np.sqrt(np.maximum(along / light - middle**2, 0.0)), 2.0 * np.sqrt(across / light),
                      light)


def lights(camera, depths) -> np.ndarray:
    """(depths × fields, 3) where the middle rays of film points see the depths (mm from the film)."""
    traced = _as(camera, "trace", 0)
    half = camera.film.diagonal / 2.0
    film = FIELDS * min(half, LIT * traced.pupil.dark_beyond)
    rows = [X, Y, Z, L, M, N]
    zero = 0.0 * film
    out = Program(traced.camera_steps(), np.float64).run({X: film, Y: zero, U0: zero, U1: zero}, rows, len(film))
    front = camera.front
    points = []
    for depth in depths:
        depth = min(max(depth, -1.05 * front), 1e9)
        along = (depth + out[2]) / np.maximum(-out[5], STEEPEST)
        points.append((out[:3] + along * out[3:]).T)
    return np.concatenate(points)


def through_the_lens(camera, points, wavelength=D_LINE) -> np.ndarray:
    """Sums for points (n, 3), by the scalar reference."""
    lens, film_z = camera.lens, camera.lens.length + camera.film_distance
    first = lens.surfaces[0]
    sag = float(first.sag(first.semi_diameter))
    whole, middle = math.hypot(first.semi_diameter, 0.5 * sag) * 1.05, np.array([0.0, 0.0, 0.5 * sag - film_z])
    sums = np.zeros((4, len(points)))
    for i, point in enumerate(points):
        # About the light's middle ray, as far as light comes through
        aim, reach = _aim(camera, point, middle), 3.0 * camera.first_order.entrance_pupil.radius
        while True:
            u, v, _, t = _grid(lens, film_z, point, middle, aim - reach, aim + reach, COARSE, wavelength)
            passed, cell = t.fate == lb.Fate.PASSED, 2.0 * reach / COARSE
            rim = np.maximum(np.abs(u - aim[0]), np.abs(v - aim[1])) > reach - cell
            if passed.any() and not passed[rim].any() or reach > 2.0 * whole:
                break
            reach *= 2.0
        for zoom in range(ZOOMS):
            if passed.any():
                low = np.array([u[passed].min(), v[passed].min()]) - (ZOOMS - zoom) * cell
                high = np.array([u[passed].max(), v[passed].max()]) + (ZOOMS - zoom) * cell
                n = FINE if zoom == ZOOMS - 1 else COARSE
                u, v, solid, t = _grid(lens, film_z, point, middle, low, high, n, wavelength)
                passed, cell = t.fate == lb.Fate.PASSED, (high - low) / n
        if passed.any():
            place, way = t.points[passed], t.directions[passed]
            film = place[:, :2] + ((film_z - place[:, 2]) / way[:, 2])[:, None] * way[:, :2]
            sums[:, i] = _sums(*film.T[:, None], _on_film(camera, film, solid[passed])[None])[:, 0]
    return sums


def _grid(lens, film_z, point, middle, low, high, n, wavelength):
    """Rays from a light through the middles of n × n cells of a rectangle before the lens, and what becomes of them.

    The rectangle lies across the way from the light to `middle`. Returns u, v there, solid angles (times the cosine
    that a light on a wall has), and the trace.
    """
    away = np.linalg.norm(middle - point)
    ahead, right, up = _axes(point, middle)
    cell = (high - low) / n
    u, v = (part.ravel() for part in np.meshgrid(*(low[k] + (np.arange(n) + 0.5) * cell[k] for k in (0, 1))))
    ways = ahead * away + u[:, None] * right + v[:, None] * up
    size = np.linalg.norm(ways, axis=1)
    ways /= size[:, None]
    t = lb.trace(lens, np.tile(point + [0.0, 0.0, film_z], (n * n, 1)), ways, wavelength)
    return u, v, away / size**3 * cell[0] * cell[1] * ways[:, 2], t


def _axes(point, middle):
    """Ahead from the light to the middle; to the right, in the plane of axis and light; and up."""
    ahead = (middle - point) / np.linalg.norm(middle - point)
    return ahead, np.array([ahead[2], 0.0, -ahead[0]]), np.array([0.0, 1.0, 0.0])


def _aim(camera, point, middle) -> np.ndarray:
    """Where the middle ray of the light crosses that plane, to the right and up from the middle."""
    film, _ = camera.film_from_point(point[None], np.zeros((1, 2)))
    if not np.isfinite(film).all():
        return np.zeros(2)
    given = {X: film[:, 0], Y: film[:, 1], U0: np.zeros(1), U1: np.zeros(1)}
    way = -Program(camera.camera_steps(), np.float64).run(given, [L, M, N], 1)[:, 0]
    ahead, right, up = _axes(point, middle)
    crossing = point + way * np.linalg.norm(middle - point) / (way @ ahead) - middle
    return np.array([crossing @ right, crossing @ up])


def through_ideal(camera, points) -> np.ndarray:
    """Sums for points (n, 3), by the closed form of the camera's model."""
    side = (np.arange(PLACES) + 0.5) / PLACES
    uv = np.stack(np.meshgrid(side, side), -1).reshape(-1, 2)
    n, m = len(points), len(uv)
    rows, places = np.repeat(points, m, 0), np.tile(uv, (n, 1))
    film, _ = camera.film_from_point(rows, places)
    step = 1e-4 * np.abs(points[:, 2]).repeat(m)[:, None]
    moved = [camera.film_from_point(rows + step * np.eye(3)[k], places)[0] for k in (0, 1)]
    (a, b), (c, d) = (((each - film) / step).T for each in moved)
    given = {X: film[:, 0], Y: film[:, 1], U0: places[:, 0], U1: places[:, 1]}
    weight = Program(camera.camera_steps(), np.float64).run(given, [WEIGHT], n * m)[0]
    weight = _on_film(camera, film, weight * np.abs(a * d - b * c))
    return _sums(*(part.reshape(n, m) for part in (*film.T, weight)))


def through_polynomial(camera, points, sizes, wavelength=D_LINE) -> np.ndarray:
    """Sums for points (n, 3), whose blurs are about so wide (n,), by the fitted step of the camera."""
    distance, half = camera.film_distance, camera.film.diagonal / 2.0
    table = PupilTable.of(camera.lens, distance, half, wavelength, widened=False)
    program = Program(camera.camera_steps(wavelength)[1:], np.float64)
    # A grid about the region of each light's middle film point, which goes along with it as its film points do
    start = np.tile(FIELDS * min(half, LIT * table.dark_beyond), len(points) // len(FIELDS))
    step, radii = 1e-5 * half, table.radius * np.linspace(0.0, 1.0, 65)
    drift = (_centre(table, start + step) - _centre(table, start - step)) / (2.0 * step)
    off = _centre(table, start) - drift * start
    radii = np.concatenate([np.broadcast_to(radii, (len(start), len(radii))), start[:, None]], 1)
    largest = np.hypot(table.outline[..., 0], table.outline[..., 1]).max(1)
    regions = largest[table.ring(np.minimum(radii, table.radius))[0]]
    regions = regions + np.abs(_centre(table, radii) - drift[:, None] * radii - off[:, None])
    reach = 1.05 * np.max(np.where(np.abs(radii - start[:, None]) <= np.minimum(3.0 * sizes, half)[:, None], regions,
                                   0.0), axis=1)
    side = (np.arange(REAR) + 0.5) / REAR * 2.0 - 1.0
    grid = np.stack(np.meshgrid(side, side), -1).reshape(-1, 2)
    n, m = len(points), len(grid)
    rows, cells = np.repeat(points, m, 0), (2.0 / REAR * reach).repeat(m)
    fixed = (grid * reach[:, None, None] + np.stack([off, 0.0 * off], 1)[:, None]).reshape(-1, 2)

    def aimed(film):
        return fixed + drift.repeat(m)[:, None] * film

    def seen(film):
        """By how much rays miss their light in its plane."""
        way = aimed(film) - film
        size = 1.0 / np.sqrt((way**2).sum(1) + distance**2)
        given = {X: film[:, 0], Y: film[:, 1], L: way[:, 0] * size, M: way[:, 1] * size, N: -distance * size}
        with np.errstate(all="ignore"):
            x, y, z, l, m_, n_ = program.run(given, [X, Y, Z, L, M, N], len(film))
            along = (rows[:, 2] - z) / n_
            return np.stack([x + along * l, y + along * m_], 1) - rows[:, :2]

    film = np.stack([start, np.zeros(n)], 1).repeat(m, 0)
    with np.errstate(all="ignore"):
        for _ in range(ROUNDS):
            off = seen(film)
            (a, b), (c, d) = (((seen(film + shift) - off) / step).T for shift in ((step, 0.0), (0.0, step)))
            size = a * d - b * c
            change = np.stack([(c * off[:, 1] - d * off[:, 0]) / size, (b * off[:, 0] - a * off[:, 1]) / size], 1)
            film = film + np.clip(change, -0.2 * half, 0.2 * half)
        found = np.abs(change).max(1) < 1e-7 * half
        aims = aimed(film)
        way = aims - film
        cos2 = distance**2 / ((way**2).sum(1) + distance**2)
        weight = np.where(found, cos2**2 / np.abs(size) * _inside(table, film, aims, cells) * cells**2, 0.0)
    # Where the map from film to scene folds, Newton's method finds one film point of several
    turned = np.where(weight > 0.0, np.sign(size), 0.0).reshape(n, m)
    folded = np.minimum((turned > 0.0).sum(1), (turned < 0.0).sum(1)) > 1e-3 * (turned != 0.0).sum(1)
    sums = _sums(*(np.where(found, part, 0.0).reshape(n, m) for part in (*film.T, _on_film(camera, film, weight))))
    return np.where(folded, math.nan, sums)


def _centre(table, radii):
    """Of the regions of film points (r, 0), r of either sign."""
    return np.sign(radii) * table.centre(np.minimum(np.abs(radii), table.radius))


def _on_film(camera, film, weights):
    """The weights of rays that end within the circle about the film."""
    return np.where(np.hypot(*film.T) <= camera.film.diagonal / 2.0, weights, 0.0)


def _inside(table, film, rear, cell) -> np.ndarray:
    """How much of a cell about a rear point lies in the region that the film point samples: 0 … 1."""
    r = np.hypot(*film.T)
    within = np.minimum(np.nan_to_num(r), table.radius)
    (inner, f), centre = table.ring(within), table.centre(within)
    cosine, sine = film.T / np.maximum(r, 1e-12)
    x = rear[:, 0] * cosine + rear[:, 1] * sine - centre
    y = np.abs(rear[:, 1] * cosine - rear[:, 0] * sine)
    beyond = np.zeros(len(r), int)
    corner = [table.outline[inner, k] * (1.0 - f)[:, None] + table.outline[inner + 1, k] * f[:, None]
              for k in range(SECTORS + 1)]
    for k in range(1, SECTORS):
        beyond += corner[k][:, 0] * y - corner[k][:, 1] * x >= 0.0
    (ax, ay), (bx, by) = (np.take_along_axis(np.stack(corner), (beyond + k)[None, :, None], 0)[0].T for k in (0, 1))
    chord = np.hypot(bx - ax, by - ay)
    with np.errstate(invalid="ignore", divide="ignore"):
        depth = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / chord
    return np.where((chord > 0.0) & (r <= table.dark_beyond), np.clip(0.5 + depth / cell, 0.0, 1.0), 0.0)


def setting(seed):
    """A camera and the depths of a scene at random: a lens of the library, zoom, stop, focus, film, pixels."""
    random = np.random.default_rng(seed)
    names = [name for name in CLASSICS if "anamorphic" not in name]
    name = names[random.integers(len(names))]
    lens = lenses.load(name)
    lens = lens.at(zoom=random.random()) if lens.zooms else lens
    fo = lb.first_order(lens)
    half = fo.efl * math.tan(math.radians(random.uniform(4.0, 38.0)))
    pixels = 10.0 ** random.uniform(2.1, 3.3)
    film = lb.Film(half * 1.2 * 4.0 / 3.0, half * 1.2, max(round(pixels), 4), max(round(pixels * 0.75), 3))
    nearest = lb.nearest_focus(lens)
    focus = math.inf if random.random() < 0.1 else max(nearest, 4.0 * fo.efl) * 10.0 ** random.uniform(0.02, 2.0)
    f_number = fo.f_number * 2.0 ** random.uniform(0.0, 4.0)
    near = min(focus, 100.0 * fo.efl) * 10.0 ** random.uniform(-0.6, 0.2)
    far = 1e7 if random.random() < 0.2 else near * 10.0 ** random.uniform(0.05, 1.5)
    camera = lb.LensCamera(lens, film, focus, f_number, model="auto")
    # No wider blurs than can be measured
    fo, offset = camera.first_order, camera.lens.length + camera.film_distance - camera.first_order.front_principal
    sharp = lb.depth_of_field(fo.efl, fo.f_number, min(focus, 1e7) - offset, 0.8 * BROAD * film.diagonal / 2.0)
    near, far = (min(max(depth, sharp[0] + offset, -1.2 * camera.front), sharp[1] + offset) for depth in (near, far))
    return name, camera, (near, max(far, 1.01 * near))


class Verdict(NamedTuple):
    """What the images of lights say of models: pixels and stops by which each is off; inf: it cannot be had."""

    off: dict[tuple[str, int], tuple[float, float]]

    def passes(self, rung) -> bool:
        """Whether a model that was looked at is within half a pixel and 0.05 stops, as the trace is."""
        pixels, stops = self.off.get(rung, (0.0, 0.0) if rung == ("trace", 0) else (math.inf, math.inf))
        return pixels <= 0.5 and stops <= 0.05


def verdict(camera, depths, ladder, chosen) -> Verdict:
    """Of the models of the ladder up to the first that passes, and of the one that was chosen.

    Of each channel, where the camera disperses.
    """
    near, far = depths
    focus = camera.focus_distance
    points = lights(camera, (near, focus, far) if near < focus < far else depths)
    traced = _as(camera, "trace", 0)
    hues = HUES if traced.disperses else (D_LINE,)
    true = [moments(through_the_lens(traced, points, hue)) for hue in hues]
    found = Verdict({})
    for rung in ladder:
        if rung != ("trace", 0):
            found.off[rung] = _off(camera, points, hues, true, *rung)
        if found.passes(rung):
            break
    if chosen not in found.off and chosen != ("trace", 0):
        found.off[chosen] = _off(camera, points, hues, true, *chosen)
    return found


def _off(camera, points, hues, true, model, degree) -> tuple[float, float]:
    try:
        view = _as(camera, model, degree)
        if degree:
            seen = [moments(through_polynomial(view, points, np.nan_to_num(each.along + each.across), hue))
                    for each, hue in zip(true, hues, strict=True)]
        else:
            seen = [moments(through_ideal(view, points))] * len(hues)
    except (lb.CameraError, lb.LensError):
        return math.inf, math.inf
    apart = [_apart(camera, a, b) for a, b in zip(true, seen, strict=True)]
    return max(px for px, _ in apart), max(stops for _, stops in apart)


def _as(camera, model, degree):
    return replace(camera, model=model, degree=degree or 9)


def moments(sums) -> Images:
    """Of sums, the light relative to that on the axis, depth by depth."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return _of_sums(sums / np.repeat(sums[0, ::len(FIELDS)], len(FIELDS)))


def _apart(camera, true: Images, seen: Images) -> tuple[float, float]:
    """At worst, pixels and stops between images of lights, of those that can be measured."""
    size = np.hypot(true.along, true.across)
    lit = (true.light > 1e-6) & (size < BROAD * camera.film.diagonal / 2.0) & ~np.isnan(seen.light)
    shift, spread = np.abs(seen.middle - true.middle), np.hypot(seen.along - true.along, seen.across - true.across)
    pixels = ((np.maximum(shift, spread) - GRAIN * size) / camera.film.pitch)[lit]
    bright = lit & (true.light > FAINT)
    with np.errstate(divide="ignore"):
        stops = np.abs(np.log2(seen.light[bright] / true.light[bright]))
    return float(np.max(pixels, initial=0.0)), float(np.max(stops, initial=0.0))
