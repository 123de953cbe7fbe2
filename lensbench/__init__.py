"""lensbench: lenses and cameras, their rays and their pictures.

    import lensbench as lb
    from lensbench import lenses

Lengths are millimetres, angles radians, wavelengths micrometres. The lens frame
has its origin at the first vertex and light travels along +z, from the scene to
the film; a camera looks along −z, x to the right and y up.

Each name is imported when it is first used: `import lensbench` alone loads neither numpy nor numba.

The first kernel has two effects on numba. lensbench's kernels, and no other functions, are cached in
$XDG_CACHE_HOME/lensbench/kernels (by default ~/.cache/lensbench/kernels). On x86-64 all code that this process compiles
is made for a level of that architecture, v3 or v4, in place of the exact processor; LENSBENCH_NATIVE=1 in the
environment leaves numba's setting as it is. See `core.kernels.cache`.
"""

from typing import TYPE_CHECKING

from lensbench.core.lazy import lazy_names

if TYPE_CHECKING:
    from lensbench.app.notebook.picture import Picture, develop, save
    from lensbench.app.notebook.render import load_scene, render
    from lensbench.app.notebook.show import show
    from lensbench.core import analysis
    from lensbench.core.analysis.aberrations import ChiefRay, Seidel, astigmatic_foci, chief_ray, seidel
    from lensbench.core.analysis.distortion import Distortion, distortion, distortion_grid
    from lensbench.core.analysis.model_choice import Choice, choose_model
    from lensbench.core.analysis.vignetting import Falloff, Vignetting, falloff, vignetting
    from lensbench.core.cameras.bare_sensor import BareSensor
    from lensbench.core.cameras.base import Camera
    from lensbench.core.cameras.custom import CustomCamera
    from lensbench.core.cameras.environment import EnvironmentCamera
    from lensbench.core.cameras.film_landing import Importance
    from lensbench.core.cameras.finite_pinhole import PinholeCamera, best_pinhole
    from lensbench.core.cameras.fisheye import FisheyeCamera
    from lensbench.core.cameras.orthographic import OrthographicCamera
    from lensbench.core.cameras.perspective import PerspectiveCamera
    from lensbench.core.cameras.ray_generation import Differentials
    from lensbench.core.cameras.rays import CameraError, Rays
    from lensbench.core.cameras.real_lens import LensCamera
    from lensbench.core.design.goal import Goal
    from lensbench.core.design.improve import Improvement, improve
    from lensbench.core.design.merit import Judgement, judge
    from lensbench.core.design.standard_goal import goal_of
    from lensbench.core.imaging.coordinate_spaces import Intrinsics, Places, Spaces, depth_resolution
    from lensbench.core.imaging.exposure import (
        Exposure, ExposureError, ev100, irradiance, luminance, metered_stops, pixel_energy, radiant_exposure
    )
    from lensbench.core.imaging.field_of_view import Equivalent, equivalent, field_of_view, film_extent, focal_length
    from lensbench.core.imaging.film import FORMATS, Film, FilmError, FilmPose
    from lensbench.core.imaging.sensor import Sensor
    from lensbench.core.imaging.transform import AnimatedTransform, TransformError, look_at
    from lensbench.core.kernels.sampling import unit_disk, unit_square
    from lensbench.core.lightfields.capture import (
        capture_light_field, light_field_bytes, picture_through, recording_bytes
    )
    from lensbench.core.lightfields.depth import Depth, find_depth
    from lensbench.core.lightfields.light_field import LightField, LightFieldError
    from lensbench.core.lightfields.lumigraph import (
        Lumigraph, NovelView, array_camera, capture_lumigraph, lumigraph_pinhole
    )
    from lensbench.core.lightfields.plenoptic import PlenopticCamera, RawPicture
    from lensbench.core.optics.coatings import COATINGS, Coating, CoatingError, Layer, Reflectance
    from lensbench.core.optics.depth_of_field import (
        circle_of_confusion, depth_of_field, hyperfocal, magnification, real_circle_of_confusion, section_foci,
        thick_circle_of_confusion, thick_depth_of_field, thick_hyperfocal
    )
    from lensbench.core.optics.focus import (
        FocusError, best_focus, film_distance, focused, focused_distance, nearest_focus
    )
    from lensbench.core.optics.glass import AIR, C_LINE, D_LINE, F_LINE, Glass, GlassError
    from lensbench.core.optics.iris import Iris, IrisError
    from lensbench.core.optics.lens_surface import LensError, PoseError, Surface, SurfacePose
    from lensbench.core.optics.paraxial import FirstOrder, f_number_at_infinity, first_order, stopped_down
    from lensbench.core.optics.prescription import Lens
    from lensbench.core.optics.scalar_trace import Fate, Trace, trace
    from lensbench.core.optics.stop_image import StopImage, StopImageError
    from lensbench.core.optics.system import (
        Aperture, ApertureKind, FieldKind, FieldPoint, SystemData, SystemDataError, Wavelength
    )
    from lensbench.core.optics.transmission import t_number, transmission, working_f_number
    from lensbench.core.optics.zoom_positions import Positions, PositionsError
    from lensbench.core.pupils.region import ExitPupil, exit_pupil, open_region
    from lensbench.core.rendering.aovs import AOVS as VIEWS, depth_map, fate_colours
    from lensbench.core.rendering.ghost_image import Flare, why_no_ghosts
    from lensbench.core.rendering.progressive import Rendering
    from lensbench.core.scenery.builtin.library import SCENES, builtin_scene
    from lensbench.core.scenery.objects.material import Image, Material, Pattern
    from lensbench.core.scenery.objects.mesh import Mesh
    from lensbench.core.scenery.objects.planar import Disk, Rectangle
    from lensbench.core.scenery.objects.sphere import Sphere
    from lensbench.core.scenery.objects.surroundings import Floor, ImageSky, Sky, Sun
    from lensbench.core.scenery.photograph import photograph_scene
    from lensbench.core.scenery.scene import Scene
    from lensbench.core.scenery.shading.participating_medium import Medium, MediumError
    from lensbench.core.scenery.values import SceneError

_HOMES = {           # the imports above, as they are made at run time
    "app.notebook.picture": "Picture develop save",
    "app.notebook.render": "load_scene render",
    "app.notebook.show": "show",
    "core.analysis": "",
    "core.analysis.aberrations": "ChiefRay Seidel astigmatic_foci chief_ray seidel",
    "core.analysis.distortion": "Distortion distortion distortion_grid",
    "core.analysis.model_choice": "Choice choose_model",
    "core.analysis.vignetting": "Falloff falloff Vignetting vignetting",
    "core.cameras.bare_sensor": "BareSensor",
    "core.cameras.base": "Camera",
    "core.cameras.custom": "CustomCamera",
    "core.cameras.environment": "EnvironmentCamera",
    "core.cameras.film_landing": "Importance",
    "core.cameras.finite_pinhole": "PinholeCamera best_pinhole",
    "core.cameras.fisheye": "FisheyeCamera",
    "core.cameras.orthographic": "OrthographicCamera",
    "core.cameras.perspective": "PerspectiveCamera",
    "core.cameras.ray_generation": "Differentials",
    "core.cameras.rays": "CameraError Rays",
    "core.cameras.real_lens": "LensCamera",
    "core.design.goal": "Goal",
    "core.design.improve": "Improvement improve",
    "core.design.merit": "Judgement judge",
    "core.design.standard_goal": "goal_of",
    "core.imaging.coordinate_spaces": "Intrinsics Places Spaces depth_resolution",
    "core.imaging.exposure": "Exposure ExposureError ev100 irradiance luminance metered_stops pixel_energy "
        "radiant_exposure",
    "core.imaging.field_of_view": "Equivalent equivalent field_of_view film_extent focal_length",
    "core.imaging.film": "FORMATS Film FilmError FilmPose",
    "core.imaging.sensor": "Sensor",
    "core.imaging.transform": "AnimatedTransform TransformError look_at",
    "core.kernels.sampling": "unit_disk unit_square",
    "core.lightfields.capture": "capture_light_field light_field_bytes picture_through recording_bytes",
    "core.lightfields.depth": "Depth find_depth",
    "core.lightfields.light_field": "LightField LightFieldError",
    "core.lightfields.lumigraph": "Lumigraph NovelView array_camera capture_lumigraph lumigraph_pinhole",
    "core.lightfields.plenoptic": "PlenopticCamera RawPicture",
    "core.optics.coatings": "COATINGS Coating CoatingError Layer Reflectance",
    "core.optics.depth_of_field": "circle_of_confusion depth_of_field hyperfocal real_circle_of_confusion "
        "magnification section_foci thick_circle_of_confusion thick_depth_of_field thick_hyperfocal",
    "core.optics.focus": "FocusError best_focus film_distance focused focused_distance nearest_focus",
    "core.optics.glass": "AIR C_LINE D_LINE F_LINE Glass GlassError",
    "core.optics.iris": "Iris IrisError",
    "core.optics.lens_surface": "LensError Surface PoseError SurfacePose",
    "core.optics.paraxial": "FirstOrder f_number_at_infinity first_order stopped_down",
    "core.optics.prescription": "Lens",
    "core.optics.scalar_trace": "Fate Trace trace",
    "core.optics.stop_image": "StopImage StopImageError",
    "core.optics.system": "Aperture ApertureKind FieldKind FieldPoint SystemData SystemDataError Wavelength",
    "core.optics.transmission": "t_number transmission working_f_number",
    "core.optics.zoom_positions": "Positions PositionsError",
    "core.pupils.region": "ExitPupil exit_pupil open_region",
    "core.rendering.aovs": "VIEWS=AOVS fate_colours depth_map",
    "core.rendering.ghost_image": "Flare why_no_ghosts",
    "core.rendering.progressive": "Rendering",
    "core.scenery.builtin.library": "SCENES builtin_scene",
    "core.scenery.objects.material": "Image Material Pattern",
    "core.scenery.objects.mesh": "Mesh",
    "core.scenery.objects.planar": "Disk Rectangle",
    "core.scenery.objects.sphere": "Sphere",
    "core.scenery.objects.surroundings": "Floor ImageSky Sky Sun",
    "core.scenery.photograph": "photograph_scene",
    "core.scenery.scene": "Scene",
    "core.scenery.shading.participating_medium": "Medium MediumError",
    "core.scenery.values": "SceneError",
}
__getattr__, __dir__ = lazy_names(__name__, _HOMES)

__all__ = [
    "AIR", "COATINGS", "C_LINE", "D_LINE", "FORMATS", "F_LINE", "SCENES", "VIEWS", "AnimatedTransform", "Aperture",
    "ApertureKind", "BareSensor", "Camera", "CameraError", "ChiefRay", "Choice", "Coating", "CoatingError",
    "CustomCamera", "Depth", "Differentials", "Disk", "Distortion", "EnvironmentCamera", "Equivalent", "ExitPupil",
    "Exposure", "ExposureError", "Falloff", "Fate", "FieldKind", "FieldPoint", "Film", "FilmError", "FilmPose",
    "FirstOrder", "FisheyeCamera", "Flare", "Floor", "FocusError", "Glass", "GlassError", "Goal", "Image", "ImageSky",
    "Importance", "Improvement", "Intrinsics", "Iris", "IrisError", "Judgement", "Layer", "Lens", "LensCamera",
    "LensError", "LightField", "LightFieldError", "Lumigraph", "Material", "Medium", "MediumError", "Mesh",
    "NovelView", "OrthographicCamera", "Pattern", "PerspectiveCamera", "Picture", "PinholeCamera", "Places",
    "PlenopticCamera", "PoseError", "Positions", "PositionsError", "RawPicture", "Rays", "Rectangle", "Reflectance",
    "Rendering", "Scene", "SceneError", "Seidel", "Sensor", "Sky", "Spaces", "Sphere", "StopImage", "StopImageError",
    "Sun", "Surface", "SurfacePose", "SystemData", "SystemDataError", "Trace", "TransformError", "Vignetting",
    "Wavelength", "analysis", "array_camera", "astigmatic_foci", "best_focus", "best_pinhole", "builtin_scene",
    "capture_light_field", "capture_lumigraph", "chief_ray", "choose_model", "circle_of_confusion", "depth_map",
    "depth_of_field", "depth_resolution", "develop", "distortion", "distortion_grid", "equivalent", "ev100",
    "exit_pupil", "f_number_at_infinity", "falloff", "fate_colours", "field_of_view", "film_distance", "film_extent",
    "find_depth", "first_order", "focal_length", "focused", "focused_distance", "goal_of", "hyperfocal", "improve",
    "irradiance", "judge", "light_field_bytes", "load_scene", "look_at", "lumigraph_pinhole", "luminance",
    "magnification", "metered_stops", "nearest_focus", "open_region", "photograph_scene", "picture_through",
    "pixel_energy", "radiant_exposure", "real_circle_of_confusion", "recording_bytes", "render", "save",
    "section_foci", "seidel", "show", "stopped_down", "t_number", "thick_circle_of_confusion", "thick_depth_of_field",
    "thick_hyperfocal", "trace", "transmission", "unit_disk", "unit_square", "vignetting", "why_no_ghosts",
    "working_f_number",
]
