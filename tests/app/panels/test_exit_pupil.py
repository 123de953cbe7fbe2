"""The exit pupil: regions and samples against the tracer, and the panel under a real mouse."""

import math
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import ImVec2

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.panels import exit_pupil
from lensbench.app.plots.exit_pupil import box_samples, region
from lensbench.app.plots.pixel_rays import Pointed
from lensbench.app.settings.settings import Settings
from tests.app.stand import drive

START = Settings(lens="pbrt-dgauss-50mm")
radii = pytest.mark.parametrize("film_radius", [0.0, 9.0, 15.1, 21.6])


def passes(lens: lb.Lens, film_distance: float, film_radius: float, points: np.ndarray) -> np.ndarray:
    film = np.array([0.0, film_radius, lens.length + film_distance])
    ways = np.column_stack([points, np.full(len(points), lens.length)]) - film
    return lb.trace(lens, film[None, :], ways).fate == lb.Fate.PASSED


@radii
def test_light_passes_inside_the_outline_and_not_outside(film_radius):
    stand = bench_of(START)
    pupil = region(stand.lens, stand.film_distance, film_radius)
    middle = pupil.outline.mean(axis=0)
    assert passes(stand.lens, stand.film_distance, film_radius, middle + 0.995 * (pupil.outline - middle)).all()
    assert not passes(stand.lens, stand.film_distance, film_radius, middle + 1.005 * (pupil.outline - middle)).any()


@radii
def test_the_region_stands_upright_in_its_box_and_its_area_is_that_of_its_outline(film_radius):
    stand = bench_of(START)
    pupil = region(stand.lens, stand.film_distance, film_radius)
    x, y = pupil.outline.T
    assert pupil.box == pytest.approx((x.min(), y.min(), x.max(), y.max()), abs=1e-3)
    assert x.max() == pytest.approx(-x.min(), abs=1e-3)
    shoelace = 0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    assert pupil.area == pytest.approx(shoelace, rel=1e-3)            # a polygon of 512 sides


@radii
def test_the_pass_rate_of_the_box_is_the_region_over_the_box(film_radius):
    stand = bench_of(START)
    pupil = region(stand.lens, stand.film_distance, film_radius)
    samples = box_samples(stand.lens, stand.film_distance, film_radius)
    x0, y0, x1, y1 = pupil.box
    # 1,024 points of an even sequence: within a percent of the area's part
    assert samples.rate == pytest.approx(pupil.area / ((x1 - x0) * (y1 - y0)), abs=0.012)
    assert (samples.points >= [x0, y0]).all() and (samples.points <= [x1, y1]).all()


def test_the_axis_sees_a_disk_that_becomes_the_paraxial_exit_pupil_as_the_stop_closes():
    errors = []
    for f_number in (8.0, 16.0, 32.0):
        stand = bench_of(replace(START, f_number=f_number))
        distances = np.hypot(*region(stand.lens, stand.film_distance, 0.0).outline.T)
        assert distances == pytest.approx(np.full(len(distances), distances.mean()), rel=1e-6)
        # The exit pupil's radius, carried along straight lines to the film as far as the last vertex
        pupil = stand.first_order.exit_pupil
        errors.append(distances.mean() / (pupil.radius * stand.film_distance / (stand.film_z - pupil.z)) - 1.0)
    # Aberrations of the pupil go as the square of its radius
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


def test_a_film_point_without_light_has_no_region_and_no_samples():
    stand = bench_of(replace(START, lens="pbrt-fisheye-10mm"))
    pupil = region(stand.lens, stand.film_distance, 60.0)
    assert pupil.area == 0.0 and len(pupil.outline) == 0
    assert box_samples(stand.lens, stand.film_distance, 60.0).rate == 0.0


def test_the_plot_holds_the_region_of_a_beside_a_small_one():
    """It held that of the present settings alone, inside which no line of a wider A passes."""
    small, wide = (bench_of(replace(START, f_number=f_number)) for f_number in (11.0, 2.8))
    rear = small.lens.surfaces[-1].semi_diameter
    pupil = region(small.lens, small.film_distance, 15.1)
    ghost = region(wide.lens, wide.film_distance, 15.1).outline
    x0, y0, x1, y1 = exit_pupil.shown_box(rear, [pupil], pupil, ghost)
    assert (ghost >= (x0, y0)).all() and (ghost <= (x1, y1)).all()
    alone = exit_pupil.shown_box(rear, [pupil], pupil)
    assert alone[2] - alone[0] < 0.5 * (x1 - x0)


# The panel


class Panel:
    def __init__(self, settings: Settings = START, film_radius: float = 15.1, hover: tuple[float, float] | None = None):
        self.settings, self.film_radius, self.links = settings, film_radius, Pointed(hover)
        self.state = exit_pupil.PupilState()

    def show(self) -> None:
        self.film_radius = exit_pupil.exit_pupil_panel(self.settings, self.film_radius, self.state, self.links)


def test_the_film_radius_is_turned_and_the_mouse_in_the_picture_does_not_change_it():
    panel = Panel()
    radii = {}

    def test(ctx):
        ctx.yield_(3)
        box = ctx.item_info("**/Film radius").rect_full
        y = 0.5 * (box.min.y + box.max.y)
        ctx.mouse_move_to_pos(ImVec2(0.5 * (box.min.x + box.max.x), y))
        ctx.mouse_click(0)
        ctx.yield_(2)
        radii["half"] = panel.film_radius
        panel.links.hover = (400.0, 320.0)
        ctx.yield_(3)
        radii["hovering"] = panel.film_radius
        for y in range(110, 330, 25):                   # what passes under the cursor
            ctx.mouse_move_to_pos(ImVec2(150.0, float(y)))
            ctx.yield_()

    drive(panel.show, test, (300, 350))
    # A click lies on a whole pixel of 260
    assert radii["half"] == pytest.approx(0.25 * math.hypot(36.0, 24.0), abs=0.15)
    assert radii["hovering"] == radii["half"]


STATES = [START, replace(START, lens="no-such-lens"), replace(START, focus_distance=3.0), replace(START, f_number=0.3),
          replace(START, camera="perspective"), replace(START, lens_model="thin"), replace(START, film_width=0.0),
          replace(START, lens="pbrt-fisheye-10mm", focus_distance=math.inf), replace(START, f_number=900.0)]


@pytest.mark.parametrize("size", [(20, 20), (80, 75), (90, 800), (1500, 240)])
def test_the_panel_lives_in_any_window_and_any_state(size):
    panel = Panel()

    def test(ctx):
        for state in STATES:
            for panel.links.hover in (None, (3.0, 5.0)):
                panel.settings = state
                ctx.yield_(2)

    drive(panel.show, test, size)
    assert panel.film_radius == 15.1
