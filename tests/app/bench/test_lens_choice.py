"""A lens at its best: its own film, wide open, before the subject; what is locked stays."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import design
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.constraints import constrained
from lensbench.app.bench.framing import FRAME, framing_of, framings, in_the_way, with_scene
from lensbench.app.bench.lens_choice import FILM, image_circle, own_film, with_lens
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.system import FieldKind, FieldPoint, SystemData
from tests.library import EVERY

LENS, FISHEYE, PHONE, FAR = "lv-nikon-z-58f095-noct", "pbrt-fisheye-10mm", "lib-us7558005a", "pbrt-telephoto-250mm"
HAND = replace(Settings(), position=(30.0, 20.0, 10.0), yaw=0.2, f_number=5.6, focus_distance=3000.0, crop=0.5)


def subject_in_view(settings: Settings) -> np.ndarray:
    """The subject in the frame of the camera (mm)."""
    point = np.array([*framing_of(settings).centre, 1.0])
    return (np.linalg.inv(settings.world_from_camera) @ point)[:3]


@pytest.mark.parametrize("name", EVERY)
def test_every_library_lens_stands_focused_and_open_before_its_subject(name):
    got = with_lens(HAND, name)
    figures = readings(got)
    assert constrained(got) == got and figures.reason == ""
    assert got.f_number is None and got.crop == 1.0 and got.zoom == 0.0
    # The subject lies on the axis, in the plane in focus
    assert subject_in_view(got) == pytest.approx([0.0, 0.0, -got.focus_distance], abs=1e-6)
    # Its surroundings fill the shorter side, unless the lens cannot focus so near
    frame = min(got.film.width, got.film.height) / figures.magnification
    assert frame == pytest.approx(FRAME, rel=0.1) or got.focus_distance < 1.001 * max(figures.nearest_focus, 250.0)
    # The film is the stated one, or no larger than the light
    made_for = design(got).film_size
    circle = made_for and math.hypot(*made_for) or image_circle(name, design(got))
    assert circle is None or 0.92 * got.film.diagonal <= circle * 1.001
    assert math.isclose(got.pixels_x / got.pixels_y, got.film_width / got.film_height, rel_tol=0.01)


def test_the_settings_depend_on_the_lens_and_not_on_the_lens_before():
    direct = with_lens(Settings(), FAR)
    assert with_lens(with_lens(with_lens(Settings(), PHONE), FISHEYE), FAR) == direct


@pytest.mark.parametrize("locked", ["film", "aperture", "focus"])
def test_what_is_locked_stays_and_the_rest_is_chosen(locked):
    kept = {"film": ("film_width", "film_height", "crop", "pixels_x", "pixels_y"), "aperture": ("f_number",),
            "focus": ("focus_distance", "position", "yaw", "pitch")}
    free, fixed = with_lens(HAND, PHONE), with_lens(HAND, PHONE, {locked})
    for lock, names in kept.items():
        for name in names:
            expected = HAND if lock == locked else free
            if not (locked == "film" and lock == "focus"):      # another film is framed from another place
                assert getattr(fixed, name) == getattr(expected, name), name


def test_a_locked_focus_is_no_nearer_than_the_lens_focuses():
    near = replace(HAND, focus_distance=200.0)
    assert with_lens(near, FAR, {"focus"}).focus_distance == pytest.approx(readings(with_lens(near, FAR)).nearest_focus,
                                                                          rel=2e-3)


def test_a_camera_between_keyframes_keeps_its_place():
    moving = replace(HAND, end_position=(100.0, 0.0, 0.0))
    assert with_lens(moving, FAR).position == moving.position


def test_a_camera_without_a_lens_becomes_one_with_a_lens():
    assert with_lens(replace(HAND, camera="perspective"), LENS).camera == "lens"


def test_what_stands_between_the_subject_and_its_camera_is_said():
    held = with_lens(replace(Settings(), scene="room"), FAR)
    assert in_the_way(held).endswith("the camera is 2.55 m from the subject, which this lens would frame from 5.96 m")
    free = with_lens(Settings(), FAR)
    locked = with_lens(replace(Settings(), scene="room"), FAR, {"focus"})
    moved = replace(held, position=(0.0, 0.0, 900.0))
    gone = replace(held, lens="/no-such-folder/gone.zmx")
    assert [in_the_way(each) for each in (free, locked, moved, gone, replace(held, camera="perspective"))] == [""] * 5


def test_a_scene_opens_beside_a_lens_that_cannot_be_read():
    gone = replace(Settings(), lens="/no-such-folder/gone.zmx")
    assert with_scene(gone, "dusk-street") == replace(gone, scene="dusk-street", exposure=1.0)


def test_nothing_stands_between_the_camera_and_the_subject_in_a_room():
    got = with_lens(replace(Settings(), scene="room"), FAR)
    eye = np.asarray(got.position)
    met = cached_scene("room").distance([eye], [[0.0, 0.0, -1.0]])[0]
    assert met > 0.99 * got.focus_distance
    behind = cached_scene("room").distance([eye], [[0.0, 0.0, 1.0]])[0]
    assert 0.0 < behind < 1000.0            # it would stand farther back in the open
    assert with_lens(Settings(), FAR).focus_distance > 2.0 * got.focus_distance


def test_the_subject_of_a_scene_file_is_what_stands_in_the_middle(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text('name = "ball"\n[[sphere]]\ncentre = [0, 0, -3000]\nradius = 100\n')
    assert framings(str(path))["subject"].centre == pytest.approx((0.0, 0.0, -2900.0))
    beside = tmp_path / "beside.toml"
    beside.write_text('name = "beside"\n[[sphere]]\ncentre = [900, 0, -3000]\nradius = 100\n')
    assert framings(str(beside))["subject"].centre == (0.0, 0.0, -1200.0)


def test_a_subject_that_is_stated_at_the_middle_of_a_body_is_not_in_its_own_way(tmp_path):
    """The camera stood within 25 cm of the middle of the box, which this lens frames from 1.4 m."""
    path = tmp_path / "box.toml"
    front = 'subject = ["1.5 m", "60 cm"]\n[[disk]]\ncentre = [0, 0, -1350]\nnormal = [0, 0, 1]\nradius = 150\n'
    path.write_text(front)
    settings = with_lens(replace(Settings(), scene=str(path)), "pbrt-dgauss-50mm")
    assert settings.focus_distance > 1300.0 and in_the_way(settings) == ""
    path.write_text(f"{front}[[sphere]]\ncentre = [0, 0, -800]\nradius = 100\n")
    held = with_lens(replace(Settings(), scene=str(path)), "pbrt-dgauss-50mm")
    assert held.focus_distance < 600.0 and "stands in the way" in in_the_way(held)


def test_a_scene_that_states_its_subject_is_framed_on_it(tmp_path):
    path = tmp_path / "two.toml"
    path.write_text('subject = ["4 m", "2 m"]\n[[sphere]]\ncentre = [900, 0, -3000]\nradius = 100\n')
    for scene, distance, height in (("dusk-street", 4600.0, 1560.0), ("test-chart", 1995.0, 1052.0),
                                    (str(path), 4000.0, 2000.0)):
        chosen = with_scene(replace(HAND, crop=1.0), scene)
        assert chosen == replace(with_lens(replace(HAND, scene=scene, yaw=0.0), HAND.lens), f_number=5.6,
                                 exposure=cached_scene(scene).exposure)
        assert chosen.position[2] - chosen.focus_distance == pytest.approx(-distance)
        assert min(chosen.film_width, chosen.film_height) / readings(chosen).magnification == (
            pytest.approx(height, rel=0.1))
    kept = with_scene(HAND, "dusk-street", {"focus"})
    assert kept.position == (0.0, 0.0, HAND.focus_distance - 4600.0) and kept.focus_distance == HAND.focus_distance
    with pytest.raises(lb.SceneError, match="subject"):
        lb.Scene(subject=(0.0, 1.0))


@pytest.mark.parametrize("scene", lb.SCENES)
@pytest.mark.parametrize("lens", [LENS, FAR])
def test_a_lens_and_a_scene_give_the_same_camera_in_either_order(lens, scene):
    """A scene that was chosen after a long lens kept the focus of the scene before, at the origin."""
    before = with_lens(with_scene(Settings(), "dusk-street"), FAR)
    assert with_scene(with_lens(before, lens), scene) == with_lens(with_scene(before, scene), lens)


def test_the_film_is_the_stated_one_else_follows_the_field_else_the_light():
    lens = lenses.load("pbrt-dgauss-50mm")
    assert own_film("a file", replace(lens, film_size=(10.0, 7.5))) == (10.0, 7.5)
    half = math.degrees(math.atan(14.2 / lb.first_order(lens).efl))
    lens = replace(lens, film_size=None)
    stated = replace(lens, system=SystemData(field_kind=FieldKind.ANGLE, fields=(FieldPoint(0.0, half),)))
    assert own_film("a file", stated) == lb.FORMATS["APS-C 23.5 × 15.6"]
    tiny = replace(lens, system=SystemData(field_kind=FieldKind.IMAGE_HEIGHT, fields=(FieldPoint(0.0, 2.5),)))
    assert own_film("a file", tiny) == (4.0, 3.0)


def test_a_lens_that_forms_its_image_inside_has_the_usual_film_and_no_film_of_nothing(tmp_path):
    ball = lb.Lens((lb.Surface(9.0, 3.0, lb.Glass(2.0), curvature=0.25), lb.Surface(1.0, 3.0, curvature=-0.25)), 0)
    lenses.save(ball, tmp_path / "ball.toml")
    assert own_film(str(tmp_path / "ball.toml"), ball) == (36.0, 24.0)


def test_another_lens_has_its_film_in_line_unless_the_film_is_locked():
    moved = replace(Settings(), tilt=0.05, rise=4.0, film_radius=-90.0)
    assert with_lens(moved, "apple-phone-6-elements-4-f18").film_pose.is_upright
    kept = with_lens(moved, "canon-50-f12", {FILM})
    assert (kept.tilt, kept.rise, kept.film_radius) == (0.05, 4.0, -90.0)
