"""The same rays through the same lenses in rayoptics, Optiland and batoid: how far they agree, and how fast each is.

Optiland and rayoptics open the files that lensbench writes for them, so that these are tried, too. One thread each,
rims aside, at the d line; printed as the table of docs/benchmark.md. Beside lensbench's reference tracer stands the
one of its pictures, which works in blocks.
"""

import time
import warnings
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.charts.peers import BEFORE, PEERS, batoid_has
from lensbench.app.studies.timing import least_times, machine
from lensbench.core.kernels import block
from lensbench.core.kernels.program import Program
from lensbench.core.optics.block_trace import trace_steps

with warnings.catch_warnings():
    warnings.simplefilter("ignore")         # of the peers' own
    import batoid
    import rayoptics
    from optiland.fileio import load_codev_file, load_optiland_file, load_oslo_file, load_zemax_file
    from rayoptics.environment import open_model

SAME = 1e-4                                 # of focal length, f-number and pupil: peers have other data of some glasses
# What a peer cannot read of a file, by suffix and peer
FLAT = {(".zmx", "optiland"), (".seq", "optiland")}         # no index for a model glass without V_d
ZOOMS = {(".seq", "rayoptics"), (".len", "optiland")}       # no configurations
LENSES = ("pbrt-dgauss-50mm", "lenshh-cooke-triplet-50", "lv-nikon-z-58f095-noct", "lib-us10281683")
RAYS, FEW = 20_000, 200                     # rayoptics traces one ray at a time
# mm on the last surface: rayoptics and batoid stop Newton below 1e-12 mm, Optiland at 1e-10 as our file asks
TOLERANCE = {"rayoptics": 1e-9, "optiland": 1e-8, "batoid": 1e-9}

pytestmark = pytest.mark.filterwarnings("ignore")


def bundle(lens, count):
    """Rays from a plane before the lens towards its entrance pupil, in the middle half of aperture and field."""
    rng = np.random.default_rng(7)
    pupil = lb.first_order(lens).entrance_pupil
    aim = 0.5 * pupil.radius * np.sqrt(rng.random((count, 1))) * _round(rng, count)
    slope = 0.1 * np.sqrt(rng.random((count, 1))) * _round(rng, count)
    origins = np.column_stack([aim - slope * (pupil.z + BEFORE), np.full(count, -BEFORE)])
    directions = np.column_stack([slope, np.ones(count)])
    return origins, directions / np.linalg.norm(directions, axis=1)[:, None]


def _round(rng, count):
    angle = 2.0 * np.pi * rng.random(count)
    return np.column_stack([np.cos(angle), np.sin(angle)])


def in_blocks(lens, origins, directions, real):
    """The tracer of the pictures, from arrays to arrays: a call that gives l, m, n behind the lens, and the weight."""
    distance, count = lb.film_distance(lens, np.inf), len(origins)
    program = Program(trace_steps(lens, distance, towards="film", blades=False), real)
    rays = dict(zip((block.X, block.Y, block.Z), (origins - [0.0, 0.0, lens.length + distance]).T, strict=True))
    rays |= dict(zip((block.L, block.M, block.N), directions.T, strict=True)) | {block.WEIGHT: np.ones(count)}
    return lambda: program.run(rays, [block.L, block.M, block.N, block.WEIGHT], count)


def test_peers_agree_and_how_fast_they_are(tmp_path, capsys):
    rows = []
    for name in LENSES:
        lens = lenses.load(name)
        origins, directions = bundle(lens, RAYS)
        ours = lb.trace(lens, origins, directions, clip=False)
        assert (ours.fate == lb.Fate.PASSED).all()
        works: dict[str, Callable[[], object]] = {"reference": partial(lb.trace, lens, origins, directions, clip=False)}
        counts, apart = dict.fromkeys(("reference", "float64", "float32"), RAYS), {}
        for real, tolerance in ((np.float64, 1e-12), (np.float32, 1e-5)):      # the rounding of thirty surfaces
            works[np.dtype(real).name] = work = in_blocks(lens, origins, directions, real)
            result = np.asarray(work())
            passed = result[3] > 0.0                     # blocks clip at the rims
            assert passed.mean() > 0.5 and np.abs(result[:3].T - ours.directions)[passed].max() < tolerance
        for peer, open_in in PEERS.items():
            if peer == "batoid" and not all(batoid_has(surface) for surface in lens.surfaces):
                continue
            count = counts[peer] = FEW if peer == "rayoptics" else RAYS
            works[peer] = work = partial(open_in(lens, tmp_path), origins[:count], directions[:count])
            apart[peer] = float(np.abs(work() - ours.points[:count]).max())
            assert apart[peer] < TOLERANCE[peer], (name, peer)
        best = least_times(works, 1.0)
        speed = {work: f"{counts[work] / best[work] / 1e6:.2g}" for work in best}
        aspheres = sum(not s.is_spherical for s in lens.surfaces)
        cells = [speed["reference"], speed["float64"], speed["float32"]]
        cells += [f"{speed[peer]}; {apart[peer]:.0e}" if peer in apart else "not traced" for peer in PEERS]
        rows.append(f"| {name}, {len(lens.surfaces)} surfaces, {aspheres} aspheric | {' | '.join(cells)} |")
    heads = ["lens", "`lb.trace`", "blocks, float64", "blocks, float32", *PEERS]
    with capsys.disabled():
        print(f"\n{machine()}, {time.strftime('%Y-%m-%d')}; rayoptics {rayoptics.__version__}, "
              f"batoid {batoid.__version__}; Mrays/s, and the largest difference in mm")
        print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
        print("\n".join(rows))


def in_rayoptics(path):
    """Focal length, f-number and entrance pupil (mm) of a file in rayoptics."""
    first = open_model(path)["analysis_results"]["parax_data"].fod
    return first.efl, first.fno, 2.0 * first.enp_radius


def in_optiland(path):
    """The same in Optiland."""
    load = {".zmx": load_zemax_file, ".json": load_optiland_file, ".seq": load_codev_file, ".len": load_oslo_file}
    lens = load[path.suffix](str(path)).paraxial
    return float(lens.f2()), float(lens.FNO()), float(lens.EPD())


@pytest.mark.parametrize(("suffix", "peer"), [
    (".zmx", "rayoptics"), (".seq", "rayoptics"), (".roa", "rayoptics"), (".zmx", "optiland"), (".json", "optiland"),
    (".seq", "optiland"), (".len", "optiland")])
def test_every_lens_of_the_library_opens_right_in_the_peer(tmp_path, suffix, peer):
    wrong: list[tuple] = []
    for name in lenses.names():
        lens = lenses.load(name)
        flat = any(s.glass.n_d > 1.0 and not s.glass.disperses for s in lens.surfaces)
        if not lens.is_rotationally_symmetric or (flat and (suffix, peer) in FLAT) or (
                lens.positions is not None and (suffix, peer) in ZOOMS):
            continue
        lenses.save(lens, tmp_path / f"{name}{suffix}")
        if (suffix, peer) == (".zmx", "optiland") and any(
                kind in (tmp_path / f"{name}{suffix}").read_text() for kind in ("XASPHERE", "XODDASPH")):
            continue                            # it has no extended aspheres
        first = lb.first_order(lens)
        ours = np.array([first.efl, first.f_number, 2.0 * first.entrance_pupil.radius])
        try:
            points = (in_rayoptics if peer == "rayoptics" else in_optiland)(tmp_path / f"{name}{suffix}")
        except Exception as error:              # of any kind: the other lenses are tried, too
            wrong.append((name, repr(error)))
            continue
        if not np.abs(np.array(points) / ours - 1.0).max() < SAME:
            wrong.append((name, points, tuple(ours)))
    assert not wrong
