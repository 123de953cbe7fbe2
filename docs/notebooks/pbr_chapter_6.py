# %% [markdown]
# # Camera models of "Physically Based Rendering" in lensbench
#
# Chapter 6 of the third edition, chapter 5 of the fourth. Run the cells in an editor that knows `# %%` cells, or the
# file as a script: the pictures are written beside it.
#
# | pbrt | lensbench |
# |---|---|
# | `Camera::GenerateRay(sample)` | `camera.generate_rays(raster, uv, time)`, many rays at once |
# | `CameraSample::pFilm, pLens, time` | raster points in pixels, `uv` in [0, 1]², `time` in [0, 1) of the shutter |
# | `GenerateRayDifferential` | `generate_ray_differentials`; derivatives per pixel |
# | `We`, `Pdf_We`, `Sample_Wi` | `camera.importance(origins, directions)`, `camera.raster_from_point(points)` |
# | `ProjectiveCamera` matrices | `camera.spaces(near, far).ndc_from_world` and so on |
# | `PerspectiveCamera`, `fov` in degrees | `PerspectiveCamera(film, fov)`, radians, along the shorter side as in pbrt |
# | `SphericalCamera`, `EnvironmentCamera` | `EnvironmentCamera(film, layout)` |
# | `RealisticCamera(lensfile, aperturediameter, focusdistance)` | `LensCamera(lens, film, focus_distance, f_number)` |
# | `BoundExitPupil` (a box) | `exit_pupil(lens, film_distance, radii)`: the region itself; its `bounds` are the box |
# | `simpleweighting` | `weights="relative"`; false is `"physical"`; a pinhole of weight 1 is `"one"` |
# | `ComputeThickLensApproximation` | `first_order(lens)`: principal planes, foci, pupils |
# | `FocusThickLens` | `film_distance(lens, focus_distance)`; `focus_method="real"` for the least blur |
#
# pbrt counts in metres, with x to the right, y up and +z into the scene, left-handed. lensbench counts in millimetres;
# the camera looks along −z, right-handed. Both turn the picture upright.

# %%
import numpy as np

import lensbench as lb
from lensbench import lenses

film = lb.Film(36.0, 24.0, 270, 180)
scene = lb.load_scene("still-life")

# %% [markdown]
# ## Projective cameras
# The pinhole has weight 1 in pbrt, so take `weights="one"`: by default it falls off as cos⁴θ.

# %%
pinhole = lb.PerspectiveCamera(film, fov=0.7, weights="one")
parallel = lb.OrthographicCamera(film, width=1400.0, world_from_camera=lb.look_at((0, 900, 600), (0, 0, -1200)))
lb.save(lb.render(pinhole, scene, 16), "pbr-perspective.png")
lb.save(lb.render(parallel, scene, 16), "pbr-orthographic.png")

# %% [markdown]
# A point of the world in every space, by the matrices and by projection:

# %%
spaces = pinhole.spaces(near=10.0, far=5000.0)
point = np.array([100.0, 50.0, -1200.0, 1.0])
raster = spaces.raster_from_world @ point
raster = raster[:2] / raster[3]
projected, visible = pinhole.raster_from_point(point[None, :3])
assert visible[0] and np.allclose(raster, projected[0])

# %% [markdown]
# ## The thin lens
# `uv` = (0.5, 0.5) is the middle of the lens. All rays of a film point meet on the plane in focus.

# %%
thin = lb.PerspectiveCamera(film, fov=0.7, lens_radius=15.0, focus_distance=1200.0)
uv = np.random.default_rng(0).random((100, 2))
rays = thin.generate_rays(np.tile([200.0, 60.0], (100, 1)), uv)
t = (-1200.0 - rays.origins[:, 2]) / rays.directions[:, 2]
assert np.ptp(rays.origins + t[:, None] * rays.directions, axis=0).max() < 1e-9
lb.save(lb.render(thin, scene, 64), "pbr-thin-lens.png")

# %% [markdown]
# ## Panoramas

# %%
panorama = lb.EnvironmentCamera(lb.Film(36.0, 18.0, 270, 135))
lb.save(lb.render(panorama, lb.load_scene("room"), 16), "pbr-panorama.png")

# %% [markdown]
# ## Realistic cameras
# The double Gauss of pbrt's scenes. The film distance is that of pbrt's thick lens, and exit pupils shrink off axis.

# %%
lens = lenses.load("pbrt-dgauss-50mm")
camera = lb.LensCamera(lens, film, focus_distance=1200.0)
pupil = lb.exit_pupil(camera.lens, camera.film_distance, [0.0, 10.0, 20.0])
print("film distance", camera.film_distance, "mm; exit pupils", pupil.area, "mm²; pbrt's box", pupil.bounds[1])
assert pupil.area[0] > pupil.area[1] > pupil.area[2]
lb.save(lb.render(camera, scene, 64), "pbr-realistic.png")

# %% [markdown]
# The radiometry of the section "The camera measurement equation": under a sky of radiance 1, the irradiance of the
# film's centre is π sin²θ′, to the noise of the samples.

# %%
physical = lb.LensCamera(lens, film, 1200.0, weights="physical", model="trace")
weights = physical.generate_rays(np.tile([135.0, 90.0], (4096, 1)), np.random.default_rng(1).random((4096, 2))).weights
expected = lb.falloff(physical.lens, physical.film_distance, [0.0]).irradiance[0]
print("irradiance", weights.mean(), "by rays,", expected, "by the exit pupil")
assert abs(weights.mean() / expected - 1.0) < 0.01
