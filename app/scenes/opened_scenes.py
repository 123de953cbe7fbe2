"""Scenes around files of the user: a mesh on a floor, objects under a picture of the sky, a photograph with its depth.

Each function returns the table of a scene file, which names the file by its whole path; `scene_writer.own_scene` writes
it. Lengths in mm, angles in degrees, as in scene files.
"""

import math
from functools import lru_cache
from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.scenes.asset_files import Stamp, file_stamp
from lensbench.app.scenes.mesh_file import MM, Pose, read_mesh, rotation
from lensbench.app.scenes.photograph import carries_depth, read_phone_photograph, stated_fov
from lensbench.app.scenes.scene_writer import scene_table
from lensbench.app.scenes.sky_picture import read_sky
from lensbench.app.scenes.table_values import Table
from lensbench.lenses.picture_file import read_picture_file

UNKNOWN = 300.0                     # mm: the height of a mesh whose file has no unit, or an unlikely one
LIKELY = 20.0, 20_000.0             # mm: heights of a file in metres that are believed
FLAT = 1e-3                         # of the longer side: a lower mesh has no height to stand on
STANDS_BACK = 1.2                   # of the larger side of what is framed: the part of the film's height that it fills
AWAY = 2.6                          # heights of the frame between the origin and the subject
ROUND = 0.92                        # mean cosine between triangles and smooth normals, above which they are smoothed
WIDER = 1.5                         # width of the film in its heights
AXES = {"y": [0.0, 0.0, 0.0], "z": [-90.0, 0.0, 0.0], "x": [0.0, 0.0, 90.0], "-y": [180.0, 0.0, 0.0],
        "-z": [90.0, 0.0, 0.0]}     # the axis of the file that points up, and the rotation that makes it the world's y
LIGHT: Table = {
    "ambient": [0.02, 0.02, 0.024], "exposure": 0.7,
    "sky": {"zenith": [0.20, 0.23, 0.28], "horizon": [0.36, 0.38, 0.41], "ground": [0.14, 0.13, 0.12]},
}


def turned(up: str, turn: float) -> list[float]:
    """Rotation of a mesh file (degrees about x, y, z) whose axis `up` points up, turned about the world's y."""
    x, _, z = AXES[up]
    return [turn, 0.0, z] if up == "x" else [x, turn, z]


def standing(rotated: list[float]) -> tuple[str, float]:
    """The axis and the turn of a rotation by `turned`."""
    x, y, z = rotated
    if z == 90.0:
        return "x", x
    return next((up for up, (about, _, last) in AXES.items() if about == x and last == z), "y"), y


def _is_round(meshes: list[lb.Mesh]) -> bool:
    """Whether the triangles of smoothed meshes lie close to their smooth normals: a scan, not a box."""
    total = close = 0.0
    for mesh in meshes:
        a, b, c = mesh.points[mesh.triangles].astype(float).swapaxes(0, 1)
        across = np.cross(b - a, c - a)
        normals = np.frombuffer(mesh.normals, np.float32).reshape(-1, 3)[mesh.triangles[:, 0]]
        total += float(np.linalg.norm(across, axis=1).sum())
        close += float(np.abs((across * normals).sum(1)).sum())
    return close > ROUND * total


MATERIALS: dict[str, Table] = {     # of a mesh, instead of those of its file, by kind
    "": {}, "matte": {"colour": [0.55, 0.42, 0.32]}, "coat": {"colour": [0.55, 0.05, 0.04], "gloss": 0.95},
    "metal": {"colour": [0.9, 0.78, 0.5]}, "glass": {"colour": [1.0, 1.0, 1.0]}}


def mesh_table(path: Path, height: float | None = None, up: str = "y", turn: float = 0.0, material: str = "") -> Table:
    """A mesh that stands on a floor under a bright sky, lit from the left; SceneError where it cannot be read.

    height: mm; None: that of a file in metres, where it is likely, else UNKNOWN. up: its axis that points up, unless
    the mesh is flat along it. material: one of MATERIALS; "" for those of the file.
    """
    kind = path.suffix[1:].lower()
    for axis in (up, "z", "x"):                         # a flat one stands upright
        meshes = read_mesh(path.name, path.parent, Pose(rotation(*np.radians(turned(axis, turn))), None, None,
                                                        (0.0, 0.0, 0.0)), None, True)
        points = np.concatenate([mesh.points for mesh in meshes])
        width, own, depth = (float(side) for side in points.max(0) - points.min(0))
        if own > FLAT * max(width, depth):
            break
    else:
        raise lb.SceneError(f"{path.name}: all its points lie in one place")
    if height is None:
        height = own if MM[kind] > 1.0 and LIKELY[0] <= own <= LIKELY[1] else UNKNOWN
    height = float(f"{height:.3g}")
    width, depth = width * height / own, depth * height / own
    frame = float(f"{STANDS_BACK * max(height, (width + 0.5 * depth) / WIDER):.3g}")
    distance = float(f"{AWAY * frame + 0.5 * depth:.3g}")
    lamp = 1.2 * frame
    return {
        "name": path.stem, **LIGHT, "subject": [distance, frame],
        "depth_range": [0.4 * distance, 4.0 * distance],
        "floor": {"height": -0.5 * height, "light": [0.42, 0.42, 0.43], "dark": [0.42, 0.42, 0.43]},
        "mesh": [{"file": str(path), "height": height, "rotation": turned(axis, turn),
                  "foot": [0.0, -0.5 * height, -float(f"{distance + 0.3 * depth:.4g}")], "smooth": _is_round(meshes),
                  **({"material": {"kind": material, **MATERIALS[material]}} if material else {})}],
        "rectangle": [{"centre": [-1.6 * frame, 1.5 * frame, 1.6 * frame - distance], "target": [0.0, 0.0, -distance],
                       "width": lamp, "height": lamp, "material": {"kind": "lamp", "colour": [9.0, 8.6, 8.0]}}],
    }


USUAL_FOV = 60.0                    # degrees across a photograph that does not state its own
BALLS: list[Table] = [
    {"centre": [x, 0.0, -1500.0], "radius": 100.0, "material": {"kind": kind, "colour": colour}}
    for x, kind, colour in ((-230.0, "metal", [0.93, 0.93, 0.94]), (0.0, "coat", [0.62, 0.05, 0.03]),
                            (230.0, "glass", [1.0, 1.0, 1.0]))]


def metered(path: Path) -> float:
    """Stops by which a picture of the sky lights a white floor above a radiance of 1; SceneError."""
    return _metered(path, file_stamp(path))


@lru_cache(maxsize=4)
def _metered(path: Path, stamp: Stamp) -> float:
    values = read_sky(path.name, path.parent, lambda _: None).values
    sines = np.cos(math.pi * (np.arange(len(values)) + 0.5) / len(values))
    weights = np.maximum(sines, 0.0) * np.sqrt(1.0 - sines**2)
    mean = float(np.average(values.mean((1, 2), dtype=np.float64), weights=weights))
    return float(f"{math.log2(max(mean, 1e-4)):.2g}")


def sky_table(path: Path, base: str = "", turn: float = 0.0, brightness: float = 1.0) -> Table:
    """What stands in the scene `base`, or balls without one, under a picture of all directions, which alone lights it.

    SceneFileError, OSError where the base cannot be read.
    """
    sky = {"image": str(path), "turn": turn, "brightness": brightness}
    light = {"sky": sky, "exposure": -metered(path)}
    if base:
        unlit = {key: value for key, value in scene_table(base).items() if key not in ("sun", "ambient", "enclosed")}
        under = str(unlit.get("name", Path(base).stem)).split(" under ")[0]
        return {**unlit, "name": f"{under} under {path.stem}", **light}
    return {"name": path.stem, **light, "subject": [1500.0, 480.0], "depth_range": [600.0, 6000.0],
            "floor": {"height": -100.0, "light": [0.35, 0.34, 0.33], "dark": [0.35, 0.34, 0.33]}, "sphere": BALLS}


def is_balls(table: Table) -> bool:
    """Whether the objects of a scene are the balls of `sky_table`."""
    return table.get("sphere") == BALLS


def photograph_table(image: Path, fov: float | None, depth: str = "", near: float = 1000.0, far: float = 10_000.0,
                     depth_is: str = "disparity") -> Table:
    """A photograph with the depth map of a second file, whose least and greatest distance (mm) are near and far, unless
    it holds metres (OpenEXR); or, without one, with that of its own file.

    fov: degrees across; None: as the file states, else USUAL_FOV.
    """
    entry: Table = {"image": str(image), "fov": fov or photograph_fov(image) or USUAL_FOV}
    if depth:
        entry |= {"depth": depth, "depth_is": depth_is}
        if not is_metric(depth):
            entry |= {"near": near, "far": far}
    return {"name": image.stem, "photograph": entry}


def is_metric(depth: str) -> bool:
    """Whether a depth map may hold metres: OpenEXR."""
    return depth.lower().endswith(".exr")


def photograph_fov(image: Path) -> float | None:
    """Degrees across a photograph, by the focal length on 35 mm film that it states; None without one."""
    try:
        if carries_depth(image):
            fov = read_phone_photograph(image.name, image.parent).fov
        else:
            picture = read_picture_file(image)
            fov = stated_fov(picture.getexif(), picture.size, picture.width)
    except (ValueError, OSError):           # reading its scene states the reason
        return None
    return None if fov is None else float(f"{math.degrees(fov):.4g}")
