"""Image quality of a lens: one ray grid, and what is read from it; aberrations, distortion, vignetting; model choice.

    grid = lb.analysis.ray_grid(lens, film_distance, lb.analysis.conditions(lens, film))
    lb.analysis.spots(grid).rms_radius          # (fields, wavelengths, places of the film), mm

`conditions` says which fields and wavelengths are taken, and from where. `ray_grid` traces them once and keeps the rays
of the last lens states; every other analysis reads the grid and returns plain arrays in a frozen result. A field that
no light reaches is NaN in them, and named in `grid.findings`.
"""

from typing import TYPE_CHECKING

from lensbench.core.lazy import lazy_names

if TYPE_CHECKING:
    from lensbench.core.analysis.aperture_curves import (
        Breathing, FocusShift, breathing, focus_shift, relative_illumination
    )
    from lensbench.core.analysis.axial_curves import (
        FocalShift, Longitudinal, chromatic_focal_shift, longitudinal_aberration
    )
    from lensbench.core.analysis.blade_star import Sunstar, star_pictures, sunstar
    from lensbench.core.analysis.depth_over_field import FieldDepth, field_depth
    from lensbench.core.analysis.focus_map import MtfMap, mtf_map
    from lensbench.core.analysis.focus_wedge import SharpFocus, sharp_focus
    from lensbench.core.analysis.ghost_ranking import Ghost, Ghosts, LightBudget, ghosts, light_budget
    from lensbench.core.analysis.grids.field_conditions import Conditions, conditions, field_name
    from lensbench.core.analysis.grids.traced_grid import RayGrid, close_foci, ray_grid
    from lensbench.core.analysis.manufacture import (
        Production, Sensitivity, Tolerances, manufactured, production, sensitivities
    )
    from lensbench.core.analysis.meridional_curves import FieldCurves, field_curves
    from lensbench.core.analysis.onion_rings import rippled
    from lensbench.core.analysis.point_spread import PointSpread, encircled_energy, psf
    from lensbench.core.analysis.sensor_stack import with_sensor_stack
    from lensbench.core.analysis.spot_diagram import Fans, Spots, ray_fans, spots
    from lensbench.core.analysis.transfer_function import Mtf, mtf
    from lensbench.core.analysis.wavefront import (
        Wavefront, fringe_index, noll_indices, wavefronts, zernike_name, zernikes
    )

_HOMES = {           # the imports above, as they are made at run time
    "core.analysis.aperture_curves": "Breathing FocusShift breathing focus_shift relative_illumination",
    "core.analysis.axial_curves": "FocalShift Longitudinal chromatic_focal_shift longitudinal_aberration",
    "core.analysis.blade_star": "Sunstar sunstar star_pictures",
    "core.analysis.depth_over_field": "FieldDepth field_depth",
    "core.analysis.focus_map": "MtfMap mtf_map",
    "core.analysis.focus_wedge": "SharpFocus sharp_focus",
    "core.analysis.ghost_ranking": "Ghost Ghosts ghosts LightBudget light_budget",
    "core.analysis.grids.field_conditions": "Conditions conditions field_name",
    "core.analysis.grids.traced_grid": "ray_grid close_foci RayGrid",
    "core.analysis.manufacture": "Production Sensitivity Tolerances production sensitivities manufactured",
    "core.analysis.meridional_curves": "FieldCurves field_curves",
    "core.analysis.onion_rings": "rippled",
    "core.analysis.point_spread": "PointSpread encircled_energy psf",
    "core.analysis.sensor_stack": "with_sensor_stack",
    "core.analysis.spot_diagram": "Fans ray_fans Spots spots",
    "core.analysis.transfer_function": "Mtf mtf",
    "core.analysis.wavefront": "Wavefront wavefronts fringe_index noll_indices zernike_name zernikes",
}
__getattr__, __dir__ = lazy_names(__name__, _HOMES)

__all__ = [
    "Breathing", "Conditions", "Fans", "FieldCurves", "FieldDepth", "FocalShift", "FocusShift", "Ghost", "Ghosts",
    "LightBudget", "Longitudinal", "Mtf", "MtfMap", "PointSpread", "Production", "RayGrid", "Sensitivity", "SharpFocus",
    "Spots", "Sunstar", "Tolerances", "Wavefront", "breathing", "chromatic_focal_shift", "close_foci", "conditions",
    "encircled_energy", "field_curves", "field_depth", "field_name", "focus_shift", "fringe_index", "ghosts",
    "light_budget", "longitudinal_aberration", "manufactured", "mtf", "mtf_map", "noll_indices", "production", "psf",
    "ray_fans", "ray_grid", "relative_illumination", "rippled", "sensitivities", "sharp_focus", "spots",
    "star_pictures", "sunstar", "wavefronts", "with_sensor_stack", "zernike_name", "zernikes",
]
