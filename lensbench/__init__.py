"""lensbench: lenses and cameras, their rays and their pictures.

    import lensbench as lb
    from lensbench import lenses

Lengths are millimetres, angles radians, wavelengths micrometres. The lens frame
has its origin at the first vertex and light travels along +z, from the scene to
the film; a camera looks along −z, x to the right and y up.

Each name is imported when it is first used: `import lensbench` alone loads neither numpy nor numba.

The first kernel has two effects on numba. lensbench's kernels, and no other functions, are cached in
$XDG_CACHE_HOME/lensbench/kernels (by default ~/.cache/lensbench/kernels). On x86-64 all code that this process compiles
is made for a level of that architecture, v3 or v4, instead of the exact processor; LENSBENCH_NATIVE=1 in the
environment leaves numba's setting as it is. See `core.kernels.cache`.
"""

from typing import TYPE_CHECKING

from lensbench.core.lazy import lazy_names

if TYPE_CHECKING:               # the public names; each is imported when it is first used
    from lensbench.app.notebook.cards import show
    from lensbench.app.notebook.render import Picture, develop, load_scene, render, save
    from lensbench.core import analysis
    from lensbench.core.analysis.aberrations import ChiefRay, Seidel, astigmatic_foci, chief_ray, seidel
    from lensbench.core.analysis.chief_ray_curves import Distortion, distortion, distortion_grid
    from lensbench.core.analysis.model_choice import Choice, choose_model
    from lensbench.core.analysis.vignetting import Falloff, Vignetting, falloff, vignetting
    from lensbench.core.cameras.base import Camera
    from lensbench.core.cameras.custom import CustomCamera
    from lensbench.core.cameras.film_landing import Importance
    from lensbench.core.cameras.fisheye import FisheyeCamera
    from lensbench.core.cameras.ideal_cameras import OrthographicCamera, PerspectiveCamera, PinholeCamera, best_pinhole
    from lensbench.core.cameras.ray_generation import Differentials
    from lensbench.core.cameras.real_lens import LensCamera
    from lensbench.core.cameras.shutter import CameraError, Rays
    from lensbench.core.cameras.without_lens import BareSensor, EnvironmentCamera
    from lensbench.core.design import tolerances
    from lensbench.core.design.goal import Goal
    from lensbench.core.design.improve import Improvement, improve
    from lensbench.core.design.merit import Judgement, judge
    from lensbench.core.design.standard_goal import goal_of
    from lensbench.core.imaging.coordinate_spaces import Intrinsics, Places, Spaces, depth_resolution
    from lensbench.core.imaging.exposure import (
        Exposure, ExposureError, ev100, irradiance, luminance, metered_stops, pixel_energy, radiant_exposure
    )
    from lensbench.core.imaging.film import (
        FORMATS, Equivalent, Film, FilmError, FilmPose, equivalent, field_of_view, film_extent, focal_length
    )
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
    from lensbench.core.optics.axial_bundle import t_number, transmission, working_f_number
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
    from lensbench.core.optics.zoom_positions import Positions, PositionsError
    from lensbench.core.pupils.region import ExitPupil, exit_pupil, open_region
    from lensbench.core.rendering.aovs import AOVS as VIEWS, depth_map, fate_colours
    from lensbench.core.rendering.ghost_image import Flare, why_no_ghosts
    from lensbench.core.rendering.progressive import Rendering
    from lensbench.core.scenery.builtin.library import SCENES, builtin_scene
    from lensbench.core.scenery.objects.basic_shapes import Disk, Rectangle, Sphere
    from lensbench.core.scenery.objects.material import Image, Material, Pattern
    from lensbench.core.scenery.objects.mesh import Mesh
    from lensbench.core.scenery.objects.surroundings import Floor, ImageSky, Sky, Sun
    from lensbench.core.scenery.photograph import photograph_scene
    from lensbench.core.scenery.scene import Scene
    from lensbench.core.scenery.shading.participating_medium import Medium, MediumError
    from lensbench.core.scenery.values import SceneError
    from lensbench.lenses.glass.catalogue import find as glass

__getattr__, __dir__, __all__ = lazy_names(__name__)
