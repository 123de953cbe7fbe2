# %% [markdown]
# # A designer's notebook
#
# A lens from its prescription to its picture: first order, third order, spots, MTF, falloff, and what other programs
# read. Run the cells in an editor that knows `# %%` cells, or the file as a script.

# %%
import numpy as np

import lensbench as lb
from lensbench import lenses

# %% [markdown]
# ## A triplet
# Radii, thicknesses and glasses as tables print them.

# %%
crown, flint = lb.Glass(1.62041, 60.3), lb.Glass(1.62004, 36.4)
triplet = lb.Lens((
    lb.Surface(radius=22.01359, thickness=3.25896, semi_diameter=9.5, glass=crown),
    lb.Surface(radius=-435.76044, thickness=6.00755, semi_diameter=9.5),
    lb.Surface(radius=-22.21328, thickness=0.99997, semi_diameter=5.0, glass=flint),
    lb.Surface(radius=20.29192, thickness=4.75041, semi_diameter=5.0),
    lb.Surface(radius=79.68360, thickness=2.95208, semi_diameter=7.5, glass=crown),
    lb.Surface(radius=-18.39533, thickness=0.0, semi_diameter=7.5)), stop_index=3, name="Cooke triplet, 50 mm")
first = lb.first_order(triplet)
print(f"focal length {first.efl:.2f} mm, f/{first.f_number:.2f}, back focus {first.bfl:.2f} mm")
assert abs(first.efl - 50.0) < 0.1
print([str(finding) for finding in lenses.check(triplet)] or "the check finds nothing")

# %% [markdown]
# ## Third order
# Seidel sums of the surfaces; they cancel, and what is left are the aberrations.

# %%
seidel = lb.seidel(triplet, np.radians(20.0))
print(seidel)

# %% [markdown]
# ## Real rays
# Spots and MTF over the field, at the paraxial focus and where the blur is least.

# %%
film = lb.Film(36.0, 24.0, 270, 180)
camera = lb.LensCamera(triplet, film, f_number=5.0)
best = lb.LensCamera(triplet, film, f_number=5.0, focus_method="real")
print(f"film {camera.film_distance:.3f} mm paraxially, {best.film_distance:.3f} mm for the least blur")
conditions = lb.analysis.conditions(best.lens, film)
grid = lb.analysis.ray_grid(best.lens, best.film_distance, conditions)
spots = lb.analysis.spots(grid)
print("rms spots, µm:", np.round(1000.0 * spots.rms_radius[:, 0].ravel(), 1))

# %% [markdown]
# ## Light
# Falloff, separated into the natural one and vignetting.

# %%
falloff = lb.falloff(best.lens, best.film_distance, [0.0, 10.0, 18.0])
print("stops:", np.round(falloff.stops, 2), "of which vignetting:", np.round(np.log2(falloff.vignetting), 2))
assert falloff.stops[0] == 0.0 and falloff.stops[2] < 0.0

# %% [markdown]
# ## A picture, and files for other programs

# %%
picture = lb.render(lb.LensCamera(triplet, film, 1500.0, 5.0), lb.load_scene("still-life"), 32)
lb.save(picture, "designer-triplet.png", exposure=0.5)
lb.show(triplet, camera, picture, open_browser=False).save("designer-triplet.html")
lenses.save(triplet, "designer-triplet.zmx")
assert len(lenses.load("designer-triplet.zmx").surfaces) == len(triplet.surfaces)
