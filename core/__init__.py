"""lensbench: lenses and cameras, their rays and their pictures.

    import lensbench as lb
    from lensbench import lenses

Lengths are millimetres, angles radians, wavelengths micrometres. The lens frame
has its origin at the first vertex and light travels along +z, from the scene to
the film; a camera looks along −z, x to the right and y up.
"""

import hashlib as _hashlib
import os as _os
import tempfile as _tempfile
from pathlib import Path as _Path

import numba as _numba
from llvmlite import binding as _llvm


def _cache_folder() -> str:
    """A folder for compiled kernels, named by every source of the core.

    Numba sees an edit to the file of a function, but neither to what that
    function calls nor to the constants that it uses from elsewhere.
    """
    here = _Path(__file__).parent
    sources = sorted(path for path in here.rglob("*") if path.suffix in (".py", ".npy"))
    name = _hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()[:16]
    try:
        home = _Path(_os.environ.get("XDG_CACHE_HOME") or _Path.home() / ".cache") / "lensbench"
        (home / name).mkdir(parents=True, exist_ok=True)
        if _os.access(home / name, _os.W_OK):
            return str(home / name)
    except (OSError, RuntimeError):                     # nowhere to keep it: compile anew each time
        pass
    return _tempfile.mkdtemp(prefix="lensbench-")


_numba.config.CACHE_DIR = _cache_folder()               # before any kernel is declared
_features = _llvm.get_host_cpu_features()
if _features.get("avx512f") and _numba.config.CPU_FEATURES is None:
    # Compilers hold 512-bit registers back on some processors; these kernels gain a fifth by them.
    _numba.config.CPU_FEATURES = _features.flatten() + ",-prefer-256-bit"

from lensbench.analysis.aberrations import ChiefRay, Seidel, astigmatic_foci, chief_ray, seidel  # noqa: E402
from lensbench.analysis.distortion import Distortion, distortion, distortion_grid  # noqa: E402
from lensbench.analysis.falloff import Falloff, falloff  # noqa: E402
from lensbench.analysis.model_choice import Choice, choose_model  # noqa: E402
from lensbench.analysis.vignetting import Vignetting, vignetting  # noqa: E402
from lensbench.cameras.bare_sensor import BareSensor  # noqa: E402
from lensbench.cameras.base import Camera  # noqa: E402
from lensbench.cameras.differentials import Differentials  # noqa: E402
from lensbench.cameras.environment import EnvironmentCamera  # noqa: E402
from lensbench.cameras.finite_pinhole import PinholeCamera, best_pinhole  # noqa: E402
from lensbench.cameras.fisheye import FisheyeCamera  # noqa: E402
from lensbench.cameras.importance import Importance  # noqa: E402
from lensbench.cameras.orthographic import OrthographicCamera  # noqa: E402
from lensbench.cameras.perspective import PerspectiveCamera  # noqa: E402
from lensbench.cameras.rays import CameraError, Rays  # noqa: E402
from lensbench.cameras.real_lens import LensCamera  # noqa: E402
from lensbench.imaging.animated_transform import AnimatedTransform  # noqa: E402
from lensbench.imaging.coordinate_spaces import Intrinsics, Places, Spaces, depth_resolution  # noqa: E402
from lensbench.imaging.exposure import (  # noqa: E402
    Exposure,
    ExposureError,
    ev100,
    irradiance,
    luminance,
    metered_stops,
    pixel_energy,
    radiant_exposure,
)
from lensbench.imaging.field_of_view import Equivalent, equivalent, field_of_view, film_extent, focal_length  # noqa: E402
from lensbench.imaging.film import FORMATS, Film, FilmError  # noqa: E402
from lensbench.imaging.sensor import Sensor  # noqa: E402
from lensbench.imaging.transform import TransformError, look_at  # noqa: E402
from lensbench.lightfields.capture import capture_light_field, picture_through  # noqa: E402
from lensbench.lightfields.depth import Depth, find_depth  # noqa: E402
from lensbench.lightfields.light_field import LightField, LightFieldError, light_field_bytes  # noqa: E402
from lensbench.lightfields.lumigraph import Lumigraph, NovelView, array_camera, capture_lumigraph, lumigraph_pinhole  # noqa: E402
from lensbench.lightfields.plenoptic import PlenopticCamera, RawPicture  # noqa: E402
from lensbench.optics.depth_of_field import (  # noqa: E402
    circle_of_confusion,
    depth_of_field,
    hyperfocal,
    real_circle_of_confusion,
    thick_circle_of_confusion,
)
from lensbench.optics.focus import FocusError, film_distance, focused, focused_distance, nearest_focus, section_foci  # noqa: E402
from lensbench.optics.glass import AIR, C_LINE, D_LINE, F_LINE, Glass, GlassError  # noqa: E402
from lensbench.optics.iris import Iris, IrisError  # noqa: E402
from lensbench.optics.paraxial import FirstOrder, first_order, stopped_down  # noqa: E402
from lensbench.optics.prescription import Lens, LensError, Surface  # noqa: E402
from lensbench.optics.scalar_trace import Fate, Trace, trace  # noqa: E402
from lensbench.optics.transmission import t_number, transmission, working_f_number  # noqa: E402
from lensbench.optics.zoom_positions import Positions, PositionsError  # noqa: E402
from lensbench.pupils.region import ExitPupil, exit_pupil, open_region  # noqa: E402
from lensbench.rendering.aovs import AOVS as VIEWS  # noqa: E402
from lensbench.rendering.aovs import fate_colours  # noqa: E402
from lensbench.rendering.progressive import Rendering, depth_map, render  # noqa: E402
from lensbench.scenery.builtin.library import SCENES, builtin_scene  # noqa: E402
from lensbench.scenery.objects import (  # noqa: E402
    Disk,
    Floor,
    Image,
    Material,
    Pattern,
    Rectangle,
    SceneError,
    Sky,
    Sphere,
    Sun,
)
from lensbench.scenery.scene import Scene  # noqa: E402
from lensbench.scenery.shading.participating_medium import Medium, MediumError  # noqa: E402

__all__ = [
    "AIR", "C_LINE", "D_LINE", "FORMATS", "F_LINE", "SCENES", "VIEWS", "AnimatedTransform", "BareSensor", "Camera",
    "CameraError", "ChiefRay", "Choice", "Depth", "Differentials", "Disk", "Distortion", "EnvironmentCamera",
    "Equivalent", "ExitPupil",
    "Exposure", "ExposureError", "Falloff", "Fate", "Film", "FilmError", "FirstOrder", "FisheyeCamera", "Floor",
    "FocusError", "Glass", "GlassError", "Image", "Importance", "Intrinsics", "Iris", "IrisError", "Lens", "LensCamera",
    "LensError", "LightField", "LightFieldError", "Lumigraph",
    "Material", "Medium", "MediumError", "NovelView", "OrthographicCamera", "Pattern",
    "PerspectiveCamera", "PinholeCamera", "Places", "PlenopticCamera", "Positions", "PositionsError", "RawPicture",
    "Rays", "Rectangle", "Rendering",
    "Scene", "SceneError", "Seidel", "Sensor", "Sky", "Spaces", "Sphere", "Sun", "Surface", "Trace", "TransformError",
    "Vignetting", "array_camera", "astigmatic_foci", "best_pinhole", "builtin_scene", "capture_light_field",
    "capture_lumigraph", "chief_ray",
    "choose_model", "circle_of_confusion", "depth_map", "depth_of_field", "depth_resolution", "distortion",
    "distortion_grid", "equivalent", "ev100", "exit_pupil", "falloff", "fate_colours", "field_of_view", "film_distance",
    "film_extent", "find_depth", "first_order", "focal_length", "focused", "focused_distance", "hyperfocal",
    "irradiance", "light_field_bytes", "look_at", "lumigraph_pinhole", "luminance", "metered_stops", "nearest_focus",
    "open_region",
    "picture_through",
    "pixel_energy", "radiant_exposure", "real_circle_of_confusion", "render", "section_foci", "seidel", "stopped_down",
    "t_number", "thick_circle_of_confusion", "trace", "transmission", "vignetting", "working_f_number",
]
