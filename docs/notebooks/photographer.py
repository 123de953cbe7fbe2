# %% [markdown]
# # A photographer's notebook
#
# Which f-number, which focal length, which lens: pictures of the same place, side by side. Run the cells in an editor
# that knows `# %%` cells, or the file as a script: the pictures are written beside it.

# %%
from dataclasses import replace

import numpy as np

import lensbench as lb
from lensbench import lenses

film = lb.Film(36.0, 24.0, 270, 180)
scene = lb.load_scene("night-lights")
lens = lenses.load("pbrt-dgauss-50mm")

# %% [markdown]
# ## Depth of field
# The sharp zone by the rule (a blur of 30 µm), and the picture wide open and stopped down.

# %%
for f_number in (2.1, 4.0, 11.0):
    camera = lb.LensCamera(lens, film, focus_distance=1200.0, f_number=f_number)
    near, far = lb.depth_of_field(camera.first_order.efl, f_number, 1200.0, limit=0.03)
    print(f"f/{f_number}: sharp from {near / 1000:.2f} m to {far / 1000:.2f} m")
    lb.save(lb.render(camera, scene, 64), f"photo-f{f_number:g}.png")

# %% [markdown]
# ## The shape of blurred lights
# Six blades make hexagons; the lens far off the axis makes cat's eyes, which no ideal lens shows.

# %%
hexagons = lb.LensCamera(replace(lens, blades=6), film, focus_distance=700.0, f_number=2.8)
ideal = lb.LensCamera(lens, film, focus_distance=700.0, f_number=2.1, model="thin")
real = lb.LensCamera(lens, film, focus_distance=700.0, f_number=2.1)
lb.save(lb.render(hexagons, scene, 64), "photo-hexagons.png")
lb.save(np.concatenate([lb.render(camera, scene, 64)[:, :135] for camera in (ideal, real)], axis=1),
        "photo-ideal-real.png")

# %% [markdown]
# ## The same picture on another sensor
# Focal length and f-number by the ratio of the diagonals: field of view, depth of field and the light of the whole
# picture are then the same.

# %%
small = lb.Film(17.3, 13.0, 270, 203)
same = lb.equivalent(25.0, small, 1.4)
print(f"25 mm f/1.4 on {small.width} × {small.height} mm is {same.focal_length:.0f} mm f/{same.f_number:.1f} "
      "on 36 × 24 mm")

# %% [markdown]
# ## Exposure
# The meter, a push by one stop, and two tone curves.

# %%
picture = lb.render(lb.LensCamera(lens, film, 1200.0, 2.8), lb.load_scene("still-life"), 64)
stops = lb.metered_stops(picture)
print(f"the meter asks for {stops:+.1f} stops; EV {lb.Exposure(2.8, 1 / 125, 400).ev:.1f} at f/2.8, 1/125 s, ISO 400")
page = lb.show("metered", lb.develop(picture, stops), "one stop more, AgX", lb.develop(picture, stops + 1.0, "agx"),
               open_browser=False)
lb.save(picture, "photo-metered.png", exposure=stops)
