"""A tilted or shifted film in the settings: camera, focus at a click, blur of a pixel, section, and options."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.constraints import constrained, with_equivalent_film
from lensbench.app.bench.focus_plane import focused_at, in_section, leans, seen_from, sentence, sharp_focus
from lensbench.app.command.options import remarks
from lensbench.app.panels.controls.controls import Chooser, controls_panel
from lensbench.app.plots.blur import Blur
from lensbench.app.plots.pixel_spot import spot_of
from lensbench.app.plots.plan import plan
from lensbench.app.plots.query import query
from lensbench.app.session.states import load_settings, save_settings
from lensbench.app.settings.dial_scales import curvature_scale
from lensbench.app.settings.setting import SettingsError, spec
from lensbench.app.settings.settings import Settings
from lensbench.core.imaging.film import FilmPose
from lensbench.core.optics.system import SystemData, Wavelength
from tests.app.stand import drive
from tests.core.optics.test_surface_pose import posed

POSED = replace(Settings(), tilt=math.radians(6.0), swing=math.radians(4.0), rise=3.0, f_number=8.0,
                focus_distance=1500.0)


def test_settings_pose_the_film_and_are_kept(tmp_path):
    assert camera(POSED).film_pose == FilmPose(math.radians(6.0), math.radians(4.0), 3.0, 0.0)
    assert POSED.optics != Settings().optics and POSED.picture != Settings().picture
    save_settings(tmp_path / "posed.toml", POSED)
    assert load_settings(tmp_path / "posed.toml") == POSED == Settings.from_dict(POSED.to_dict())
    with pytest.raises(SettingsError, match="tilt of the film 61°"):
        replace(POSED, tilt=math.radians(61.0)).checked()
    assert replace(POSED, camera="fisheye").film_pose.is_upright
    said = remarks(replace(POSED, camera="fisheye"), {"tilt"}, {"tilt": "tilt"}, None, False)
    assert "--tilt has no effect on the camera fisheye" in " ".join(said)


@pytest.mark.parametrize("film", lb.FORMATS.values())
def test_the_dial_of_curvature_ends_before_the_film_cannot_be_curved(film):
    scale = curvature_scale(0.5 * math.hypot(*film) / 0.9)
    for end in (scale.low, scale.high):
        FilmPose(radius=1.0 / end).extent(*film)                # raises where it cannot be


def test_settings_curve_the_film_and_the_section_shows_it(tmp_path):
    curved = replace(Settings(), film_radius=-90.0, f_number=8.0)
    assert camera(curved).film_pose == FilmPose(radius=-90.0) and "towards the lens" in sentence(curved)
    save_settings(tmp_path / "curved.toml", curved)
    assert load_settings(tmp_path / "curved.toml") == curved == Settings.from_dict(curved.to_dict())
    z, y = in_section(curved).film.T
    assert np.ptp(z) == pytest.approx(90.0 - math.sqrt(90.0**2 - 12.0**2)) and z[0] == z[-1] == z.min()
    assert np.hypot(z - (z.max() - 90.0), y) == pytest.approx(np.full(len(z), 90.0))
    with pytest.raises(ValueError, match="radius 0 mm"):
        replace(curved, film_radius=0.0).checked()
    scale = curvature_scale(24.5)
    assert scale.read(scale.format(-1.0 / 90.0)) == -1.0 / 90.0 and scale.read("flat") == 0.0 == scale.reset


def test_flat_is_a_radius_of_the_film():
    radius = next(field for field in fields(Settings) if field.name == "film_radius")
    assert spec(radius).read("flat") == spec(radius).read("inf") == math.inf and spec(radius).read("-90 mm") == -90.0
    flat = replace(Settings(), film_radius=math.inf)
    assert flat == Settings() and flat.checked().film_pose.is_upright
    assert Settings.from_dict({"version": 1, "film_radius": "inf"}).film_radius is None


def test_figures_of_a_film_in_line_say_so():
    for settings, said in ((POSED, 1), (replace(Settings(), f_number=8.0, focus_distance=1500.0), 0)):
        asked = query(settings)
        assert sum("a flat, centred film" in each for each in asked.remarks(asked.grid(8))) == said


def test_a_lens_with_cylinders_has_a_tilted_film_too():
    anamorphic = constrained(replace(POSED, lens="lentil-schneider-anamorphic-31-2001", f_number=None))
    assert camera(anamorphic).film_pose == POSED.film_pose and constrained(POSED) == POSED


def test_a_tilted_lens_tilts_the_plane_of_sharp_focus_of_a_centred_film(tmp_path):
    lens = lenses.load("lenshh-cooke-triplet-50")
    lenses.save(posed(lens, 0, len(lens.surfaces) - 1, tilt_x=math.radians(5.0)), tmp_path / "bent.toml")
    settings = Settings(lens=str(tmp_path / "bent.toml"), focus_distance=1500.0, f_number=8.0, lens_model="trace")
    found = in_section(settings)
    assert leans(settings) and set(found.planes) == {"sharp", "near", "far"} and set(found.points) == {"Hinge line"}
    assert np.ptp(found.film[:, 0]) == 0.0 and "is tilted by" in sentence(settings)
    straight = replace(settings, lens="lenshh-cooke-triplet-50")
    assert not leans(straight) and in_section(straight) is None


@pytest.mark.parametrize("part", [(0.5, 0.5), (0.1, 0.2), (0.8, 0.9)])
def test_a_click_brings_what_it_shows_into_focus_and_its_blur_is_that_of_the_rays(part):
    thick, raster = camera(replace(POSED, lens_model="thick")), [[part[0] * 960.0, part[1] * 640.0]]
    plane = sharp_focus(POSED).plane
    chief = thick.generate_rays(raster, [[0.5, 0.5]])
    along = -plane.distance(chief.origins) / (chief.directions @ plane.normal)
    depth = -float((chief.origins + along[:, None] * chief.directions)[0, 2])
    found = focused_at(replace(POSED, lens_model="thick"), part, depth)
    assert found.distance == pytest.approx(1500.0, rel=1e-3) and not found.remark   # depths from the film's middle
    ideal = Blur.of(replace(POSED, lens_model="thick"))
    assert ideal.pixels(depth, part) < 1e-9
    # 0.4 m behind the plane in focus, from one end of the pupil to the other, in pixels
    ends = thick.generate_rays(raster * 2, [[0.0, 0.5], [1.0, 0.5]])
    met = ends.origins + ((-depth - 400.0 - ends.origins[:, 2]) / ends.directions[:, 2])[:, None] * ends.directions
    apart = np.linalg.norm(np.diff(thick.raster_from_point(met)[0], axis=0))
    assert ideal.pixels(depth + 400.0, part) == pytest.approx(apart, rel=0.03)              # a slanted cone's ellipse


def widths(cam, part, depth):
    """Pixels between where two ends of the pupil of a film point see a plane across the axis, at a depth."""
    raster = [[part[0] * 960.0, part[1] * 640.0]]
    ends = cam.generate_rays(raster * 2, [[0.02, 0.5], [0.98, 0.5]])
    met = ends.origins + ((-depth - ends.origins[:, 2]) / ends.directions[:, 2])[:, None] * ends.directions
    return np.linalg.norm(np.diff(cam.raster_from_point(met)[0], axis=0)) / 0.96


@pytest.mark.parametrize("part", [(0.5, 0.5), (0.15, 0.2), (0.8, 0.9)])
def test_overlays_and_a_click_know_a_curved_film(part):
    curved = replace(Settings(), film_radius=-60.0, f_number=8.0, focus_distance=1500.0, tilt=0.03, lens_model="thick")
    thick = camera(curved)
    for depth in (1000.0, 2500.0):
        assert Blur.of(curved).pixels(depth, part) == pytest.approx(widths(thick, part, depth), rel=0.035)
    focused = replace(curved, focus_distance=focused_at(curved, part, 2500.0).distance)
    assert Blur.of(focused).pixels(2500.0, part) < 0.01


def spot_pixels(settings, part, depth):
    """The diameter of the spot of what a part of the picture sees at a depth, traced to the film, in pixels."""
    raster = part[0] * 960.0, part[1] * 640.0
    made = camera(settings)
    ray = made.generate_rays([raster], [made.pupil_centre])
    point = (ray.origins - (depth + ray.origins[:, 2:]) / ray.directions[:, 2:] * ray.directions)[0]
    here, at = seen_from(settings, raster)
    target = tuple((point + [0.0, 0.0, bench_of(settings).film_z]).tolist())
    return spot_of(here.lens, here.film_distance, at, target).diameter / settings.film.pitch


@pytest.mark.slow
@pytest.mark.parametrize(("pose", "change"), [
    ({"tilt_x": 0.05}, {}), ({"tilt_x": -0.07, "tilt_y": 0.03, "decentre_y": 0.4}, {"focus_position": "real"}),
    ({}, {"tilt": 0.08, "swing": -0.05}), ({}, {"film_radius": -90.0})])
def test_overlays_know_what_leans_from_traced_beams(pose, change, tmp_path):
    """Against spots, far from the focus, where the aberrations do not count; the centred lens is off by far more."""
    lens = lenses.load("lenshh-cooke-triplet-50")
    lenses.save(posed(lens, 0, len(lens.surfaces) - 1, **pose) if pose else lens, tmp_path / "bent.toml")
    bent = Settings(lens=str(tmp_path / "bent.toml"), focus_distance=1500.0, f_number=8.0, lens_model="trace",
                    **{"focus_position": "paraxial", **change})
    line = replace(bent, lens="lenshh-cooke-triplet-50", tilt=0.0, swing=0.0, film_radius=None)
    worst, of_line = 0.0, 0.0
    for part in ((0.5, 0.2), (0.5, 0.8), (0.15, 0.3), (0.8, 0.7)):
        for depth in (400.0, 700.0, 8000.0):
            wanted = spot_pixels(bent, part, depth)
            off, plain = (abs(Blur.of(each).pixels(depth, part) - wanted) for each in (bent, line))
            worst, of_line = max(worst, off - 0.03 * wanted), max(of_line, plain - 0.03 * wanted)
    assert worst < 0.25 and of_line > 5.0 * worst and of_line > 1.0         # pixels
    # What a click brings into focus is sharp in the overlays, whatever the aberrations leave of it
    for part in ((0.4, 0.3), (0.7, 0.8)):
        clicked = replace(bent, focus_distance=focused_at(bent, part, 1200.0).distance)
        assert Blur.of(clicked).pixels(1200.0, part) < 0.3


def test_overlays_of_a_film_without_light_blur_nothing(tmp_path):
    lens = lenses.load("lenshh-cooke-triplet-50")
    lenses.save(posed(lens, 0, 1, decentre_y=60.0), tmp_path / "dark.toml")
    assert not Blur.of(Settings(lens=str(tmp_path / "dark.toml"), lens_model="trace")).blurs


def test_each_point_of_the_film_has_its_own_distance():
    built, at = seen_from(POSED, (480.0, 0.0))
    middle, _ = seen_from(POSED, (480.0, 320.0))
    nearer = 12.0 * math.sin(POSED.tilt) * math.cos(POSED.swing)
    assert middle.film_distance - built.film_distance == pytest.approx(nearer)
    assert at[1] == pytest.approx(-3.0 - 12.0 * math.cos(POSED.tilt))


def test_section_and_plan_show_the_plane_and_its_lines():
    tilted = replace(POSED, swing=0.0, rise=0.0)
    found = in_section(tilted)
    assert in_section(Settings()) is None and set(found.points) == {"Hinge line", "Scheimpflug line"}
    assert set(found.planes) == {"sharp", "near", "far"}
    point, along = found.planes["sharp"]                        # through both lines
    for name in found.points:
        off = found.points[name] - point
        assert off[0] * along[1] - off[1] * along[0] == pytest.approx(0.0, abs=1e-6)
    assert math.atan2(*(found.film[1] - found.film[0])) == pytest.approx(tilted.tilt)
    swung, straight = plan(replace(POSED, tilt=0.0)), plan(Settings())
    assert abs(np.diff(straight.focus[:, 1])[0]) < 1e-9 < 0.05 < swung.focus[1, 1] - swung.focus[0, 1]
    assert swung.band.shape == (4, 2)
    assert "hinge" in sentence(POSED) and "flat, centred" in sentence(Settings())
    raised = Settings(lens="lentil-schneider-anamorphic-31-2001", focus_distance=3000.0, rise=4.0)
    assert sentence(raised) == "The film is shifted: what is in focus is a plane across the axis"   # beams are rounded


@pytest.mark.slow
def test_the_dials_of_a_view_camera_are_turned_by_hand_and_set_back():
    seen = {"settings": Settings()}
    chooser = Chooser()

    def show():
        seen["settings"] = controls_panel(seen["settings"], chooser)

    def test(ctx):
        ctx.yield_(3)
        ctx.item_click("**/###Drawer Tilt")
        ctx.yield_(3)
        for name in ("Tilt", "Rise"):
            ctx.mouse_move(f"**/{name}")
            ctx.mouse_wheel_y(3.0)
            ctx.yield_(3)
        seen["turned"] = seen["settings"]
        ctx.yield_(2)
        ctx.item_click("**/Centre")
        ctx.yield_(2)

    drive(show, test, (262, 640))
    assert seen["turned"].tilt != 0.0 and seen["turned"].rise != 0.0 and seen["turned"].swing == 0.0
    assert seen["settings"] == Settings()


def test_the_plane_of_sharp_focus_of_a_design_for_another_line_crosses_the_axis_at_the_focus_distance(tmp_path):
    triplet = lenses.load("lenshh-cooke-triplet-50")
    for line in (0.5876, 0.546):
        path = tmp_path / f"{line}.toml"
        lenses.save(replace(triplet, system=SystemData(wavelengths=(Wavelength(line),))), path)
        settings = replace(Settings(), lens=str(path), f_number=None, tilt=0.03, focus_distance=1494.0)
        plane = sharp_focus(settings).plane
        assert plane.offset / plane.normal[2] == pytest.approx(-1494.0, rel=1e-6), line


def test_keep_the_picture_keeps_what_a_tilted_film_shows_and_brings_into_focus():
    """Rise, shift, tilt and swing stayed as they were: a smaller film showed another part of the scene."""
    for width, height in ((24.0, 16.0), (54.0, 36.0)):
        other = with_equivalent_film(replace(POSED, shift=-2.0), width, height)
        assert (other.rise, other.shift) == pytest.approx((3.0 * width / 36.0, -2.0 * width / 36.0))
        hinges = [sharp_focus(settings).hinge for settings in (POSED, other)]
        np.testing.assert_allclose(*(hinge.point[:2] for hinge in hinges), rtol=5e-3)
        np.testing.assert_allclose(*(np.abs(hinge.direction) for hinge in hinges), atol=5e-3)
