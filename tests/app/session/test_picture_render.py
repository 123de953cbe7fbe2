"""Pictures rendered to files: the same bits however they are made, no half files, and an end at a wanted noise."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.camera_kinds import camera as camera_of
from lensbench.app.bench.constraints import with_camera
from lensbench.app.session.export import ExportError, develop, read_settings
from lensbench.app.session.picture_render import export_render, kept_path, render
from lensbench.app.session.recordings import TEXTS, load_arrays, save_arrays
from lensbench.app.settings.settings import Settings

TRIPLET = lenses.load("lenshh-cooke-triplet-50")
SMALL = replace(Settings(), pixels_x=24, pixels_y=16, samples=3)


def pixels(path):
    """(h, w, 3) of an EXR."""
    return OpenEXR.File(str(path)).channels()["RGB"].pixels


def test_an_export_renders_its_samples_and_says_so_in_the_settings(tmp_path):
    told = []
    assert export_render(SMALL, tmp_path / "a.png", progress=told.append).samples == 3
    with Image.open(tmp_path / "a.png") as read:
        assert read.size == (24, 16)
    assert read_settings(tmp_path / "a.png") == SMALL
    assert told == sorted(told) and told[0] == 0.0 and told[-1] == 1.0


@pytest.mark.parametrize("camera", ["perspective", "lens"])
def test_one_sample_of_a_view_is_that_of_the_middle_of_each_pixel_and_of_the_pupil(camera, tmp_path):
    settings = replace(with_camera(SMALL, camera), samples=1, view="direction")
    export_render(settings, tmp_path / "direction.exr")
    y, x = np.mgrid[0:16, 0:24] + 0.5
    rays = camera_of(settings).generate_rays(np.stack([x.ravel(), y.ravel()], 1), np.full((384, 2), 0.5))
    shown = 2.0 * pixels(tmp_path / "direction.exr").reshape(-1, 3) - 1.0
    np.testing.assert_allclose(shown, rays.directions, atol=1e-6)
    export_render(replace(settings, view="direction", samples=2), tmp_path / "two.exr")
    assert not np.array_equal(pixels(tmp_path / "two.exr"), pixels(tmp_path / "direction.exr"))


def test_the_same_settings_export_the_same_picture_bit_for_bit_on_any_number_of_threads(tmp_path):
    for threads in (1, 3):
        export_render(SMALL, tmp_path / f"{threads}.exr", threads=threads)
    one, three = (pixels(tmp_path / f"{threads}.exr") for threads in (1, 3))
    np.testing.assert_array_equal(one, three)
    assert np.isfinite(one).all() and one.max() > 0.0


def test_a_cancelled_export_writes_nothing(tmp_path):
    asked = []

    def cancelled():
        asked.append(True)
        return len(asked) > 3

    (tmp_path / "a.png").write_bytes(b"the old file")
    assert not export_render(replace(SMALL, samples=10_000), tmp_path / "a.png", cancelled=cancelled)
    assert os.listdir(tmp_path) == ["a.png"]
    assert (tmp_path / "a.png").read_bytes() == b"the old file"


def test_a_folder_that_may_not_be_written_to_is_said_before_anything_is_rendered(tmp_path, monkeypatch):
    def forbidden(path):                    # as the system answers; the tests may run as one who may write anywhere
        raise PermissionError(13, "Permission denied")

    told = []
    (tmp_path / "a.png").write_bytes(b"the old file")
    monkeypatch.setattr(Path, "touch", forbidden)
    with pytest.raises(ExportError, match=r"a\.png: Permission denied: nothing was written"):
        export_render(SMALL, tmp_path / "a.png", progress=told.append)
    assert not told and (tmp_path / "a.png").read_bytes() == b"the old file"


def test_an_export_that_cannot_be_written_fails_before_it_renders(tmp_path):
    told = []
    with pytest.raises(ExportError, match="there is no folder"):
        export_render(SMALL, tmp_path / "no" / "a.png", progress=told.append)
    assert not told


# A render that is stopped, and goes on

LIT = replace(SMALL, scene="night-lights", samples=12)
STOPPED = {"a picture": SMALL, "lights traced to the film": LIT, "means over what arrives": replace(SMALL, view="time"),
           "negative numbers": replace(SMALL, view="origin"),
           "a lens that disperses": replace(SMALL, dispersion="on", lens="lv-leica-summicron-m-50f2-v5")}


def stops_after(passes):
    asked = []
    return lambda: len(asked) >= passes or asked.append(None) is None and len(asked) >= passes


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow) if name == "lights traced to the film"
                                  else name for name in STOPPED])
def test_a_render_that_was_stopped_goes_on_to_the_same_bits(tmp_path, name):
    settings, path = STOPPED[name], tmp_path / "a.exr"
    assert export_render(settings, path, resume=True, stopping=stops_after(2)) is None
    assert os.listdir(tmp_path) == [kept_path(path).name]
    told = []
    found = export_render(settings, path, resume=True, progress=told.append)
    assert os.listdir(tmp_path) == ["a.exr"] and found.samples == settings.samples and told[0] > 0.0
    np.testing.assert_array_equal(pixels(path), render(settings)[0])


def test_more_samples_may_be_wanted_of_a_stopped_render(tmp_path):
    path = tmp_path / "a.exr"
    export_render(SMALL, path, resume=True, stopping=stops_after(1))
    more = replace(SMALL, samples=7)
    export_render(more, path, resume=True)
    np.testing.assert_array_equal(pixels(path), render(more)[0])


def test_kept_samples_of_other_settings_are_refused_and_stay(tmp_path):
    path = tmp_path / "a.exr"
    export_render(SMALL, path, resume=True, stopping=stops_after(1))
    kept = kept_path(path).read_bytes()
    with pytest.raises(ExportError, match="of other settings or of another version: remove the file"):
        export_render(replace(SMALL, seed=5), path, resume=True)
    assert kept_path(path).read_bytes() == kept


@pytest.mark.parametrize("changed", ["lens", "scene", "texture", "stop"])
def test_kept_samples_of_a_file_that_has_changed_since_are_refused(tmp_path, changed):
    """A picture was mixed from the samples of both lenses, or of both scenes, without a word."""
    lens, scene, texture, stop = (tmp_path / name for name in ("lens.toml", "scene.toml", "wall.png", "stop.png"))
    lenses.save(TRIPLET, lens)
    scene.write_text('[floor]\nheight = "-1m"\ntexture = "wall.png"\n')
    for image in (texture, stop):
        Image.new("L", (8, 8), 200).save(image)
    path = tmp_path / "a.exr"
    settings = replace(SMALL, lens=str(lens), scene=str(scene), f_number=None, focus_distance=2000.0,
                       stop_image=str(stop) if changed == "stop" else "")
    assert export_render(settings, path, resume=True, stopping=stops_after(1)) is None
    if changed == "lens":
        lenses.save(TRIPLET.scaled(1.01), lens)
    elif changed == "scene":
        scene.write_text(scene.read_text().replace("-1m", "-2m"))
    else:
        Image.new("L", (8, 8), 100).save(texture if changed == "texture" else stop)
    with pytest.raises(ExportError, match="samples of an earlier lens or scene file"):
        export_render(settings, path, resume=True)


def test_a_damaged_file_of_kept_samples_is_refused(tmp_path):
    path = tmp_path / "a.exr"
    export_render(SMALL, path, resume=True, stopping=stops_after(1))
    kept = kept_path(path)
    kept.write_bytes(kept.read_bytes()[:-200])
    with pytest.raises(ExportError, match="cut short"):
        export_render(SMALL, path, resume=True)


def test_sums_of_another_picture_are_refused_and_nothing_changes():
    scene = lb.builtin_scene("white-wall")
    small, large = (lb.Rendering(lb.PerspectiveCamera(lb.Film(36.0, 24.0, side, side)), scene) for side in (8, 40))
    large.add(1, threads=1)
    with pytest.raises(ValueError, match="another picture"):
        small.restore(large.state)
    assert small.samples == 0


# A render that ends at a wanted noise

NOISY = replace(SMALL, samples=4096)


@pytest.mark.slow
def test_a_render_ends_at_a_wanted_noise_and_says_so(tmp_path):
    found = export_render(NOISY, tmp_path / "a.png", noise=0.02)
    image = render(replace(NOISY, samples=found.samples))[0]
    assert 0.0 < found.noise <= 0.02 and found.samples < 4096
    assert read_settings(tmp_path / "a.png").samples == found.samples
    # The estimate is not too small: the picture is that near to one of many more samples
    best = render(replace(NOISY, seed=9))[0]
    error = np.sqrt(np.mean((develop(image, NOISY) - develop(best, NOISY)) ** 2))
    assert error < 1.2 * found.noise


def test_samples_that_do_not_suffice_are_said():
    _, found = render(replace(SMALL, samples=16), noise=1e-5)
    assert found.samples == 16 and found.noise > 1e-5


@pytest.mark.slow
def test_a_render_that_was_stopped_ends_at_the_same_noise_with_the_same_bits(tmp_path):
    path = tmp_path / "a.exr"
    whole = export_render(NOISY, tmp_path / "whole.exr", noise=0.02)
    for passes in (1, 3, 6):
        export_render(NOISY, path, noise=0.02, resume=True, stopping=stops_after(passes))
    found = export_render(NOISY, path, noise=0.02, resume=True)
    assert (found.samples, found.noise) == (whole.samples, whole.noise)
    np.testing.assert_array_equal(pixels(path), pixels(tmp_path / "whole.exr"))


@pytest.fixture
def single_samples(monkeypatch):
    """Passes of one sample each, however fast the machine is."""
    monkeypatch.setattr("lensbench.app.session.picture_render.PASS_SECONDS", 0.0)


@pytest.mark.usefixtures("single_samples")
def test_a_render_whose_noise_is_reached_already_gets_no_more_samples(tmp_path):
    path = tmp_path / "a.exr"
    assert export_render(NOISY, path, noise=1e-5, resume=True, stopping=stops_after(20)) is None
    with np.load(kept_path(path)) as kept:
        samples, noise = int(kept["samples"]), float(kept["noise"])
    found = export_render(NOISY, path, noise=1.01 * noise, resume=True)
    assert found.samples == samples and found.noise <= 1.01 * noise


@pytest.mark.usefixtures("single_samples")
def test_of_samples_without_an_estimate_of_their_noise_a_tenth_more_tells_it(tmp_path):
    path = tmp_path / "a.exr"
    assert export_render(NOISY, path, resume=True, stopping=stops_after(40)) is None
    found = export_render(NOISY, path, noise=0.5, resume=True)
    assert found.samples == 44 and found.noise <= 0.5


@pytest.mark.usefixtures("single_samples")
def test_the_noise_of_another_picture_is_refused(tmp_path):
    path = tmp_path / "a.exr"
    assert export_render(NOISY, path, noise=1e-5, resume=True, stopping=stops_after(20)) is None
    _, settings = load_arrays(kept_path(path), "", "", lambda names: names - set(TEXTS), lambda headers, found: True,
                              light=False)
    with np.load(kept_path(path)) as kept:
        arrays = {name: kept[name] for name in kept.files if name not in TEXTS}
    for change, why in (({"noise_samples": arrays["samples"] + 1}, "noise of another picture"),
                        ({"noise_image": arrays["noise_image"][1:]}, "noise of another picture"), (None, "incomplete")):
        changed = arrays | change if change else {name: arrays[name] for name in arrays if name != "noise"}
        save_arrays(kept_path(path), settings, **changed)
        with pytest.raises(ExportError, match=why):
            export_render(NOISY, path, noise=0.02, resume=True)
