"""Image quality of a lens: one ray grid, and what is read from it; aberrations, distortion, vignetting; model choice.

    grid = lb.analysis.ray_grid(lens, film_distance, lb.analysis.conditions(lens, film))
    lb.analysis.spots(grid).rms_radius          # (fields, wavelengths, places of the film), mm

`conditions` says which fields and wavelengths are taken, and from where. `ray_grid` traces them once and keeps the rays
of the last lens states; every other analysis reads the grid and returns plain arrays in a frozen result. A field that
no light reaches is NaN in them, and named in `grid.findings`.
"""

from typing import TYPE_CHECKING

from lensbench.core.lazy import lazy_names

if TYPE_CHECKING:               # the public names; each is imported when it is first used
    from lensbench.core.analysis.aperture_curves import (
        Breathing, FocusShift, breathing, focus_shift, relative_illumination
    )
    from lensbench.core.analysis.axial_curves import (
        FocalShift, Longitudinal, chromatic_focal_shift, longitudinal_aberration
    )
    from lensbench.core.analysis.blade_star import Sunstar, sunstar
    from lensbench.core.analysis.chief_ray_curves import FieldCurves, field_curves
    from lensbench.core.analysis.depth_over_field import FieldDepth, field_depth
    from lensbench.core.analysis.focus_map import MtfMap, mtf_map
    from lensbench.core.analysis.focus_wedge import SharpFocus, sharp_focus
    from lensbench.core.analysis.ghost_ranking import Ghost, Ghosts, LightBudget, ghosts, light_budget
    from lensbench.core.analysis.grids.field_conditions import Conditions, conditions, field_name
    from lensbench.core.analysis.grids.traced_grid import RayGrid, close_foci, ray_grid
    from lensbench.core.analysis.lens_defects import rippled, with_sensor_stack
    from lensbench.core.analysis.point_spread import PointSpread, encircled_energy, psf
    from lensbench.core.analysis.spot_diagram import Fans, Spots, ray_fans, spots
    from lensbench.core.analysis.transfer_function import Mtf, mtf
    from lensbench.core.analysis.wavefront import (
        Wavefront, fringe_index, noll_indices, wavefronts, zernike_name, zernikes
    )

__getattr__, __dir__, __all__ = lazy_names(__name__)
