"""Exported cameras in other renderers: small lights lie in the pictures of Mitsuba and Blender where they lie in ours.

Each light is alone in a black scene, rendered with few samples; its place is the centroid of its picture. Blender runs
where its module is installed (`pip install bpy`, of the Python that it asks for).
"""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.session.camera_export import Z_UP, export_camera

WORLD = lb.look_at((300.0, 250.0, 900.0), (0.0, 60.0, -1500.0), (0.1, 1.0, 0.0))
WIDE, TALL = lb.Film(36.0, 24.0, 240, 160), lb.Film(24.0, 36.0, 160, 240)
LENS = lenses.load("pbrt-dgauss-50mm")
CAMERAS = {
    "perspective": lb.PerspectiveCamera(WIDE, 0.6, world_from_camera=WORLD),
    "upright": lb.PerspectiveCamera(TALL, 0.6, world_from_camera=WORLD),
    "blurred": lb.PerspectiveCamera(WIDE, 0.6, 30.0, 2400.0, world_from_camera=WORLD),
    "pinhole": lb.LensCamera(LENS, WIDE, 2400.0, 4.0, model="pinhole", world_from_camera=WORLD),
    "thin": lb.LensCamera(LENS, WIDE, 2400.0, model="thin", world_from_camera=WORLD)}
PLACES = ((-60.0, 60.0, -1500.0), (360.0, 320.0, -1500.0), (-480.0, 320.0, -1200.0), (360.0, -200.0, -2100.0))
RADIUS, SAMPLES = 12.0, 64
SHARP, BLURRED = 0.1, 0.2           # pixels: noise of the centroid of 64 samples


def mitsuba(camera, folder, pose):
    """(h, w) radiance of a light at this place."""
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("scalar_rgb")
    export_camera(camera, "mitsuba", folder / "camera.xml")
    x, y, z = (value / 1000.0 for value in pose)
    (folder / "scene.xml").write_text(
        f'<scene version="3.0.0"><integrator type="direct"/><include filename="{folder / "camera.xml"}"/>'
        f'<shape type="sphere"><point name="center" x="{x}" y="{y}" z="{z}"/><float name="radius" '
        f'value="{RADIUS / 1000.0}"/><emitter type="area"><rgb name="radiance" value="1"/></emitter></shape></scene>')
    return np.array(mi.render(mi.load_file(str(folder / "scene.xml")), spp=SAMPLES))[..., 1]


def blender(camera, folder, pose):
    """(h, w) radiance of a light at this place, by Cycles."""
    bpy = pytest.importorskip("bpy")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    export_camera(camera, "blender", folder / "camera.py")
    exec((folder / "camera.py").read_text(encoding="utf-8"), {})
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", SAMPLES
    scene.cycles.use_denoising, scene.render.image_settings.file_format = False, "OPEN_EXR"
    material = bpy.data.materials.new("light")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    material.node_tree.links.new(nodes.new("ShaderNodeEmission").outputs[0],
                                 nodes.new("ShaderNodeOutputMaterial").inputs[0])
    bpy.ops.mesh.primitive_uv_sphere_add(radius=RADIUS / 1000.0, segments=48, ring_count=24,
                                         location=Z_UP[:3, :3] @ pose / 1000.0)
    bpy.context.object.data.materials.append(material)
    scene.render.filepath = str(folder / "picture.exr")
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(scene.render.filepath)
    return np.array(picture.pixels[:]).reshape(camera.film.pixels_y, camera.film.pixels_x, -1)[::-1, :, 1]


def middle(picture):
    """Centroid (x, y) of a picture, pixels."""
    y, x = np.mgrid[:picture.shape[0], :picture.shape[1]] + 0.5
    return np.array([(x * picture).sum(), (y * picture).sum()]) / picture.sum()


@pytest.mark.parametrize("render", [mitsuba, blender])
@pytest.mark.parametrize("name", CAMERAS)
def test_a_light_lies_where_ours_lies(name, render, tmp_path):
    camera, black = CAMERAS[name], (0.0, 0.0, 0.0)
    for pose in PLACES:
        light = lb.Sphere(pose, RADIUS, lb.Material((1.0, 1.0, 1.0), "light"))
        ours = lb.Rendering(camera, lb.Scene("light", lb.Sky(black, black, black), spheres=(light,)),
                            light_tracing=False)
        ours.add(SAMPLES)
        off = middle(render(camera, tmp_path, pose)) - middle(ours.image()[..., 1].astype(float))
        assert math.hypot(*off) < (BLURRED if name in ("blurred", "thin") else SHARP)
