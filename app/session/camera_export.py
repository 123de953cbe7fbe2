"""Cameras as files of other renderers: pbrt-v4, Mitsuba 3 and Blender.

All lengths become metres. pbrt looks along +z with x to the right, Mitsuba along +z with x to the left, Blender as
lensbench along −z; y is up in their cameras. The world keeps its axes in pbrt and Mitsuba. In Blender z is up: our y
becomes its z, and our z its −y, as in Blender's own import of glTF and OBJ.
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.core.text import significant

PROGRAMS = {"pbrt": ".pbrt", "mitsuba": ".xml", "blender": ".py"}       # and the suffix of their files
FAR = 1e6                       # m: instead of infinity
Z_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


class _Ideal(NamedTuple):
    """A thin lens or a pinhole, lengths in mm."""

    z: float                    # of the lens, camera frame
    image_distance: float
    radius: float
    focus_distance: float       # from the lens


def export_camera(camera: lb.Camera, to: str, path: str | Path) -> list[str]:
    """Write a camera for another renderer, and return what that program cannot hold.

    camera: a LensCamera, a PerspectiveCamera or, for pbrt, an OrthographicCamera, at rest and without a window. to: a
    key of PROGRAMS. path: the file; for pbrt the lens is written next to it, with the suffix .dat. CameraError for a
    camera that the other program does not have; LensFileError or OSError for files that cannot be written.
    """
    path = Path(path)
    if to not in PROGRAMS:
        raise lb.CameraError(f"export to {to!r}: choose one of {', '.join(PROGRAMS)}")
    if isinstance(camera.world_from_camera, lb.AnimatedTransform):
        raise lb.CameraError("a camera that moves is not exported: choose a time at which it is at rest")
    if getattr(camera, "window", None) is not None:
        raise lb.CameraError("a camera with a window is not exported: leave the window out")
    remarks = _left_out(camera, to)
    text = {"pbrt": _pbrt, "mitsuba": _mitsuba, "blender": _blender}[to](camera, path, remarks)
    path.write_text(text, encoding="utf-8")
    return remarks


def _left_out(camera: lb.Camera, to: str) -> list[str]:
    """What no camera of another program holds, or not this one's."""
    film, notes = camera.film, []
    pixel = film.width / film.pixels_x / (film.height / film.pixels_y)
    if not math.isclose(pixel, 1.0, rel_tol=1e-3):
        notes.append(f"{to} gets square pixels: these are {significant(pixel, 4)} times as wide as high, and "
                     "the picture has another height")
    if not camera.film_pose.is_upright:
        notes.append(f"{to} has a flat, centred film: tilt, swing, rise, shift and curvature are left out")
    if camera.readout > 0.0:
        notes.append(f"{to} has no rolling shutter: all rows open at once")
    if camera.shutter_ramp > 0.0:
        notes.append(f"{to} opens and closes its shutter at once: the ramps are left out")
    if to == "blender" and (camera.shutter_open, camera.shutter_close) != (0.0, 1.0):
        notes.append("blender has its shutter in frames: the time of the exposure is left out")
    if camera.weights != "radiance" and not isinstance(camera, lb.OrthographicCamera) and not (
            to == "pbrt" and isinstance(camera, lb.LensCamera)):
        notes.append(f"{to} weighs all rays of this camera equally: its picture does not fall off towards the corners "
                     "(cos⁴)")
    as_lens = to == "pbrt" and isinstance(camera, lb.LensCamera)        # the lens file names what it leaves out
    if not as_lens and isinstance(camera, lb.LensCamera | lb.PerspectiveCamera) and not camera.gaussian.iris.is_round:
        notes.append(f"{to} gets a round aperture: the blades, or the picture in the stop, are left out")
    if camera.medium is not None and not (camera.medium.is_clear and camera.medium.index == 1.0):
        notes.append(f"{to} looks through clear air: the medium of the camera is left out")
    return notes


def _pose(camera: lb.Camera, axes: tuple[float, float, float], z: float = 0.0) -> np.ndarray:
    """World from the other program's camera (4, 4), in metres; z: of its origin in the camera frame (mm)."""
    pose = np.array(camera.placement())
    scale = np.cbrt(np.linalg.det(pose[:3, :3]))
    if not math.isclose(scale, 1.0, rel_tol=1e-9):
        raise lb.CameraError("a camera with a scale is not exported: give it a rigid transform")
    pose[:3, 3] = (pose[:3, 3] + pose[:3, 2] * z) / 1000.0
    return pose @ np.diag([*axes, 1.0])


def _ideal(camera: lb.Camera, to: str, remarks: list[str]) -> _Ideal:
    """The thin lens or pinhole of a camera; a real lens is replaced by its ideal model, and this is remarked."""
    if isinstance(camera, lb.PerspectiveCamera):
        return _Ideal(0.0, camera.film_distance, camera.lens_radius * camera.iris.equivalent_radius,
                      camera.focus_distance)
    if not isinstance(camera, lb.LensCamera):
        raise lb.CameraError(f"{to} gets cameras with a lens or a perspective: {type(camera).__name__} is none")
    if camera.model != "pinhole":
        remarks.append(f"{to} has no prescriptions: the lens is written as a thin lens, without aberrations and "
                       "vignetting")
    if camera.lens.asymmetry:
        remarks.append(f"{to} has a round, centred lens: {camera.lens.asymmetry} of this one is left out")
    lens = camera.ideal("pinhole" if camera.model == "pinhole" else "thin")
    return _Ideal(lens.z, -1.0 / lens.slope_film, lens.origin_pupil * lens.iris.equivalent_radius,
                  camera.focus_distance + lens.z)


def _pbrt(camera: lb.Camera, path: Path, remarks: list[str]) -> str:
    film = camera.film
    # pbrt's matrix takes points of the world to its camera, by columns
    matrix = np.linalg.inv(_pose(camera, (1.0, 1.0, -1.0)))
    shutter = f'"float shutteropen" {camera.shutter_open!r} "float shutterclose" {camera.shutter_close!r}'
    note, radius = "", 0.0
    if isinstance(camera, lb.PerspectiveCamera | lb.OrthographicCamera):
        radius = camera.lens_radius * camera.gaussian.iris.equivalent_radius
    if isinstance(camera, lb.LensCamera):
        lens_path = path.with_suffix(".dat")
        remarks += [str(finding) for finding in lenses.save(camera.lens, lens_path)]
        focus = _far(camera.focus_distance)
        note = (f"# film distance {significant(camera.film_distance)} mm behind the last vertex; pbrt finds it from "
                "the focus distance\n")
        kind = (f'Camera "realistic" "string lensfile" "{lens_path.name}" "float focusdistance" {focus!r} '
                f'"float aperturediameter" {2.0 * camera.lens.equivalent_stop_radius!r} {shutter}')
    elif isinstance(camera, lb.PerspectiveCamera):
        fov = math.degrees(2.0 * math.atan(0.5 * min(film.width, film.height) / camera.film_distance))
        kind = (f'Camera "perspective" "float fov" {fov!r} "float lensradius" {radius / 1000.0!r} '
                f'"float focaldistance" {_far(camera.focus_distance)!r} {shutter}')
    elif isinstance(camera, lb.OrthographicCamera):
        half = camera.width / 2000.0
        high = half * film.height / film.width
        kind = (f'Camera "orthographic" "float screenwindow" [ {-half!r} {half!r} {-high!r} {high!r} ] '
                f'"float lensradius" {radius / 1000.0!r} '
                f'"float focaldistance" {_far(camera.focus_distance)!r} {shutter}')
    else:
        raise lb.CameraError(f"pbrt gets cameras with a lens, perspective and orthographic ones: "
                             f"{type(camera).__name__} is none")
    numbers = " ".join(repr(float(value)) for value in matrix.T.ravel())
    return (f"# lensbench, for pbrt-v4: metres, right-handed world\n{note}Transform [ {numbers} ]\n{kind}\n"
            f'Film "rgb" "integer xresolution" {film.pixels_x} "integer yresolution" {film.pixels_y} '
            f'"float diagonal" {film.diagonal!r}\n')


def _mitsuba(camera: lb.Camera, path: Path, remarks: list[str]) -> str:
    film, lens = camera.film, _ideal(camera, "mitsuba", remarks)
    fov = math.degrees(2.0 * math.atan(0.5 * film.width / lens.image_distance))
    numbers = " ".join(repr(float(value)) for value in _pose(camera, (-1.0, 1.0, -1.0), lens.z).ravel())
    blur = "" if lens.radius == 0.0 else (
        f'    <float name="aperture_radius" value="{lens.radius / 1000.0!r}"/>\n'
        f'    <float name="focus_distance" value="{_far(lens.focus_distance)!r}"/>\n')
    return (f'<!-- lensbench, for Mitsuba 3: metres -->\n<sensor type="{"thinlens" if blur else "perspective"}" '
            f'version="3.0.0">\n    <transform name="to_world"><matrix value="{numbers}"/></transform>\n'
            f'    <string name="fov_axis" value="x"/>\n    <float name="fov" value="{fov!r}"/>\n{blur}'
            f'    <float name="shutter_open" value="{camera.shutter_open!r}"/>\n'
            f'    <float name="shutter_close" value="{camera.shutter_close!r}"/>\n'
            f'    <film type="hdrfilm">\n        <integer name="width" value="{film.pixels_x}"/>\n'
            f'        <integer name="height" value="{film.pixels_y}"/>\n    </film>\n</sensor>\n')


def _blender(camera: lb.Camera, path: Path, remarks: list[str]) -> str:
    film, lens = camera.film, _ideal(camera, "blender", remarks)
    pose = Z_UP @ _pose(camera, (1.0, 1.0, 1.0), lens.z)
    rows = ", ".join(repr(tuple(float(value) for value in row)) for row in pose)
    blur = "data.dof.use_dof = False" if lens.radius == 0.0 else (
        f"data.dof.use_dof = True\ndata.dof.focus_distance = {_far(lens.focus_distance)!r}      # m\n"
        f"data.dof.aperture_fstop = {lens.image_distance / (2.0 * lens.radius)!r}")
    return (f'"""lensbench, for Blender: run in its text editor; metres, z up."""\n'
            f'import bpy\nfrom mathutils import Matrix\n\n'
            f'data = bpy.data.cameras.new("lensbench")\ndata.sensor_fit = "HORIZONTAL"\n'
            f'data.sensor_width, data.sensor_height = {film.width!r}, {film.height!r}      # mm\n'
            f'data.lens = {lens.image_distance!r}      # mm\n{blur}\n'
            f'camera = bpy.data.objects.new("lensbench", data)\ncamera.matrix_world = Matrix(({rows}))\n'
            f'bpy.context.collection.objects.link(camera)\nscene = bpy.context.scene\nscene.camera = camera\n'
            f'scene.render.resolution_x, scene.render.resolution_y = {film.pixels_x}, {film.pixels_y}\n'
            f'scene.render.resolution_percentage = 100\n')


def _far(distance: float) -> float:
    """A distance (mm) in metres; a great one instead of infinity."""
    return min(distance / 1000.0, FAR)
