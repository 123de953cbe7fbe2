"""Triangle meshes: rays against brute force and Embree, spheres of triangles against spheres, shadows, light."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, BLUE, DEPTH, GREEN, NX, NY, NZ, PIXEL_SPREAD, RED, TIME, V0, V1, L, M, N, X, Y, Z
)
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.intersect.meshes import find_meshes, nearest_distances, surfaces
from lensbench.core.scenery.intersect.triangle_tree import triangle_tree
from lensbench.core.scenery.shading.meshes import mesh_lamp_step, mesh_shadow_steps
from tests.core.scenery.test_scene import shoot, square_lights

slow = pytest.mark.slow
DARK = lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)


def sphere_mesh(rings, radius, centre, bumps=0.0, **others):
    """Triangles of a sphere (with bumps), their corners on it, anticlockwise from outside."""
    theta, phi = np.linspace(0.0, np.pi, rings)[:, None], np.linspace(0.0, 2.0 * np.pi, 2 * rings)[None]
    phi[:, -1] = 0.0                                # no seam
    r = 1.0 + bumps * np.sin(9 * theta) * np.cos(11 * phi)
    theta[-1] = np.pi
    away = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta) + 0.0 * phi, np.sin(theta) * np.sin(phi)], -1)
    k = np.arange(rings - 1)[:, None] * 2 * rings + np.arange(2 * rings - 1)
    faces = np.concatenate([np.stack([k, k + 1, k + 2 * rings], -1).reshape(-1, 3),
                            np.stack([k + 1, k + 2 * rings + 1, k + 2 * rings], -1).reshape(-1, 3)])
    points = (r[..., None] * away).reshape(-1, 3) * radius + np.asarray(centre)
    normals = None if bumps else away.reshape(-1, 3)
    return lb.Mesh.of(points, faces, normals=normals, **others)


def even_lights(count):
    """Points (2, n) of the square by the R2 sequence (Roberts 2018): a grid would choose one triangle in many."""
    k = np.arange(1, count + 1)
    return (k * 0.7548776662466927) % 1.0, (k * 0.5698402909980532) % 1.0


def soup(count, seed=0, size=30.0):
    """Random triangles within 300 mm of the point 800 mm ahead."""
    random = np.random.default_rng(seed)
    corners = random.uniform(-300.0, 300.0, (count, 1, 3)) + random.normal(0.0, size, (count, 3, 3))
    return lb.Mesh.of(corners.reshape(-1, 3) + [0.0, 0.0, -800.0], np.arange(3 * count).reshape(-1, 3))


def moller_trumbore(corners, origins, directions):
    """Nearest distance of each ray (n,) to all triangles (m, 3, 3), inf for none (Möller and Trumbore 1997)."""
    nearest = np.full(len(origins), np.inf)
    a, e, f = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    for k, (o, d) in enumerate(zip(origins, directions, strict=True)):
        p = np.cross(d, f)
        with np.errstate(all="ignore"):
            inverse = 1.0 / np.einsum("ij,ij->i", e, p)
            s = o - a
            u = np.einsum("ij,ij->i", s, p) * inverse
            q = np.cross(s, e)
            v = q @ d * inverse
            t = np.einsum("ij,ij->i", f, q) * inverse
        t = t[(u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0)]
        nearest[k] = t.min(initial=np.inf)
    return nearest


def random_rays(count, seed=1):
    random = np.random.default_rng(seed)
    origins = random.normal(0.0, 100.0, (count, 3))
    ways = random.uniform(-300.0, 300.0, (count, 3)) + [0.0, 0.0, -800.0] - origins
    return origins, ways / np.linalg.norm(ways, axis=1)[:, None]


@slow
@pytest.mark.parametrize("count", [1, 7, 8, 9, 65, 3000])
def test_the_tree_finds_what_brute_force_finds(count):
    mesh = soup(count, count, size=30.0 if count > 9 else 400.0)
    origins, ways = random_rays(1500)
    corners = mesh.points[mesh.triangles].astype(float)
    expected = moller_trumbore(corners, origins, ways)
    found = nearest_distances((mesh,), origins, ways)
    np.testing.assert_array_equal(np.isnan(found), np.isinf(expected))
    met = np.isfinite(expected)
    assert met.sum() > (0 if count == 1 else 20)
    np.testing.assert_allclose(found[met], expected[met], rtol=1e-9)


def rays_of_kind(kind, count):
    """Rays toward a soup: neighbours of a pinhole, through an aperture, along an axis, or with lost rays among them."""
    random = np.random.default_rng(4)
    if kind in ("scattered", "with lost rays"):
        origins, ways = random_rays(count)
        ways[::7] *= 0.0 if kind == "with lost rays" else 1.0
        return origins, ways
    column, line = np.arange(count) % 64, np.arange(count) // 64
    aim = np.column_stack([column * 8.0 - 256.0, line * 20.0 - 240.0, np.full(count, -800.0)])
    origins = np.zeros((count, 3))
    if kind == "through an aperture":
        origins[:, :2] = random.uniform(-12.0, 12.0, (count, 2))
    elif kind == "along an axis":
        origins[:, :2] = aim[:, :2]
    ways = aim - origins
    return origins, ways / np.linalg.norm(ways, axis=1)[:, None]


@slow
@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("kind", ["neighbours", "through an aperture", "along an axis", "scattered", "with lost rays"])
def test_groups_of_rays_find_what_brute_force_finds(kind, real):
    # 1,500 is no multiple of the sixteen rays of a group
    mesh = soup(3000, size=8.0)
    origins, ways = (a.astype(real) for a in rays_of_kind(kind, 1500))
    lost = ~ways.any(1)
    expected = np.where(lost, np.inf, moller_trumbore(mesh.points[mesh.triangles].astype(float), origins, ways))
    given = {X: origins[:, 0], Y: origins[:, 1], Z: origins[:, 2], L: ways[:, 0], M: ways[:, 1], N: ways[:, 2]}
    found, met = Program(lb.Scene("soup", meshes=(mesh,)).depth_steps(), real).run(given, [RED, GREEN], len(ways))
    hit = np.isfinite(expected)
    assert 0.1 < hit.mean() < 0.99 and lost.any() == (kind == "with lost rays")
    single = real is np.float32
    assert (hit != (met > 0.0)).sum() <= (3 if single else 0)       # rounding at edges
    both = hit & (met > 0.0)
    assert (np.abs(found[both] - expected[both]) < (1e-3 if single else 1e-8)).mean() > (0.995 if single else 0.9999)


@slow
def test_equal_and_flat_triangles_make_a_tree():
    # A thousand copies of one triangle, and a sheet without a depth: nothing to choose between by area
    same = np.tile(np.float32([[[0, 0, -9], [1, 0, -9], [0, 1, -9]]]), (1000, 1, 1))
    sheet = np.random.default_rng(4).uniform(-1, 1, (1000, 3, 3)).astype(np.float32) * np.float32([1, 1, 0])
    for corners in (same, sheet):
        tree = triangle_tree(corners)
        assert np.isin(np.arange(1000), tree.leaves[:, 72:].ravel()).all()
    rows = np.arange(3000).reshape(-1, 3)
    mesh = lb.Mesh.of(same.reshape(-1, 3), rows)
    assert nearest_distances((mesh,), np.array([[0.2, 0.2, 0.0]]), np.array([[0.0, 0.0, -1.0]])) == pytest.approx(9.0)


@slow
def test_a_closed_surface_has_no_holes_in_single_precision():
    # Rays from inside at the edges of 45,000 triangles, where none may pass, and just at their corners
    mesh = sphere_mesh(151, 400.0, (0.0, 0.0, 0.0))
    random = np.random.default_rng(5)
    rows = mesh.triangles[random.integers(0, len(mesh.triangles), 200_000)]
    part = random.uniform(0.0, 1.0, 200_000)[:, None]
    part[:40_000] = 0.0
    aim = mesh.points[rows[:, 0]] * (1.0 - part) + mesh.points[rows[:, 1]] * part
    origins = random.normal(0.0, 60.0, (200_000, 3))
    ways = aim - origins
    scene = lb.Scene("ball", meshes=(mesh,))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    given = {X: origins[:, 0], Y: origins[:, 1], Z: origins[:, 2], L: ways[:, 0], M: ways[:, 1], N: ways[:, 2]}
    away, met = Program(scene.depth_steps(), np.float32).run(given, [RED, GREEN], len(ways))
    assert (met[40_000:] == 1.0).all() and (met[:40_000] == 0.0).sum() < 12
    away, origins, ways = away[met > 0.0], origins[met > 0.0], ways[met > 0.0]
    place = np.linalg.norm(origins + away[:, None] * ways, axis=1)
    assert place.max() < 400.1 and place.min() > 400.0 * math.cos(math.pi / 150) - 0.1


@slow
def test_embree_agrees_on_a_million_rays():
    from embreex import mesh_construction as mesh_module, rtcore, rtcore_scene as scene_module

    mesh = sphere_mesh(145, 300.0, (0.0, 0.0, -800.0), bumps=0.1)
    assert len(mesh.triangles) > 82_000
    device = rtcore.EmbreeDevice()
    embree = scene_module.EmbreeScene(device)
    mesh_module.TriangleMesh(embree, mesh.points[mesh.triangles])
    count = 1_000_000
    origins, ways = (a.astype(np.float32) for a in random_rays(count))
    expected = embree.run(origins, ways, query="DISTANCE")
    scene = lb.Scene("ball", meshes=(mesh,))
    given = {X: origins[:, 0], Y: origins[:, 1], Z: origins[:, 2], L: ways[:, 0], M: ways[:, 1], N: ways[:, 2]}
    found, met = Program(scene.depth_steps(), np.float32).run(given, [RED, GREEN], count)
    hit = expected < 1e6
    assert 0.2 < hit.mean() < 0.999
    assert (hit != (met > 0.0)).sum() <= 3               # silhouettes, within rounding
    both = hit & (met > 0.0)
    off = np.abs(found[both] - expected[both])
    assert (off > 1e-3 * expected[both]).mean() < 1e-5 and np.median(off) < 1e-3


@slow
@pytest.mark.parametrize("kind", ["matte", "metal", "glass"])
def test_a_sphere_of_triangles_becomes_a_sphere(kind):
    # matte and metal: the depth and the light differ by the square of the width of a triangle
    sky = lb.Sky((0.3, 0.5, 0.9), (0.8, 0.85, 0.9), (0.3, 0.28, 0.25))
    base = lb.Scene("ball", sky=sky, floor=lb.Floor(-300.0, 150.0))
    material = lb.Material((0.9, 0.8, 0.7), kind)
    random = np.random.default_rng(8)
    aim = np.column_stack([random.uniform(-0.14, 0.14, (1500, 2)), -np.ones(1500)])
    aim = aim[np.hypot(aim[:, 0], aim[:, 1]) < 0.14]
    steps = replace(base, spheres=(lb.Sphere((0.0, 0.0, -1000.0), 150.0, material),)).steps(shadows=False)
    expected = shoot(steps, np.zeros(3), aim)
    errors = []
    for rings in (20, 60, 180):
        mesh = sphere_mesh(rings, 150.0, (0.0, 0.0, -1000.0), material=material)
        found = shoot(replace(base, meshes=(mesh,)).steps(shadows=False), np.zeros(3), aim)
        errors.append(np.median(np.abs(found - expected)))
    assert errors[2] < 0.25 * errors[1] < 0.25 * errors[0] or errors[2] < 2e-4
    assert errors[2] < (0.02 if kind == "glass" else 2e-3)


@slow
def test_a_mesh_of_two_triangles_is_a_rectangle_in_light_and_shadow():
    corners = np.array([[-150.0, 0.0, -850.0], [150.0, 0.0, -850.0], [150.0, 0.0, -1150.0], [-150.0, 0.0, -1150.0]])
    lid = lb.Mesh.of(corners, [[0, 1, 2], [0, 2, 3]], lb.Material((0.4, 0.5, 0.6)))
    plate = lb.Rectangle((0.0, 0.0, -1000.0), (150.0, 0.0, 0.0), (0.0, 0.0, -150.0), lb.Material((0.4, 0.5, 0.6)))
    shining = lb.Material((9.0, 8.0, 7.0), "lamp")
    lamp = lb.Rectangle((60.0, 600.0, -900.0), (120.0, 0.0, 0.0), (0.0, 0.0, 120.0), shining)
    base = lb.Scene("lid", sky=DARK, floor=lb.Floor(-250.0), plates=(lamp,), sun=lb.Sun((0.3, 0.8, 0.2)))
    random = np.random.default_rng(9)
    n = 4000
    origins = np.tile([0.0, 300.0, 300.0], (n, 1))
    ways = np.column_stack([random.uniform(-300, 300, n), np.full(n, -250.0), random.uniform(-1400, -700, n)]) - origins
    lights = random.uniform(0.0, 1.0, (2, n))
    found = shoot(replace(base, meshes=(lid,)).steps(), origins, ways, lights, np.float32)
    expected = shoot(replace(base, plates=(lamp, plate)).steps(), origins, ways, lights, np.float32)
    close = np.isclose(found, expected, rtol=2e-4, atol=2e-5).all(1)
    assert close.mean() > 0.999                          # edges within rounding
    assert (expected.sum(1) == 0.0).sum() > 20           # full shadow


@pytest.mark.parametrize("away", [500.0, 40.0])
def test_a_mesh_hides_light_anywhere_before_the_lamp_and_not_beyond_it(away):
    """Light from above on a floor: the sail hangs a part of the way up to the lamp, above that, or beside it."""
    shares = np.array([0.01, 0.3, 0.7, 0.9, 0.99, 1.01, 1.5, 3.0])
    n = len(shares)
    far, up, light = away / shares, np.ones(n), np.linspace(1.0, 2.0, n)
    corners = np.array([[-30.0, away, -30.0], [30.0, away, -30.0], [0.0, away, 40.0]])
    rows = {A0: np.zeros(n), A1: np.zeros(n), A2: np.zeros(n), A3: np.zeros(n), A4: up, A5: np.zeros(n), A6: far,
            A7: light, NY: up, RED: up, GREEN: up, BLUE: up, DEPTH: np.full(n, 900.0)}
    for shift, hidden in ((0.0, shares < 1.0), (50.0, shares < 0.0)):
        mesh = lb.Mesh.of(corners + [shift, 0.0, 0.0], [[0, 1, 2]])
        (left,) = Program(mesh_shadow_steps((mesh,)), np.float64).run(rows, [A7], n)
        np.testing.assert_array_equal(left, np.where(hidden, 0.0, light))


@slow
def test_moving_shapes_and_lamps_light_a_mesh_as_a_rectangle():
    # a ball that flies through the light of a lamp that moves, above a wall of two triangles or of one rectangle
    corners = [[-200.0, -250.0, -700.0], [200.0, -250.0, -700.0], [200.0, -250.0, -1300.0], [-200.0, -250.0, -1300.0]]
    material = lb.Material((0.4, 0.5, 0.6))
    mesh = lb.Mesh.of(corners, [[0, 1, 2], [0, 2, 3]], material)
    plate = lb.Rectangle((0.0, -250.0, -1000.0), (200.0, 0.0, 0.0), (0.0, 0.0, -300.0), material)
    far = lb.Mesh.of(np.array(corners) + [0.0, 0.0, -90_000.0], [[0, 1, 2]])        # both scenes have a mesh
    ball = lb.Sphere((-60.0, -150.0, -1000.0), 70.0, velocity=(1000.0, 0.0, 0.0))
    lamp = lb.Sphere((0.0, 500.0, -900.0), 60.0, lb.Material((40.0, 30.0, 20.0), "lamp"), velocity=(0.0, 0.0, -900.0))
    base = lb.Scene("flight", sky=DARK, spheres=(ball, lamp), sun=lb.Sun((0.2, 0.9, 0.1)))
    random = np.random.default_rng(10)
    n = 4000
    places = np.column_stack([random.uniform(-190, 190, n), np.full(n, -250.0), random.uniform(-1290, -710, n)])
    origins = np.tile([0.0, 300.0, 300.0], (n, 1))
    ways = places - origins
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    given = {X: origins[:, 0], Y: origins[:, 1], Z: origins[:, 2], L: ways[:, 0], M: ways[:, 1], N: ways[:, 2],
             TIME: random.uniform(0.0, 0.1, n), V0: random.random(n), V1: random.random(n)}
    found, expected = (Program(replace(base, **change).steps(), np.float64).run(given, [RED, GREEN, BLUE], n)
                       for change in ({"meshes": (mesh, far)}, {"plates": (plate,), "meshes": (far,)}))
    assert np.isclose(found, expected, rtol=1e-4, atol=1e-5).all(0).mean() > 0.998
    lit, shaded = expected[0].max(), np.percentile(expected[0], 2)
    assert shaded < 0.5 * lit                             # the ball has a shadow


@slow
def test_a_uniform_sky_is_hidden_by_a_mesh_as_by_a_sphere():
    # r² cos θ / d² of the light of a uniform sky (exact for a sphere above the horizon)
    ball = sphere_mesh(80, 300.0, (0.0, 0.0, -1000.0))
    floor = lb.Disk((0.0, -500.0, 0.0), (0.0, 1.0, 0.0), 5000.0, lb.Material((1.0, 1.0, 1.0)))
    scene = lb.Scene("ball", sky=lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3), plates=(floor,), meshes=(ball,))
    v0, v1 = square_lights(192)
    lit = np.array([100.0, -500.0, -400.0])
    seen = shoot(scene.steps(), np.zeros((len(v0), 3)), lit, (v0, v1)).mean(0)
    to = np.array([0.0, 0.0, -1000.0]) - lit
    np.testing.assert_allclose(seen, 1.0 - 300.0**2 * to[1] / np.linalg.norm(to) ** 3, rtol=3e-3)


@slow
def test_glass_casts_the_shadow_of_a_glass_ball_whichever_way_its_triangles_turn():
    # Schlick's reflectance at two surfaces, averaged over the disk of a ball; `Sphere` has 0.85
    centre, glass = (0.0, 0.0, -1000.0), lb.Material((1.0, 1.0, 1.0), "glass")
    ball = sphere_mesh(80, 200.0, centre, material=glass)
    floor = lb.Disk((0.0, -500.0, -1000.0), (0.0, 1.0, 0.0), 900.0, lb.Material((1.0, 1.0, 1.0)))
    scene = lb.Scene("glass", sky=DARK, plates=(floor,), sun=lb.Sun((0.0, 1.0, 0.0), (1.0, 1.0, 1.0), 1e-4))
    angle, radius = 2.399963 * np.arange(600), 200.0 * np.sqrt((np.arange(600) + 0.5) / 600)
    places = np.column_stack([radius * np.cos(angle), np.full(600, -500.0), -1000.0 + radius * np.sin(angle)])
    origins = places + [900.0, 300.0, 0.0]              # they see the floor past the ball
    half = np.full((2, 600), 0.5)
    cosine = np.sqrt(1.0 - (radius / 200.0) ** 2)
    expected = (0.96 * (1.0 - (1.0 - cosine) ** 5)) ** 2
    seen = shoot(replace(scene, meshes=(ball,)).steps(), origins, places - origins, half)[:, 1]
    assert abs(seen - expected)[radius < 180.0].max() < 0.02 and seen.mean() == pytest.approx(0.85, abs=0.02)
    # A slanted sun: the same ball, from which each place of its shadow lies so far along the way to the sun
    way = np.array([0.48, 0.6, 0.64])
    slanted = replace(scene, sun=replace(scene.sun, direction=tuple(way)), plates=(replace(floor, radius=2000.0),))
    across = np.cross(way, [0.0, 1.0, 0.0]) / 0.8
    other = np.cross(across, way)
    through = np.array(centre) + radius[:, None] * (np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * other)
    places = through - ((through[:, 1:2] + 500.0) / way[1]) * way
    origins = places + [900.0, 300.0, 0.0]
    seen = [shoot(replace(slanted, meshes=meshes).steps(), origins, places - origins, half)[:, 1]
            for meshes in ((ball,), ())]
    assert abs(seen[0] / seen[1] - expected)[radius < 180.0].max() < 0.02
    assert lb.Mesh.of(ball.points, ball.triangles[:, ::-1], glass).faces == ball.faces


@slow
def test_images_colours_and_normals_are_those_of_the_corners():
    values = np.random.default_rng(3).uniform(0.1, 1.0, (8, 8, 3))
    points = [[-100.0, -100.0, -500.0], [100.0, -100.0, -500.0], [100.0, 100.0, -500.0], [-100.0, 100.0, -500.0]]
    faces, uv = [[0, 1, 2], [0, 2, 3]], [[0, 0], [2, 0], [2, 1], [0, 1]]
    tints = [[1.0, 0.5, 0.2]] * 4
    normals = np.tile([0.3, 0.0, 0.95394], (4, 1))
    shiny = lb.Mesh.of(points, faces, lb.Material((0.5, 1.0, 2.0), "light", pattern=lb.Pattern(
        "image", image=lb.Image.of(values))), uv=uv, colours=tints, normals=normals)
    behind = np.array(points) * [8.0, 8.0, 1.0] - [0.0, 0.0, 100.0]
    plain = lb.Mesh.of(behind, faces, lb.Material((0.3, 0.2, 0.1), "light"))
    scene = lb.Scene("wall", meshes=(shiny, plain))
    line, column = np.divmod(np.arange(128), 16)
    x, y = -100.0 + 200.0 * (column + 0.5) / 16, 100.0 - 200.0 * (line + 0.5) / 8
    ways = np.column_stack([x, y, np.full(128, -500.0)])
    seen = shoot(scene.steps(shadows=False), 0.0, ways)
    expected = values[line, column % 8] * [0.5, 1.0, 2.0] * tints[0]
    np.testing.assert_allclose(seen, expected, rtol=2e-4, atol=1e-4)
    np.testing.assert_allclose(shoot(scene.steps(shadows=False), 0.0, [(150.0, 0.0, -500.0)])[0], (0.3, 0.2, 0.1))
    ways = ways / np.linalg.norm(ways, axis=1)[:, None]
    rows = Program(scene.steps(shadows=False), np.float64).run(
        {L: ways[:, 0], M: ways[:, 1], N: ways[:, 2], PIXEL_SPREAD: np.zeros(128)}, [NX, NY, NZ], 128)
    np.testing.assert_allclose(rows.T, np.tile([0.3, 0.0, 0.95394], (128, 1)), atol=1e-5)


def test_a_repeated_image_has_places_from_edge_to_edge():
    points = [[-100.0, -100.0, -500.0], [100.0, -100.0, -500.0], [100.0, 100.0, -500.0], [-100.0, 100.0, -500.0]]
    wall = lb.Mesh.of(points, [[0, 1, 2], [0, 2, 3]], uv=[[-1.5, 0], [3, 0], [3, 2], [-1.5, 2]])
    steps = lb.Scene("wall", meshes=(wall,)).steps(shadows=False)
    end = [step.kernel for step in steps].index(find_meshes) + 1
    x, y = np.random.default_rng(4).uniform(-99.0, 99.0, (2, 300))
    ways = np.stack([x, y, np.full(300, -500.0)])
    ways /= np.linalg.norm(ways, axis=0)
    found = Program(steps[:end], np.float64).run(dict(zip((L, M, N), ways, strict=True)), [A1, A2], 300)
    places = np.stack([(x + 100.0) * 4.5 / 200.0 - 1.5, (y + 100.0) / 100.0])
    np.testing.assert_allclose(found, 2.0 * (places % 1.0) - 1.0, atol=1e-5)


@slow
def test_a_mesh_with_an_image_looks_the_same_beside_another_one():
    """One has fine and one coarse texels, tints and widths of its own; rays to both alternate within each block."""
    random = np.random.default_rng(6)
    square = np.array([[-100.0, -100.0, -500.0], [100.0, -100.0, -500.0], [100.0, 100.0, -500.0],
                       [-100.0, 100.0, -500.0]])
    walls = [lb.Mesh.of(square + [way * 110.0, 0.0, 0.0], [[0, 1, 2], [0, 2, 3]],
                        lb.Material((0.5, 1.0, 2.0), "light", pattern=lb.Pattern("image", image=lb.Image.of(
                            random.uniform(0.1, 1.0, (texels, texels, 3))))),
                        uv=[[0, 0], [1, 0], [1, 1], [0, 1]], colours=random.uniform(0.2, 1.0, (4, 3)))
             for way, texels in ((-1.0, 8), (1.0, 64))]
    ways = np.column_stack([random.uniform(-200.0, 200.0, 1500), random.uniform(-99.0, 99.0, 1500),
                            np.full(1500, -500.0)])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    given = {L: ways[:, 0], M: ways[:, 1], N: ways[:, 2], PIXEL_SPREAD: np.full(1500, 0.02)}       # 10 mm
    both, left, right = (Program(lb.Scene("walls", DARK, meshes=meshes).steps(shadows=False), np.float64).run(
        given, [RED, GREEN, BLUE], 1500) for meshes in (walls, walls[:1], walls[1:]))
    assert both.std() > 0.1
    np.testing.assert_allclose(both, left + right, rtol=1e-12)


@slow
def test_meshes_hide_lights_that_are_traced_to_the_film():
    # a small light, half hidden behind a mesh: traced from the light and seen by the camera alike
    light = lb.Sphere((0.0, 0.0, -2000.0), 6.0, lb.Material((800.0, 700.0, 500.0), "light"))
    screen = lb.Mesh.of([[0.0, -400.0, -1500.0], [400.0, -400.0, -1500.0], [400.0, 400.0, -1500.0],
                         [0.0, 400.0, -1500.0]], [[0, 1, 2], [0, 2, 3]], lb.Material((0.2, 0.2, 0.2)))
    scene = lb.Scene("half", sky=DARK, spheres=(light,), meshes=(screen,))
    camera = lb.PerspectiveCamera(lb.Film(36.0, 24.0, 96, 64), fov=0.2, lens_radius=20.0, focus_distance=1000.0)
    traced = lb.Rendering(camera, scene)
    traced.add(64)
    seen = lb.Rendering(camera, scene, light_tracing=False)
    seen.add(1024)
    assert traced.light_traced == {0}
    assert traced.image().sum() == pytest.approx(seen.image().sum(), rel=0.04)
    dark = replace(scene, meshes=())
    full = lb.Rendering(camera, dark)
    full.add(16)
    assert traced.image().sum() == pytest.approx(0.5 * full.image().sum(), rel=0.05)


@slow
def test_a_sphere_of_triangles_lights_its_surroundings_as_a_sphere_in_closed_form():
    """L r² cos θ / d², exact for a sphere above the horizon; the triangles lie 0.05 % inside the sphere."""
    shining, grey = lb.Material((9.0, 6.0, 3.0), "lamp"), lb.Material((0.5, 0.5, 0.5))
    bulb = sphere_mesh(100, 80.0, (0.0, 0.0, -1000.0), material=shining)
    floor = lb.Disk((0.0, -300.0, 0.0), (0.0, 1.0, 0.0), 5000.0, grey)
    v0, v1 = even_lights(1 << 16)
    for place in ((60.0, -300.0, -900.0), (700.0, -300.0, -1500.0)):
        lit = np.array(place)
        rays = np.tile(lit + [0.0, 1.0, 0.0], (len(v0), 1)), np.tile([0.0, -1.0, 0.0], (len(v0), 1))
        seen = shoot(lb.Scene("bulb", DARK, plates=(floor,), meshes=(bulb,)).steps(), *rays, (v0, v1)).mean(0)
        to = np.array([0.0, 0.0, -1000.0]) - lit
        expected = 0.5 * np.array([9.0, 6.0, 3.0]) * 80.0**2 * to[1] / np.linalg.norm(to) ** 3
        np.testing.assert_allclose(seen, expected, rtol=5e-3)
    # what lies between hides it, and it hides no other light
    lid = lb.Disk((0.0, -150.0, -1000.0), (0.0, 1.0, 0.0), 600.0, grey)
    below = np.tile([0.0, -299.0, -1000.0], (len(v0), 1)), rays[1]
    assert (shoot(lb.Scene("lid", DARK, plates=(floor, lid), meshes=(bulb,)).steps(), *below, (v0, v1)) == 0.0).all()


def test_the_light_of_a_place_of_a_lamp_is_that_of_its_cosines_and_distance():
    """L cos θ cos θ′ A / (π d²), of places that are even over both triangles, a large and a small one."""
    corners = np.array([[-60.0, 200.0, -900.0], [180.0, 210.0, -900.0], [150.0, 240.0, -1200.0],
                        [-90.0, 260.0, -950.0]])
    lamp = lb.Mesh.of(corners, [[0, 1, 2], [0, 2, 3]], lb.Material((9.0, 8.0, 7.0), "lamp"))
    a, b, c = np.moveaxis(corners[[[0, 1, 2], [0, 2, 3]]], 1, 0)
    normals = np.cross(b - a, c - a)
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    n = 4000
    v0, v1 = even_lights(n)
    here, up, ones = np.array([40.0, -250.0, -1000.0]), np.array([0.6, 0.8, 0.0]), np.ones(n)
    rows = dict(zip([X, Y, Z, NX, NY, NZ], np.outer([*here, *up], ones), strict=True))
    rows |= {V0: v0, V1: v1, RED: ones, GREEN: ones, BLUE: ones}
    *ways, far, light = Program([mesh_lamp_step(lamp)], np.float64).run(rows, [A3, A4, A5, A6, A7], n)
    ways, first = np.transpose(ways), v0 < areas[0] / areas.sum()
    np.testing.assert_allclose(np.linalg.norm(ways, axis=1), 1.0, rtol=1e-12)
    met = np.zeros((n, 3))
    for k, mine in enumerate((first, ~first)):
        normal, way = normals[k] / np.linalg.norm(normals[k]), ways[mine]
        d = (a[k] - here) @ normal / (way @ normal)
        met[mine] = here + d[:, None] * way
        wanted = np.maximum(way @ up, 0.0) * abs(way @ normal) * areas.sum() / (math.pi * d**2)
        np.testing.assert_allclose(light[mine], wanted, rtol=1e-5)
        assert (far[mine] < d).all() and (far[mine] > 0.99 * d).all()
    middle = (areas[:, None] * (a + b + c) / 3.0).sum(0) / areas.sum()
    np.testing.assert_allclose(met.mean(0), middle, atol=1.0)


@slow
def test_a_lamp_of_two_triangles_lights_as_a_rectangle():
    corners = [[-60.0, 200.0, -900.0], [180.0, 200.0, -900.0], [180.0, 240.0, -1200.0], [-60.0, 240.0, -1200.0]]
    shining = lb.Material((9.0, 8.0, 7.0), "lamp")
    lamp = lb.Mesh.of(corners, [[0, 1, 2], [0, 2, 3]], shining)
    plate = lb.Rectangle((60.0, 220.0, -1050.0), (120.0, 0.0, 0.0), (0.0, 20.0, -150.0), shining)
    ball = lb.Sphere((30.0, -100.0, -1000.0), 60.0)
    base = lb.Scene("lamp", DARK, floor=lb.Floor(-250.0), spheres=(ball,))
    v0, v1 = even_lights(1 << 16)
    for x in (-200.0, 40.0, 300.0):
        way = np.tile([x, -550.0, -1000.0], (len(v0), 1))
        origins = np.tile([0.0, 300.0, 0.0], (len(v0), 1))
        found, expected = (shoot(replace(base, **lamps).steps(), origins, way, (v0, v1)).mean(0)
                           for lamps in ({"meshes": (lamp,)}, {"plates": (plate,)}))
        np.testing.assert_allclose(found, expected, rtol=5e-3)


@slow
def test_a_small_mesh_that_shines_is_traced_to_the_film_with_the_light_that_rays_find():
    light = sphere_mesh(24, 8.0, (100.0, 40.0, -2500.0), material=lb.Material((800.0, 700.0, 500.0), "light"))
    bar = lb.Mesh.of([[-150.0, 60.0, -2500.0], [-130.0, 60.0, -2500.0], [-140.0, 75.0, -2500.0]], [[0, 1, 2]],
                     lb.Material((900.0, 700.0, 500.0), "light"))
    scene = lb.Scene("bulbs", DARK, meshes=(light, bar))
    camera = lb.PerspectiveCamera(lb.Film(36.0, 24.0, 96, 64), fov=0.2, lens_radius=20.0, focus_distance=1000.0)
    traced, plain = lb.Rendering(camera, scene), lb.Rendering(camera, scene, light_tracing=False)
    traced.add(64)
    plain.add(4096)
    assert traced.light_traced == {0, 1}
    for half in (slice(0, 48), slice(48, 96)):
        assert traced.image()[:, half].sum() == pytest.approx(plain.image()[:, half].sum(), rel=0.02)


def test_a_scene_without_meshes_has_the_stages_it_had():
    scene = lb.builtin_scene("still-life")
    names = {step.kernel.__name__ for step in (*scene.steps(), *scene.depth_steps())}
    assert not names & {"find_meshes", "mesh_surfaces", "mesh_shadows", "gradient_rays"}


@pytest.mark.parametrize(("change", "reason"), [
    ({"faces": np.zeros((0, 3), int)}, "without triangles"), ({"faces": [[0, 1, 3]]}, "does not exist"),
    ({"faces": [[0, 1, -1]]}, "does not exist"), ({"faces": [[0, 1, 1]]}, "has an area"),
    ({"faces": [[0.0, 1.0, 2.0]]}, "whole numbers"), ({"faces": [[0, 1]]}, "whole numbers"),
    ({"vertices": [[0, 0, 0], [1, 0, math.nan], [0, 1, 0]]}, "not finite"),
    ({"vertices": [[0, 0, 0], [1e300, 0, 0], [0, 1, 0]]}, "not finite"),
    ({"vertices": [[0, 0, 0], [1e12, 0, 0], [0, 1, 0]]}, "100 km"),
    ({"vertices": [[0, 0], [1, 0], [0, 1]]}, "shape"), ({"normals": [[0, 0, 1]]}, "as many as"),
    ({"material": lb.Material(kind="lamp"), "colours": np.ones((3, 3))}, "shines evenly"),
    ({"material": lb.Material(kind="glass")}, "close its surface"),
    ({"material": lb.Material(pattern=lb.Pattern("star"))}, "no pattern but"),
    ({"material": lb.Material(pattern=lb.Pattern("image", image=lb.Image.of(np.ones((2, 2, 3)))))}, "uv"),
])
def test_what_no_mesh_can_be_is_one_clear_line(change, reason):
    given = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]], **change}
    with pytest.raises(lb.SceneError, match=reason) as caught:
        lb.Mesh.of(**given)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("count", [8, 40])
def test_the_outline_of_a_mesh_has_the_vertices_that_are_farthest_around_it(count):
    """From +x on, towards +z; what lies between them is not among them."""
    random = np.random.default_rng(2)
    around = 2.0 * np.pi * np.arange(7) / 7 + 0.3
    points = np.column_stack([30.0 * np.cos(around), random.uniform(-9.0, 9.0, 7), 20.0 * np.sin(around)])
    mesh = lb.Mesh.of(np.vstack([points, [[0.0, 50.0, 1.0]]]), [[k, (k + 1) % 7, 7] for k in range(7)])
    ways = np.exp(2j * np.pi * np.arange(count) / count)
    support = (points[:, [0]] * ways.real + points[:, [2]] * ways.imag).max(0)
    outline = mesh.outline(count)
    np.testing.assert_allclose(outline[:, 0] * ways.real + outline[:, 2] * ways.imag, support, rtol=1e-6)


@pytest.mark.slow
def test_a_mesh_is_a_value_with_a_place():
    mesh = lb.Mesh.of([[0, 0, -10], [4, 0, -10], [0, 2, -10], [9, 9, 9]], [[0, 1, 2], [0, 0, 1]], name="sail")
    assert mesh == lb.Mesh.of(mesh.points, mesh.triangles, name="sail") and hash(mesh) == hash(replace(mesh))
    assert mesh.centre == (2.0, 1.0, -10.0) and len(mesh.triangles) == 1
    assert mesh.locate(np.array([1.0, 0.5, -10.0]), 1e-3) == pytest.approx((-1.0, -0.5, 0.0))
    assert mesh.locate(np.array([3.0, 1.5, -10.0]), 1e-3) is None
    assert mesh.label == "sail of 4.47 mm" and len(surfaces((mesh,)).corners) == 1
    assert mesh.outline(8)[:, 0].max() == 9.0


@slow
@pytest.mark.parametrize("spread", [0.0, 0.01, 0.05])
def test_an_image_on_two_triangles_is_as_sharp_as_on_a_rectangle(spread):
    """For footprints of many texels too; float32, as the stages of pictures are."""
    random = np.random.default_rng(1)
    paint = lb.Material((1.0,) * 3, "light", pattern=lb.Pattern("image", image=lb.Image.of(
        random.uniform(0.0, 1.0, (64, 64, 3)))))
    square = [[-100.0, -100.0, -1000.0], [100.0, -100.0, -1000.0], [100.0, 100.0, -1000.0], [-100.0, 100.0, -1000.0]]
    mesh = lb.Mesh.of(square, [[0, 1, 2], [0, 2, 3]], paint, uv=[[0, 0], [1, 0], [1, 1], [0, 1]])
    plate = lb.Rectangle((0.0, 0.0, -1000.0), (100.0, 0.0, 0.0), (0.0, 100.0, 0.0), paint)
    ways = np.column_stack([*random.uniform(-60.0, 60.0, (2, 1024)), np.full(1024, -1000.0)])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    given = {L: ways[:, 0], M: ways[:, 1], N: ways[:, 2], PIXEL_SPREAD: np.full(1024, spread)}
    one, other = (Program([step for step in scene.steps() if ".intersect." in step.kernel.__module__], np.float32).run(
        given, [RED, GREEN, BLUE], 1024) for scene in (lb.Scene("one", plates=(plate,)),
                                                       lb.Scene("other", meshes=(mesh,))))
    assert one.std() > 0.01
    np.testing.assert_allclose(other, one, atol=1e-4)
