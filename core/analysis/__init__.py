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
    from lensbench.analysis.field_conditions import Conditions, conditions
    from lensbench.analysis.spot_diagram import Spots, spots
    from lensbench.analysis.traced_grid import RayGrid, field_name, ray_grid

_HOMES = {           # the imports above, as they are made at run time; no module has the name of what it supplies
    "analysis.field_conditions": "Conditions conditions",
    "analysis.spot_diagram": "Spots spots",
    "analysis.traced_grid": "RayGrid field_name ray_grid",
}
__getattr__, __dir__ = lazy_names(__name__, _HOMES)

__all__ = ["Conditions", "RayGrid", "Spots", "conditions", "field_name", "ray_grid", "spots"]
