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
environment leaves numba's setting as it is. See `kernels.cache`.
"""

from typing import TYPE_CHECKING

from lensbench.kernels.lazy_names import lazy_names

if TYPE_CHECKING:
    from lensbench import analysis
    from lensbench.analysis.aberrations import ChiefRay, Seidel, astigmatic_foci, chief_ray, seidel
    from lensbench.analysis.distortion import Distortion, distortion, distortion_grid
    from lensbench.analysis.falloff import Falloff, falloff
    from lensbench.analysis.model_choice import Choice, choose_model
    from lensbench.analysis.vignetting import Vignetting, vignetting
    from lensbench.app.notebook.picture import Picture, develop, save
    from lensbench.app.notebook.render import load_scene, render
    from lensbench.app.notebook.show import show
    from lensbench.cameras.bare_sensor import BareSensor
    from lensbench.cameras.base import Camera
    from lensbench.cameras.custom import CustomCamera
    from lensbench.cameras.differentials import Differentials
    from lensbench.cameras.environment import EnvironmentCamera
    from lensbench.cameras.finite_pinhole import PinholeCamera, best_pinhole
    from lensbench.cameras.fisheye import FisheyeCamera
    from lensbench.cameras.importance import Importance
    from lensbench.cameras.orthographic import OrthographicCamera
    from lensbench.cameras.perspective import PerspectiveCamera
    from lensbench.cameras.rays import CameraError, Rays
    from lensbench.cameras.real_lens import LensCamera
    from lensbench.design.goal import Goal
    from lensbench.design.improve import Improvement, improve
    from lensbench.design.merit import Judgement, judge
    from lensbench.design.standard_goal import goal_of
    from lensbench.imaging.animated_transform import AnimatedTransform
    from lensbench.imaging.coordinate_spaces import Intrinsics, Places, Spaces, depth_resolution
    from lensbench.imaging.exposure import (
        Exposure,
        ExposureError,
        ev100,
        irradiance,
        luminance,
        metered_stops,
        pixel_energy,
        radiant_exposure,
    )
    from lensbench.imaging.field_of_view import Equivalent, equivalent, field_of_view, film_extent, focal_length
    from lensbench.imaging.film import FORMATS, Film, FilmError
    from lensbench.imaging.film_pose import FilmPose
    from lensbench.imaging.sensor import Sensor
    from lensbench.imaging.transform import TransformError, look_at
    from lensbench.kernels.concentric_map import unit_disk, unit_square
    from lensbench.lightfields.capture import capture_light_field, light_field_bytes, picture_through, recording_bytes
    from lensbench.lightfields.depth import Depth, find_depth
    from lensbench.lightfields.light_field import LightField, LightFieldError
    from lensbench.lightfields.lumigraph import Lumigraph, NovelView, array_camera, capture_lumigraph, lumigraph_pinhole
    from lensbench.lightfields.plenoptic import PlenopticCamera, RawPicture
    from lensbench.optics.coatings import COATINGS, Coating, CoatingError, Layer, Reflectance
    from lensbench.optics.depth_of_field import (
        circle_of_confusion,
        depth_of_field,
        hyperfocal,
        real_circle_of_confusion,
    )
    from lensbench.optics.focus import FocusError, best_focus, film_distance, focused, focused_distance, nearest_focus
    from lensbench.optics.glass import AIR, C_LINE, D_LINE, F_LINE, Glass, GlassError
    from lensbench.optics.iris import Iris, IrisError
    from lensbench.optics.lens_surface import LensError, Surface
    from lensbench.optics.paraxial import FirstOrder, f_number_at_infinity, first_order, stopped_down
    from lensbench.optics.prescription import Lens
    from lensbench.optics.scalar_trace import Fate, Trace, trace
    from lensbench.optics.stop_image import StopImage, StopImageError
    from lensbench.optics.surface_pose import PoseError, SurfacePose
    from lensbench.optics.system import (
        Aperture,
        ApertureKind,
        FieldKind,
        FieldPoint,
        SystemData,
        SystemDataError,
        Wavelength,
    )
    from lensbench.optics.thick_depth import (
        magnification,
        section_foci,
        thick_circle_of_confusion,
        thick_depth_of_field,
        thick_hyperfocal,
    )
    from lensbench.optics.transmission import t_number, transmission, working_f_number
    from lensbench.optics.zoom_positions import Positions, PositionsError
    from lensbench.pupils.region import ExitPupil, exit_pupil, open_region
    from lensbench.rendering.aovs import AOVS as VIEWS
    from lensbench.rendering.aovs import fate_colours
    from lensbench.rendering.ghost_image import Flare, why_no_ghosts
    from lensbench.rendering.pixel_depth import depth_map
    from lensbench.rendering.progressive import Rendering
    from lensbench.scenery.builtin.library import SCENES, builtin_scene
    from lensbench.scenery.objects import (
        Disk,
        Floor,
        Image,
        ImageSky,
        Material,
        Mesh,
        Pattern,
        Rectangle,
        SceneError,
        Sky,
        Sphere,
        Sun,
    )
    from lensbench.scenery.photograph import photograph_scene
    from lensbench.scenery.scene import Scene
    from lensbench.scenery.shading.participating_medium import Medium, MediumError

_HOMES = {           # the imports above, as they are made at run time
    "analysis": "",
    "app.notebook.picture": "Picture develop save",
    "app.notebook.render": "load_scene render",
    "app.notebook.show": "show",
    "analysis.aberrations": "ChiefRay Seidel astigmatic_foci chief_ray seidel",
    "analysis.distortion": "Distortion distortion distortion_grid",
    "analysis.falloff": "Falloff falloff",
    "analysis.model_choice": "Choice choose_model",
    "analysis.vignetting": "Vignetting vignetting",
    "cameras.bare_sensor": "BareSensor",
    "cameras.base": "Camera",
    "cameras.custom": "CustomCamera",
    "cameras.differentials": "Differentials",
    "cameras.environment": "EnvironmentCamera",
    "cameras.finite_pinhole": "PinholeCamera best_pinhole",
    "cameras.fisheye": "FisheyeCamera",
    "cameras.importance": "Importance",
    "cameras.orthographic": "OrthographicCamera",
    "cameras.perspective": "PerspectiveCamera",
    "cameras.rays": "CameraError Rays",
    "cameras.real_lens": "LensCamera",
    "design.goal": "Goal",
    "design.improve": "Improvement improve",
    "design.merit": "Judgement judge",
    "design.standard_goal": "goal_of",
    "imaging.animated_transform": "AnimatedTransform",
    "imaging.coordinate_spaces": "Intrinsics Places Spaces depth_resolution",
    "imaging.exposure": "Exposure ExposureError ev100 irradiance luminance metered_stops pixel_energy radiant_exposure",
    "imaging.field_of_view": "Equivalent equivalent field_of_view film_extent focal_length",
    "imaging.film": "FORMATS Film FilmError",
    "imaging.film_pose": "FilmPose",
    "imaging.sensor": "Sensor",
    "imaging.transform": "TransformError look_at",
    "kernels.concentric_map": "unit_disk unit_square",
    "lightfields.capture": "capture_light_field light_field_bytes picture_through recording_bytes",
    "lightfields.depth": "Depth find_depth",
    "lightfields.light_field": "LightField LightFieldError",
    "lightfields.lumigraph": "Lumigraph NovelView array_camera capture_lumigraph lumigraph_pinhole",
    "lightfields.plenoptic": "PlenopticCamera RawPicture",
    "optics.coatings": "COATINGS Coating CoatingError Layer Reflectance",
    "optics.depth_of_field": "circle_of_confusion depth_of_field hyperfocal real_circle_of_confusion",
    "optics.focus": "FocusError best_focus film_distance focused focused_distance nearest_focus",
    "optics.glass": "AIR C_LINE D_LINE F_LINE Glass GlassError",
    "optics.iris": "Iris IrisError",
    "optics.paraxial": "FirstOrder f_number_at_infinity first_order stopped_down",
    "optics.lens_surface": "LensError Surface",
    "optics.prescription": "Lens",
    "optics.scalar_trace": "Fate Trace trace",
    "optics.stop_image": "StopImage StopImageError",
    "optics.surface_pose": "PoseError SurfacePose",
    "optics.system": "Aperture ApertureKind FieldKind FieldPoint SystemData SystemDataError Wavelength",
    "optics.thick_depth": "magnification section_foci thick_circle_of_confusion thick_depth_of_field thick_hyperfocal",
    "optics.transmission": "t_number transmission working_f_number",
    "optics.zoom_positions": "Positions PositionsError",
    "pupils.region": "ExitPupil exit_pupil open_region",
    "rendering.aovs": "VIEWS=AOVS fate_colours",
    "rendering.ghost_image": "Flare why_no_ghosts",
    "rendering.pixel_depth": "depth_map",
    "rendering.progressive": "Rendering",
    "scenery.builtin.library": "SCENES builtin_scene",
    "scenery.objects": "Disk Floor Image ImageSky Material Mesh Pattern Rectangle SceneError Sky Sphere Sun",
    "scenery.photograph": "photograph_scene",
    "scenery.scene": "Scene",
    "scenery.shading.participating_medium": "Medium MediumError",
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
