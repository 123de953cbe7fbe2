"""Image quality of a lens: one ray grid, and what is read from it; aberrations, distortion, vignetting; model choice.

    grid = lb.analysis.ray_grid(lens, film_distance, lb.analysis.conditions(lens, film))
    lb.analysis.spots(grid).rms_radius          # (fields, wavelengths, places of the film), mm

`conditions` says which fields and wavelengths are taken, and from where. `ray_grid` traces them once and keeps the rays
of the last lens states; every other analysis reads the grid and returns plain arrays in a frozen result. A field that
no light reaches is NaN in them, and named in `grid.findings`.
"""

from typing import TYPE_CHECKING

from lensbench.kernels.lazy_names import lazy_names

if TYPE_CHECKING:
    from lensbench.analysis.aperture_curves import Breathing, FocusShift, breathing, focus_shift, relative_illumination
    from lensbench.analysis.axial_curves import FocalShift, Longitudinal, chromatic_focal_shift, longitudinal_aberration
    from lensbench.analysis.blade_star import Sunstar, sunstar
    from lensbench.analysis.depth_over_field import FieldDepth, field_depth
    from lensbench.analysis.fans import Fans, ray_fans
    from lensbench.analysis.focus_map import MtfMap, mtf_map
    from lensbench.analysis.focus_wedge import SharpFocus, sharp_focus
    from lensbench.analysis.ghost_ranking import Ghost, Ghosts, ghosts
    from lensbench.analysis.grids.field_conditions import Conditions, conditions, field_name
    from lensbench.analysis.grids.grid_trace import ray_grid
    from lensbench.analysis.grids.narrow_beams import close_foci
    from lensbench.analysis.grids.traced_grid import RayGrid
    from lensbench.analysis.manufacture import Production, Sensitivity, Tolerances, production, sensitivities
    from lensbench.analysis.manufactured_lens import manufactured
    from lensbench.analysis.meridional_curves import FieldCurves, field_curves
    from lensbench.analysis.onion_rings import rippled
    from lensbench.analysis.point_spread import PointSpread, encircled_energy, psf
    from lensbench.analysis.reflection_tree import LightBudget, light_budget
    from lensbench.analysis.sensor_stack import with_sensor_stack
    from lensbench.analysis.spot_diagram import Spots, spots
    from lensbench.analysis.star_strip import star_pictures
    from lensbench.analysis.transfer_function import Mtf, mtf
    from lensbench.analysis.wavefront import Wavefront, wavefronts
    from lensbench.analysis.zernike import fringe_index, noll_indices, zernike_name, zernikes

_HOMES = {           # the imports above, as they are made at run time; no module has the name of what it supplies
    "analysis.aperture_curves": "Breathing FocusShift breathing focus_shift relative_illumination",
    "analysis.axial_curves": "FocalShift Longitudinal chromatic_focal_shift longitudinal_aberration",
    "analysis.blade_star": "Sunstar sunstar",
    "analysis.depth_over_field": "FieldDepth field_depth",
    "analysis.fans": "Fans ray_fans",
    "analysis.focus_map": "MtfMap mtf_map",
    "analysis.focus_wedge": "SharpFocus sharp_focus",
    "analysis.ghost_ranking": "Ghost Ghosts ghosts",
    "analysis.grids.field_conditions": "Conditions conditions field_name",
    "analysis.grids.grid_trace": "ray_grid",
    "analysis.grids.narrow_beams": "close_foci",
    "analysis.grids.traced_grid": "RayGrid",
    "analysis.manufacture": "Production Sensitivity Tolerances production sensitivities",
    "analysis.manufactured_lens": "manufactured",
    "analysis.meridional_curves": "FieldCurves field_curves",
    "analysis.onion_rings": "rippled",
    "analysis.point_spread": "PointSpread encircled_energy psf",
    "analysis.reflection_tree": "LightBudget light_budget",
    "analysis.sensor_stack": "with_sensor_stack",
    "analysis.spot_diagram": "Spots spots",
    "analysis.star_strip": "star_pictures",
    "analysis.transfer_function": "Mtf mtf",
    "analysis.wavefront": "Wavefront wavefronts",
    "analysis.zernike": "fringe_index noll_indices zernike_name zernikes",
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
