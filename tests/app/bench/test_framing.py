"""One rule places the camera: what it is framed on stands in the picture, as high as stated, and in focus."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.camera_kinds import MAKERS, readings
from lensbench.app.bench.constraints import with_film
from lensbench.app.bench.framing import (
    PLACE, SIZE, frame_height, framed, framing_of, framings, in_the_way, moved_text, resized, scene_exposure,
    with_framing, with_scene
)
from lensbench.app.bench.lens_choice import LOCKS, with_lens
from lensbench.app.scenes.scene_file import SceneFileError, load_scene
from lensbench.app.settings.settings import Settings

PORTRAIT, FAR, PHONE, ZOOM = ("sony-fe-gm-ii-85-f14", "canon-new-fd-l-800-f56", "lib-us7558005a",
                              "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed")
LENSES = ("pbrt-dgauss-50mm", PORTRAIT, FAR, PHONE, ZOOM, "canon-ef-is-usm-28-135-f35",
          "fujifilm-super-ebc-fujinon-71-284-f2", "leica-apo-macro-elmarit-tl-asph-60-f28",
          "kino-precision-kiron-mc-macro-105-f28", "pbrt-fisheye-10mm", "lenshh-laikin-fisheye160-f2",
          "pbrt-wide-22mm")
FISHEYES = ("pbrt-fisheye-10mm", "lenshh-laikin-fisheye160-f2")


def in_camera(settings: Settings, points: np.ndarray) -> np.ndarray:
    """Points (n, 3) of the world in the frame of the camera (mm)."""
    return (np.linalg.inv(settings.world_from_camera) @ np.column_stack([points, np.ones(len(points))]).T).T[:, :3]


def is_framed(settings: Settings) -> None:
    """The framing's middle and its upper and lower ends are in the picture, and its middle lies in the focus."""
    _, centre, height = framing_of(settings)
    ends = np.array([centre, np.add(centre, (0.0, 0.4 * height, 0.0)), np.subtract(centre, (0.0, 0.4 * height, 0.0))])
    points = in_camera(settings, ends)
    got = readings(settings)
    assert got.near_limit <= -points[0, 2] <= (got.far_limit if got.far_limit > 0.0 else math.inf)
    assert points[0, :2] == pytest.approx([0.0, 0.0], abs=1e-6)
    camera = MAKERS[settings.camera].camera(replace(settings, lens_model="trace") if settings.has_lens else settings)
    film, seen = camera.film_from_point(points, np.full((3, 2), 0.5))
    half = 0.5 * np.array([settings.film.width, settings.film.height])
    if in_the_way(settings) or settings.lens in FISHEYES and settings.has_lens:
        film, seen = film[:1], seen[:1]
    assert seen.all() and (np.abs(film) <= half).all(), (film, half)
    if len(film) == 3 and got.nearest_focus * 1.01 < settings.focus_distance > 251.0:
        assert np.ptp(film[:, 1]) == pytest.approx(0.8 * min(2.0 * half), rel=0.12)     # distortion


@pytest.mark.parametrize("scene", lb.SCENES)
@pytest.mark.parametrize("lens", LENSES)
def test_a_scene_opens_framed_and_in_focus_with_the_lens_in_hand_and_in_either_order(lens, scene):
    in_hand = with_lens(with_scene(Settings(), "dusk-street"), lens)
    chosen = with_scene(in_hand, scene)
    is_framed(chosen)
    assert with_lens(with_scene(Settings(), scene), lens) == chosen
    assert with_framing(chosen, "subject") == chosen


@pytest.mark.parametrize("zoom", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("film", [(36.0, 24.0), (23.5, 15.6), (12.8, 9.6)])
def test_zoom_and_format_are_kept_to_the_rule(zoom, film):
    in_hand = replace(with_lens(Settings(), ZOOM), zoom=zoom)
    for settings in (with_scene(with_film(in_hand, *film), "portrait"),
                     framed(with_film(with_scene(in_hand, "portrait"), *film))):
        is_framed(settings)


@pytest.mark.parametrize("camera", ["perspective"])
def test_a_camera_without_a_lens_is_framed_and_focused_too(camera):
    for scene in lb.SCENES:
        settings = with_scene(replace(Settings(), camera=camera, f_number=2.8), scene)
        _, centre, height = framing_of(settings)
        point = in_camera(settings, np.array([centre]))[0]
        assert -point[2] == pytest.approx(settings.focus_distance)
        seen = 2.0 * math.tan(0.5 * settings.fov) * settings.focus_distance
        assert seen == pytest.approx(height) or settings.focus_distance == 250.0


def test_with_the_padlock_of_the_focus_a_scene_opens_at_this_distance():
    """The camera stood at the origin, and a portrait lens showed a blurred chin."""
    for focus in (1500.0, 2500.0):
        settings = with_scene(replace(with_lens(Settings(), PORTRAIT), focus_distance=focus), "portrait", {PLACE})
        assert settings.focus_distance == focus
        is_at = in_camera(settings, np.array([framing_of(settings).centre]))[0]
        assert is_at == pytest.approx([0.0, 0.0, -focus])


@pytest.mark.parametrize("locked", LOCKS)
def test_a_scene_is_in_focus_whatever_is_locked(locked):
    settings = with_scene(with_lens(replace(Settings(), focus_distance=3000.0), FAR), "portrait", {locked})
    point = in_camera(settings, np.array([framing_of(settings).centre]))[0]
    assert point == pytest.approx([0.0, 0.0, -settings.focus_distance], abs=1e-6)


def test_what_a_scene_is_framed_on_is_there():
    """Some ray to the middle half of every framing meets something as near as half its height."""
    grid = np.linspace(-0.25, 0.25, 15)
    for name in lb.SCENES:
        scene = lb.builtin_scene(name)
        for framing in framings(name).values() if name != "white-wall" else ():
            across, up = (share.ravel() * framing.height for share in np.meshgrid(grid, grid))
            eye = np.add(framing.centre, (0.0, 0.0, min(3.0 * framing.height, 1500.0)))
            ends = np.add(framing.centre, np.column_stack([across, up, 0.0 * up])) - eye
            length = np.linalg.norm(ends, axis=1)
            met = scene.distance(np.tile(eye, (len(ends), 1)), ends / length[:, None])
            assert (np.abs(met - length) < 0.5 * framing.height).any(), (name, framing.name)


def test_a_person_has_framings_of_the_body_and_other_scenes_have_not():
    assert list(framings("portrait")) == ["head", "head-and-shoulders", "half-figure", "full-figure", "subject",
                                          "whole-scene"]
    assert list(framings("dusk-street")) == ["close", "subject", "whole-scene"]
    heights = [framing.height for framing in list(framings("portrait").values())[:4]]
    assert heights == sorted(heights)
    head = with_framing(with_lens(with_scene(Settings(), "portrait"), PORTRAIT), "head")
    is_framed(head)
    assert framing_of(with_scene(head, "still-life")).name == "subject"
    assert framing_of(replace(head, scene="still-life")).name == "subject"          # which has no head
    assert with_lens(head, FAR).framing == "head"
    is_framed(with_lens(head, FAR))


def test_the_subject_keeps_its_size_where_this_is_locked():
    by_hand = replace(with_lens(Settings(), PORTRAIT), focus_distance=2500.0, position=(40.0, 10.0, 1300.0))
    height = frame_height(by_hand)
    assert height == pytest.approx(24.0 / readings(by_hand).magnification, rel=0.02)
    for changed in (with_lens(by_hand, "pbrt-dgauss-50mm", {SIZE}), resized(replace(by_hand, crop=0.5), height)):
        assert frame_height(changed) == pytest.approx(height, rel=1e-6)
        assert changed.position[:2] == by_hand.position[:2]
        assert changed.position[2] - changed.focus_distance == pytest.approx(1300.0 - 2500.0)
    assert moved_text(by_hand, resized(replace(by_hand, crop=0.5), height)).startswith("Camera moved back 2.")
    assert moved_text(by_hand, with_lens(by_hand, "pbrt-dgauss-50mm", {SIZE})).startswith("Camera moved forward ")
    stays = with_lens(by_hand, "pbrt-dgauss-50mm", {SIZE, PLACE})
    assert stays.position == by_hand.position and moved_text(by_hand, stays) == ""


@pytest.mark.parametrize("scene", lb.SCENES)
def test_a_scene_is_exposed_as_a_meter_would_or_up_to_two_stops_off(scene):
    settings = replace(with_scene(Settings(), scene), pixels_x=90, pixels_y=60)
    picture = lb.render(MAKERS["lens"].camera(settings), lb.builtin_scene(scene), samples=8)
    darker = lb.metered_stops(picture) - settings.exposure
    assert settings.exposure == scene_exposure(scene)
    assert -2.8 < darker < 1.7                  # white is two and a half stops over grey, and a night is dark


def test_a_scene_leaves_the_correction_of_a_metered_exposure():
    assert with_scene(replace(Settings(), exposing="automatic", exposure=0.5), "room").exposure == 0.5
    assert with_scene(replace(Settings(), exposure=0.5), "night-lights").exposure == 1.7


def test_a_scene_file_states_its_framings_and_its_exposure(tmp_path):
    path = tmp_path / "one.toml"
    ball = "[[sphere]]\ncentre = [0, 0, -3000]\nradius = 100\n"
    path.write_text(f'exposure = 1.5\n{ball}[framing.head]\ncentre = [0, "5 cm", "-2.9 m"]\nheight = "30 cm"\n')
    assert load_scene(path).exposure == 1.5 and "close" not in framings(str(path))
    assert framings(str(path))["head"] == ("head", (0.0, 50.0, -2900.0), 300.0)
    for table, problem in (("[framing.hat]\ncentre = [0, 0, -1]\nheight = 1\n", "no framing is called hat"),
                           ("[framing.head]\ncentre = [0, 0, -1]\n", "height"),
                           ("[framing.head]\ncentre = [0, 0, -1]\nheight = 0\n", "positive")):
        path.write_text(ball + table)
        with pytest.raises(SceneFileError, match=problem):
            load_scene(path)


def test_under_water_a_height_fills_the_film_by_the_matrices_of_the_lens():
    settings = replace(Settings(), medium="water", immersed=True, focus_distance=3000.0)
    bench = bench_of(settings)
    data = lb.first_order(bench.lens)
    magnification = (lb.film_distance(bench.lens, bench.focus_distance) - data.bfl) / data.efl      # Newton: x′ / f′
    low = min(settings.film.width, settings.film.height)
    assert bench.lens.front_index > 1.3 and frame_height(settings) == pytest.approx(low / magnification, rel=2e-3)
