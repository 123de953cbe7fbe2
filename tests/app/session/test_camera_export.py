"""Exported cameras see what ours see: each file read by the conventions of its program, points projected by hand."""

import math
import re
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.session.camera_export import export_camera

FILM = lb.Film(36.0, 24.0, 300, 200)
WORLD = lb.look_at((300.0, 200.0, 100.0), (0.0, 0.0, -2000.0), up=(0.1, 1.0, 0.0))
LENS = lenses.load("pbrt-dgauss-50mm")
CAMERAS = {"perspective": lb.PerspectiveCamera(FILM, 0.7, 5.0, 900.0, world_from_camera=WORLD),
           "thin": lb.LensCamera(LENS, FILM, 1500.0, 4.0, model="thin", world_from_camera=WORLD)}
POINTS = np.array([[0.0, 0.0, -2000.0], [150.0, -90.0, -1500.0], [-300.0, 250.0, -2500.0], [40.0, 60.0, -900.0]])


def pbrt(path):
    """Camera from world, with y up, x to the right, z ahead; focal length in half short sides; depth in focus (m)."""
    text = path.read_text(encoding="utf-8")
    matrix = np.array(re.search(r"Transform \[ (.*?) \]", text)[1].split(), float).reshape(4, 4).T
    fov = float(re.search(r'"float fov" (\S+)', text)[1])
    return matrix, FILM.height / 2.0 / math.tan(math.radians(fov) / 2.0), float(
        re.search(r'"float focaldistance" (\S+)', text)[1])


def mitsuba(path):
    text = path.read_text(encoding="utf-8")
    world = np.array(re.search(r'matrix value="(.*?)"', text)[1].split(), float).reshape(4, 4)
    fov = float(re.search(r'"fov" value="(.*?)"', text)[1])
    assert np.linalg.det(world) == pytest.approx(1.0)           # x to the left
    return np.diag([-1.0, 1.0, 1.0, 1.0]) @ np.linalg.inv(world), FILM.width / 2.0 / math.tan(
        math.radians(fov) / 2.0), float(re.search(r'"focus_distance" value="(.*?)"', text)[1])


def blender(path):
    """Run the script with stand-ins for Blender's modules."""
    data, thing = SimpleNamespace(dof=SimpleNamespace()), SimpleNamespace()
    bpy = SimpleNamespace(data=SimpleNamespace(cameras=SimpleNamespace(new=lambda name: data),
                                               objects=SimpleNamespace(new=lambda name, of: thing)),
                          context=SimpleNamespace(collection=SimpleNamespace(objects=SimpleNamespace(link=id)),
                                                  scene=SimpleNamespace(render=SimpleNamespace())))
    kept = {name: sys.modules.get(name) for name in ("bpy", "mathutils")}
    sys.modules.update({"bpy": bpy, "mathutils": SimpleNamespace(Matrix=np.array)})
    try:
        exec(path.read_text(encoding="utf-8"), {})
    finally:
        for name, module in kept.items():
            sys.modules.pop(name) if module is None else sys.modules.update({name: module})
    assert bpy.context.scene.camera is thing and data.sensor_width == FILM.width
    from_ours = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])     # +y up → +z up, ahead −z → +y
    return (np.diag([1.0, 1.0, -1.0, 1.0]) @ np.linalg.inv(thing.matrix_world) @ from_ours, data.lens,
            data.dof.focus_distance)


@pytest.mark.parametrize("to, name", [("pbrt", "perspective"), *((to, name) for to in ("mitsuba", "blender")
                                                                 for name in CAMERAS)])
def test_an_exported_camera_projects_points_as_ours(to, name, tmp_path):
    camera, path = CAMERAS[name], tmp_path / "camera"
    remarks = export_camera(camera, to, path)
    assert ["weighs all rays" in remark for remark in remarks] == [True] + [False] * (name == "thin")
    matrix, focal, focus = {"pbrt": pbrt, "mitsuba": mitsuba, "blender": blender}[to](path)
    x, y, z, _ = matrix @ np.vstack([POINTS.T / 1000.0, np.ones(len(POINTS))])
    raster = np.stack([150.0 + focal * x / z * 300.0 / 36.0, 100.0 - focal * y / z * 200.0 / 24.0], 1)
    np.testing.assert_allclose(raster, camera.raster_from_point(POINTS)[0], atol=1e-6)
    rays = camera.generate_rays([[150.0, 100.0]], [[0.5, 0.5]])
    sharp = rays.origins[0] + rays.directions[0] * focus * 1000.0
    uv = np.random.default_rng(0).random((20, 2))
    np.testing.assert_allclose(camera.raster_from_point(np.tile(sharp, (20, 1)), uv)[0], [[150.0, 100.0]] * 20,
                               atol=1e-6)


def test_up_and_ahead_are_those_of_the_other_programs_world(tmp_path):
    """Blender's world is z-up, and its default camera looks along −z with y up; ours at rest looks ahead, y up."""
    export_camera(lb.PerspectiveCamera(FILM, 0.7), "blender", tmp_path / "camera.py")
    script = (tmp_path / "camera.py").read_text(encoding="utf-8")
    world = np.array(eval(re.search(r"Matrix\((.*)\)", script)[1]))
    np.testing.assert_allclose(world @ [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0])      # the picture's up is the sky
    np.testing.assert_allclose(world @ [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0])     # and it looks at the horizon


BLURRED = {**CAMERAS, "orthographic": lb.OrthographicCamera(FILM, 900.0, 7.0, 1200.0, world_from_camera=WORLD)}


def aperture_radius(path, to):
    """Radius (m) of the aperture of an exported camera, by its program's conventions."""
    text = path.read_text(encoding="utf-8")
    if to == "blender":                     # Cycles: half of the focal length over the f-number
        focal, stop = (float(re.search(rf"{name} = (\S+)", text)[1]) for name in ("data.lens", "aperture_fstop"))
        return focal / (2.0 * stop) / 1000.0
    return float(re.search(r'lensradius" (\S+)' if to == "pbrt" else r'aperture_radius" value="(.*?)"', text)[1])


@pytest.mark.parametrize("to, name", [("pbrt", "perspective"), ("pbrt", "orthographic"), ("mitsuba", "perspective"),
                                      ("mitsuba", "thin"), ("blender", "perspective"), ("blender", "thin")])
def test_the_outermost_rays_of_ours_pass_the_edge_of_the_exported_aperture(to, name, tmp_path):
    """The rays of one film point through the edge of the pupil, where they cross the plane of the other's lens."""
    camera, path = BLURRED[name], tmp_path / "camera"
    export_camera(camera, to, path)
    text = path.read_text(encoding="utf-8")
    if to == "blender":
        from_world = blender(path)[0]
    else:
        numbers = re.search(r"Transform \[ (.*?) \]" if to == "pbrt" else r'matrix value="(.*?)"', text)[1].split()
        matrix = np.array(numbers, float).reshape(4, 4)
        from_world = matrix.T if to == "pbrt" else np.linalg.inv(matrix)
    edge = np.linspace(0.0, 1.0, 9)
    uv = np.array([[0.5, 0.5], *[[u, v] for u in edge for v in edge if 0.0 in (u, v) or 1.0 in (u, v)]])
    rays = camera.generate_rays(np.tile([[170.0, 90.0]], (len(uv), 1)), uv)
    origins = rays.origins / 1000.0 @ from_world[:3, :3].T + from_world[:3, 3]
    directions = rays.directions @ from_world[:3, :3].T
    there = origins - directions * (origins[:, 2] / directions[:, 2])[:, None]
    distances = np.linalg.norm(there[1:] - there[0], axis=1)
    np.testing.assert_allclose(distances, aperture_radius(path, to), rtol=1e-6)      # the pupil is single


def test_an_exported_orthographic_camera_projects_points_as_ours(tmp_path):
    """pbrt's screen window, in metres of the camera's x and y, is the whole raster."""
    camera = lb.OrthographicCamera(FILM, 900.0, world_from_camera=WORLD)
    assert export_camera(camera, "pbrt", tmp_path / "camera.pbrt") == []
    text = (tmp_path / "camera.pbrt").read_text(encoding="utf-8")
    matrix = np.array(re.search(r"Transform \[ (.*?) \]", text)[1].split(), float).reshape(4, 4).T
    left, right, bottom, top = map(float, re.search(r"screenwindow\" \[ (.*?) \]", text)[1].split())
    x, y, _, _ = matrix @ np.vstack([POINTS.T / 1000.0, np.ones(len(POINTS))])
    raster = np.stack([(x - left) / (right - left) * 300.0, (top - y) / (top - bottom) * 200.0], 1)
    np.testing.assert_allclose(raster, camera.raster_from_point(POINTS)[0], atol=1e-6)


def test_a_round_aperture_has_the_area_that_the_blades_leave(tmp_path):
    """Six straight blades leave (3 / π) sin 60° of the circle through their corners."""
    camera = lb.PerspectiveCamera(FILM, 0.7, 5.0, 900.0, blades=6)
    part = math.sqrt(3.0 / math.pi * math.sin(math.radians(60.0)))
    assert any("blades" in remark for remark in export_camera(camera, "pbrt", tmp_path / "six.pbrt"))
    text = (tmp_path / "six.pbrt").read_text(encoding="utf-8")
    assert float(re.search(r'"float lensradius" (\S+)', text)[1]) == pytest.approx(0.005 * part)
    closed = lb.LensCamera(replace(LENS, blades=6), FILM, 1500.0, 4.0)
    export_camera(closed, "pbrt", tmp_path / "lens.pbrt")
    text = (tmp_path / "lens.pbrt").read_text(encoding="utf-8")
    wide = 2.0 * LENS.stop.semi_diameter * lb.first_order(LENS).f_number / 4.0      # of a round stop at this f-number
    assert float(re.search(r'"float aperturediameter" (\S+)', text)[1]) == pytest.approx(wide)


def test_a_realistic_camera_has_its_lens_beside_it(tmp_path):
    camera = lb.LensCamera(LENS, FILM, 1500.0, 4.0, world_from_camera=WORLD)
    export_camera(camera, "pbrt", tmp_path / "camera.pbrt")
    text = (tmp_path / "camera.pbrt").read_text(encoding="utf-8")
    again = lenses.load(tmp_path / "camera.dat")
    assert '"float focusdistance" 1.5' in text and '"string lensfile" "camera.dat"' in text
    assert float(re.search(r'"float aperturediameter" (\S+)', text)[1]) == 2.0 * camera.lens.stop.semi_diameter
    assert [s.curvature for s in again.surfaces] == pytest.approx([s.curvature for s in camera.lens.surfaces])


@pytest.mark.parametrize("camera, to, message", [
    (lb.FisheyeCamera(FILM), "pbrt", "FisheyeCamera is none"), (lb.BareSensor(FILM), "mitsuba", "BareSensor is none"),
    (CAMERAS["thin"], "povray", "choose one of"), (lb.PerspectiveCamera(FILM, window=(-1, 1, -1, 1)), "pbrt", "window"),
    (lb.PerspectiveCamera(FILM, world_from_camera=lb.AnimatedTransform(np.eye(4), WORLD)), "blender", "moves")])
def test_what_the_other_program_does_not_have_is_refused(camera, to, message, tmp_path):
    with pytest.raises(lb.CameraError, match=message):
        export_camera(camera, to, tmp_path / "camera")


def test_what_a_file_cannot_hold_is_said(tmp_path):
    camera = lb.PerspectiveCamera(lb.Film(36.0, 24.0, 300, 100), 0.7, shutter_close=0.5, shutter_ramp=0.1, readout=0.2,
                                  medium=lb.Medium(1.33))
    remarks = export_camera(camera, "blender", tmp_path / "camera.py")
    for word in ("square pixels", "rolling shutter", "ramps", "frames", "medium"):
        assert sum(word in remark for remark in remarks) == 1
    assert export_camera(lb.PerspectiveCamera(FILM, 0.7, weights="one"), "pbrt", tmp_path / "camera.pbrt") == []


@pytest.mark.parametrize("name, left_out", [
    ("pbrt-dgauss-50mm", ""), ("lentil-schneider-anamorphic-31-2001", "a cylinder or toroid of this one is left out")])
def test_what_a_thin_lens_leaves_out_of_a_real_one_is_said(name, left_out, tmp_path):
    for to in ("mitsuba", "blender"):
        said = " ".join(export_camera(lb.LensCamera(lenses.load(name).at(), FILM), to, tmp_path / "camera"))
        assert "without aberrations and vignetting" in said and left_out in said
        assert ("left out" in said) == bool(left_out)
