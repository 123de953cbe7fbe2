"""Rays of a pixel through the lens: they come back to its film point, and lost ones name the surface that ends them."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.plots.exit_pupil import box_samples, region
from lensbench.app.plots.pixel_rays import Pointed, film_place, in_section, pixel_fan, ray_through
from lensbench.app.settings.settings import Settings

START = replace(Settings(), f_number=None)
ANAMORPHIC = "lentil-schneider-anamorphic-31-2001"
some_lenses = pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm"])


@some_lenses
@pytest.mark.parametrize("raster", [(480.5, 320.5), (300.5, 200.5), (700.5, 500.5)])
def test_rays_of_a_pixel_traced_from_the_scene_arrive_at_its_film_point(name, raster):
    settings = replace(START, lens=name)
    built, fan = bench_of(settings), pixel_fan(settings, raster)
    live = [ray for ray in fan.rays if ray.kind != "dead"]
    assert len(live) == 9 and sum(ray.kind == "chief" for ray in live) == 1
    assert fan.height == pytest.approx(math.hypot(*film_place(settings, raster)))
    for ray in live:
        start, way = ray.path[0], ray.path[1] - ray.path[0]
        again = lb.trace(built.lens, [0.0, start[1], start[0]], [0.0, way[1], way[0]], clip=False, forward=True)
        run = (built.film_z - again.points[0][2]) / again.directions[0][2]
        assert again.points[0][1] + run * again.directions[0][1] == pytest.approx(fan.height, abs=1e-5)


def test_the_marginal_rays_touch_a_rim_and_the_dead_ones_beyond_name_it():
    built = bench_of(START)
    fan = pixel_fan(START, (300.5, 200.5))
    for ray in fan.rays:
        if ray.kind == "marginal":          # some rim is met within a hundred-thousandth of the beam
            heights = np.abs(ray.path[1:-1, 1])
            assert min(abs(h - s.semi_diameter) for h, s in zip(heights, built.lens.surfaces, strict=True)) < 1e-3
        if ray.kind == "dead":
            rim = built.lens.surfaces[ray.surface].semi_diameter
            assert abs(ray.path[-1][1]) > rim
            assert f"surface {ray.surface} " in ray.end or ray.surface == built.lens.stop_index
    assert {ray.surface for ray in fan.rays if ray.kind == "dead"}


def test_blades_turn_with_the_film_point_and_cylinders_do_not():
    """Light passes inside the region of the true film point, turned upright, and not outside."""
    for settings, raster in ((replace(START, blades=5, f_number=5.6), (300.5, 200.5)),
                             (replace(START, lens=ANAMORPHIC), (600.5, 400.5))):
        built, (x, y) = bench_of(settings), film_place(settings, raster)
        seen = region(built.lens, built.film_distance, math.hypot(x, y), math.atan2(y, x))
        turned = 0.0 if settings.lens == ANAMORPHIC else 0.5 * math.pi - math.atan2(y, x)
        back = np.array([[math.cos(turned), math.sin(turned)], [-math.sin(turned), math.cos(turned)]])
        film = np.array([x, y, built.film_z])
        for factor, passes in ((0.99, True), (1.01, False)):
            middle = seen.outline.mean(0)
            points = (middle + factor * (seen.outline[::16] - middle)) @ back.T
            ways = np.column_stack([points, np.full(len(points), built.lens.length)]) - film
            assert ((lb.trace(built.lens, film, ways).fate == lb.Fate.PASSED) == passes).all()


def test_samples_of_a_box_are_blocked_by_the_surface_at_which_the_tracer_ends_them():
    built = bench_of(START)
    samples = box_samples(built.lens, built.film_distance, 15.1)
    film = np.array([0.0, 15.1, built.film_z])
    ways = np.column_stack([samples.points, np.full(len(samples.points), built.lens.length)]) - film
    found = lb.trace(built.lens, film, ways)
    clipped = found.fate == lb.Fate.CLIPPED
    assert clipped.any() and (samples.blocked_by[clipped] == found.surface[clipped]).all()
    assert ((samples.blocked_by < 0) == samples.passes).all()


def test_a_ray_of_the_pupil_says_what_it_comes_from_and_lies_in_the_section():
    raster = (480.5, 380.5)                                 # below the middle: the red sphere in focus
    at = film_place(START, raster)
    ray = ray_through(START, at, (0.0, 0.0))
    assert ray.surface == -1 and ray.end.startswith("from the sphere") and ray.target is not None
    assert ray.raster == pytest.approx(raster, abs=8.0)     # in focus, as nearly as that sphere is
    path = in_section(START, raster, ray)
    assert path[-1] == pytest.approx([bench_of(START).film_z, math.hypot(*at)])
    blocked = ray_through(START, at, (0.0, 9.9))
    assert blocked.surface >= 0 and blocked.target is None and "surface" in blocked.end


def test_a_pinned_pixel_survives_another_size_and_precedes_the_mouse():
    links = Pointed(hover=(10.2, 20.7))
    assert links.pixel(960, 640) == (10.5, 20.5)
    links.toggle_pin((0.5, 0.25))
    assert links.pixel(960, 640) == (480.5, 160.5) and links.pixel(96, 64) == (48.5, 16.5)
    links.toggle_pin((0.1, 0.1))
    assert links.pinned is None and links.pixel(960, 640) == (10.5, 20.5)
    assert Pointed().pixel(960, 640) is None


@pytest.mark.parametrize("camera", ["orthographic", "fisheye", "environment", "finite-pinhole", "bare-sensor"])
def test_a_camera_without_a_lens_says_that_there_is_none(camera):
    with pytest.raises(ValueError, match="no lens"):
        pixel_fan(replace(START, camera=camera), (480.5, 320.5))
