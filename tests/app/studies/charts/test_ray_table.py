"""The ray table: equal to the reference at its nodes, near it between them, the same at every azimuth."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.charts.ladder import ACROSS, ALONG, RADII, _box, ray_table_step
from lensbench.core.kernels.block import L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.pupils.radial_sampler import PupilTable

LINE = [X, Y, Z, L, M, N]
FILM = lb.Film(36.0, 24.0, 600, 400)


def bench_of(name="pbrt-dgauss-50mm", distance=1200.0):
    lens = lenses.load(name)
    away = lb.film_distance(lens, distance)
    table = PupilTable.of(lens, away, FILM.diagonal / 2.0, widened=False)
    return lens, away, table, Program([ray_table_step(lens, away, table, distance=distance)], np.float64)


class TableCamera(lb.LensCamera):
    """A lens camera with the ray table instead of the surfaces."""

    is_traced = False

    def _new_steps(self, wavelength):
        table, normaliser = self._sampled(wavelength)
        return [table.step(normaliser),
                ray_table_step(self.lens, self.film_distance, table, wavelength, self.focus_distance)]


def aimed(film, rear, away):
    """Lane rows of rays from film points to points on the plane of the last vertex, (n, 2) each."""
    way = np.column_stack([rear - film, np.full(len(film), -away)])
    way /= np.linalg.norm(way, axis=1)[:, None]
    return {X: film[:, 0], Y: film[:, 1], L: way[:, 0], M: way[:, 1], N: way[:, 2]}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm"])
def test_the_table_has_the_reference_rays_at_its_nodes(name):
    lens, away, table, program = bench_of(name)
    reach, drift = _box(table)
    k, u, v = (axis.ravel() for axis in np.meshgrid(np.arange(0, RADII - 1, 7), np.arange(1, ALONG - 1, 3),
                                                    np.arange(0, ACROSS - 1, 2)))
    film = np.column_stack([k * table.radius / (RADII - 1), np.zeros(k.size)])
    rear = np.column_stack([drift * film[:, 0] + reach * (2.0 * u / (ALONG - 1) - 1.0), reach * v / (ACROSS - 1)])
    rays = aimed(film, rear, away)
    out = program.run(rays, LINE, k.size).T
    shift = np.array([0.0, 0.0, lens.length + away])
    true = lb.trace(lens, np.column_stack([film, np.zeros(k.size)]) + shift,
                    np.column_stack([rays[L], rays[M], rays[N]]))
    passed = true.fate == lb.Fate.PASSED
    assert passed.sum() > 100
    # The same lines: directions, and points that lie on them
    np.testing.assert_allclose(out[passed, 3:], true.directions[passed], atol=1e-11)
    apart = np.cross(out[passed, :3] + shift - true.points[passed], true.directions[passed])
    assert np.abs(apart).max() < 1e-8


@pytest.mark.slow
def test_between_its_nodes_the_table_is_within_half_a_pixel_of_the_trace():
    """Of 24 megapixels; a linear table of 64 × 24 × 12 rays cannot follow the curvature within a cell: 0.2 px rms."""
    raster, uv = np.random.default_rng(3).random((2, 4000, 2))
    rays = []
    for kind in (lb.LensCamera, TableCamera):
        camera = kind(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 2.8)
        middle = np.full((len(uv), 2), 0.5)               # of the regions: theirs differ by a hair in size
        rays.append(camera.generate_rays(raster * [600.0, 400.0], middle))
    off = np.linalg.norm(rays[0].directions - rays[1].directions, axis=1) * 50.0 / 0.006
    assert math.sqrt((off**2).mean()) < 0.5
    assert off.max() > 0.01                             # and no trace in disguise


@pytest.mark.slow
def test_a_table_turns_with_the_film_and_is_mirrored():
    program = bench_of()[3]
    way = np.array([-0.1, 0.05, -1.0]) / np.linalg.norm([-0.1, 0.05, -1.0])
    turns = np.linspace(0.0, 2.0 * math.pi, 9)
    cosine, sine = np.cos(turns), np.sin(turns)

    def through(sign):
        x, l, m = 9.0, way[0], sign * way[1]
        sample = {X: x * cosine, Y: x * sine, L: l * cosine - m * sine, M: l * sine + m * cosine, N: np.full(9, way[2])}
        out = program.run(sample, LINE, 9)
        back = np.array([[cosine, sine], [-sine, cosine]])
        return [*np.einsum("ijn,jn->in", back, out[:2]), out[2], *np.einsum("ijn,jn->in", back, out[3:5]), out[5]]

    up, down = np.array(through(1.0)), np.array(through(-1.0))
    assert up == pytest.approx(np.repeat(up[:, :1], 9, 1), abs=1e-9)
    assert down * np.array([1, -1, 1, 1, -1, 1])[:, None] == pytest.approx(up, abs=1e-9)


@pytest.mark.slow
def test_a_picture_by_the_table_is_the_traced_one():
    scene = lb.builtin_scene("still-life")
    film = lb.Film(36.0, 24.0, 48, 32)
    traced, tabled = (lb.render(kind(lenses.load("pbrt-dgauss-50mm"), film, 1200.0), scene, 64)
                      for kind in (lb.LensCamera, TableCamera))
    # The same samples by rays that are a hundredth of such a pixel apart; the trace loses 0.6 % of them at random
    assert tabled.mean() == pytest.approx(traced.mean(), rel=5e-3)
    assert np.sqrt(((np.minimum(tabled, 1.0) - np.minimum(traced, 1.0)) ** 2).mean()) < 0.02


def test_a_lens_without_rotational_symmetry_has_no_table():
    rod = lb.Lens((lb.Surface(4.0, 5.0, lb.Glass(1.5), curvature=0.02, curvature_x=0.0),
                   lb.Surface(0.0, 5.0, curvature=0.0)), 0)
    with pytest.raises(lb.LensError, match="cylinder or toroid"):
        ray_table_step(rod, 30.0, bench_of()[2])


def test_no_camera_offers_the_table_as_its_model():
    with pytest.raises(lb.CameraError, match="camera model 'table': choose one of auto, trace"):
        lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, model="table")
