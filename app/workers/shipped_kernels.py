"""Compile the kernels that a wheel carries: `python -m lensbench.app.workers.shipped_kernels FOLDER`.

Small pictures of every camera kind, lens shape and scene, and the figures of every panel, ask for the kernels; every
stage of the sources is one too. A function of the sources that nothing asks for (`called_kernels`) ends the build. All
are compiled for every level of x86-64, also for those that this processor cannot run, and packed into FOLDER/LEVEL.zip,
where `lensbench.core.kernels.cache` finds them in an installed package.
"""

import ast
import inspect
import os
import pickle
import pkgutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher

import lensbench as lb
from lensbench import app, core, lenses
from lensbench.app.scenes.sky_picture import read_hdr
from lensbench.app.session.export import replacing
from lensbench.app.workers.kernel import Kernel
from lensbench.app.workers.task import thread_count
from lensbench.core.kernels import cache
from lensbench.core.kernels.program import stage_signature
from lensbench.core.rendering.sample_allocation import EVEN
from lensbench.core.rendering.temporal_reuse import Reusable
from lensbench.core.scenery.builtin.library import lamps_scene
from lensbench.core.scenery.shading.many_lamps import MANY_LAMPS
from lensbench.core.text import fixed

STAGE = ("lanes", "p", "ints", "key")           # arguments of a stage
ELSEWHERE = "lensbench.app.studies.", "lensbench.app.benchmark."        # they compile their own


def called_kernels() -> dict[tuple[str, str], Any]:
    """Compiled functions by module and name."""
    kernels: dict[tuple[str, str], Any] = {}
    for package in (core, lenses, app):
        for info in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not info.name.startswith(ELSEWHERE) and not info.name.endswith("__main__"):      # which runs
                for kernel in _named(import_module(info.name)):
                    kernels[kernel.py_func.__module__, kernel.py_func.__qualname__] = kernel
    return {key: kernel for key, kernel in kernels.items() if not key[0].startswith(ELSEWHERE)}


def is_stage(kernel: Any) -> bool:
    """Whether a compiled function is a stage, which all have the same signature."""
    return tuple(inspect.signature(kernel.py_func).parameters) == STAGE


def _named(module: ModuleType) -> Iterator[Any]:
    """The compiled functions that the Python code of a module names."""
    waiting: list[ast.AST] = [ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))]
    while waiting:
        node, value = waiting.pop(), None
        if isinstance(node, ast.FunctionDef) and _is_compiled(module, node):
            continue
        if isinstance(node, ast.Attribute) and node.attr == "py_func":      # is not compiled
            continue
        if isinstance(node, ast.Name):
            value = vars(module).get(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            home = vars(module).get(node.value.id)
            value = getattr(home, node.attr, None) if isinstance(home, ModuleType) else None
        if isinstance(value, Dispatcher):
            yield value
        waiting += ast.iter_child_nodes(node)


def _is_compiled(module: ModuleType, node: ast.FunctionDef) -> bool:
    """Whether numba compiles a function, or reads it while it does."""
    value, lines = vars(module).get(node.name), [decorator.lineno for decorator in node.decorator_list]
    if isinstance(value, Dispatcher):               # and no method of the same name
        return value.py_func.__code__.co_firstlineno in lines
    return any("overload" in ast.unparse(mark) or "intrinsic" in ast.unparse(mark) for mark in node.decorator_list)


LENSES = ("pbrt-dgauss-50mm",                       # spheres
          "pbrt-fisheye-10mm",
          "lv-nikon-z-58f095-noct",                 # conics and even powers
          "lib-us7558005a",                         # a phone lens
          "lib-us10281683",                         # odd powers
          "lentil-schneider-anamorphic-31-2001",    # cylinders
          "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed")


def pictures() -> Iterator[Any]:
    """Settings of one small picture for each kind of camera, lens, scene and view."""
    from lensbench.app.bench.constraints import with_camera
    from lensbench.app.bench.lens_choice import with_lens
    from lensbench.app.settings.camera_facts import CAMERA_KINDS, LENS_MODELS
    from lensbench.app.settings.settings import Settings

    plain = Settings(pixels_x=48, pixels_y=32, samples=2)
    for name in CAMERA_KINDS:
        yield with_camera(plain, name)
    for model in LENS_MODELS:
        yield replace(plain, lens_model=model)
    for lens in LENSES:
        opened = with_lens(plain, lens)
        yield replace(opened, lens_model="trace")
        yield opened
    for scene in lb.SCENES:
        yield replace(plain, scene=scene)
        yield replace(plain, scene=scene, lens_model="trace", shutter=0.02, end_position=(20.0, 0.0, 0.0))
    for view in lb.VIEWS:
        yield replace(plain, view=view)
    yield replace(plain, medium="fog")
    yield replace(plain, medium="water", lens_model="trace")
    yield replace(plain, blades=7, roundness=0.3)
    yield replace(plain, dispersion="on", lens_model="trace")
    yield replace(plain, light_tracing=False)
    for model in LENS_MODELS:
        yield replace(plain, lens_model=model, tilt=0.05)
    yield replace(with_lens(plain, LENSES[5]), lens_model="trace", tilt=0.05)
    yield replace(plain, scene="night-lights", ghosts=True, stars=True)


def cameras() -> Iterator[lb.LensCamera]:
    """Cameras that no lens of the library gives: with tilted surfaces, and with a picture in the stop."""
    lens, film = lb.stopped_down(lenses.load(LENSES[0]), 4.0), lb.Film(36.0, 24.0, 48, 32)
    bent = replace(lens, surfaces=tuple(replace(surface, pose=lb.SurfacePose(tilt_x=0.01)) if i < 2 else surface
                                        for i, surface in enumerate(lens.surfaces)))
    pictured = replace(lens, stop_image=lb.StopImage.of(np.eye(8) + 0.5 * np.eye(8)[::-1]))
    for pose in (lb.FilmPose(), lb.FilmPose(tilt=0.05)):
        yield lb.LensCamera(bent, film, 1500.0, film_pose=pose)
        for model in ("trace", "thick"):
            yield lb.LensCamera(pictured, film, 1500.0, model=model, film_pose=pose)
    yield lb.LensCamera(replace(bent, stop_image=pictured.stop_image), film, 1500.0)


def exercise(progress: Any = print) -> None:
    """Ask for the kernels of every picture and panel."""
    from lensbench.app.bench.auto_model import choose, is_automatic
    from lensbench.app.bench.build import bench_of, flare
    from lensbench.app.bench.camera_kinds import camera
    from lensbench.app.scenes.scene_file import find_scene
    from lensbench.app.workers.compilers import prepare

    shown = set()
    for settings in pictures():
        made: Any = camera(settings)
        scene = find_scene(settings.scene)
        if is_automatic(settings):
            made = choose(settings, made, scene, None).choice.applied(made)
        rendering = lb.Rendering(made, scene, view=settings.sample_view,
                                 light_tracing=settings.light_tracing, flare=flare(settings))
        rendering.add(1, threads=2)
        rendering.add(1, threads=2)
        rendering.image()
        counts = np.ones(rendering.shape, np.float32)
        before = Reusable(made, rendering.camera_image(), counts, lb.depth_map(made, scene))
        if rendering.layer() is not None:
            lb.Rendering(made, scene, layer=rendering.layer()).add(1, threads=2)
        with ThreadPoolExecutor(2) as pool:
            carried = before.carried(made, pool, 2)
            if carried is not None:
                carried.mixed(rendering.camera_image(), 2, pool, 2)
        if settings.has_lens and settings.lens not in shown:
            shown.add(settings.lens)
            prepare(settings)
            analyses(settings)
            built, radii = bench_of(settings), np.linspace(0.0, 20.0, 9)
            if built.lens.is_rotationally_symmetric:
                lb.falloff(built.lens, built.film_distance, radii)
                lb.distortion(built.lens, built.film_distance, radii)
                lb.distortion_grid(built.lens, built.film_distance, built.film)
        progress(f"{len(cache.used)} kernels: {settings.camera} {settings.lens_model} {settings.lens} "
                 f"{settings.scene} {settings.view}")
    for view_of_lens in cameras():
        for scene in (lb.builtin_scene("still-life"), lb.builtin_scene("night-lights")):
            rendering = lb.Rendering(view_of_lens, scene)
            rendering.add(1, threads=2)
            rendering.add(1, threads=2)
            lb.depth_map(view_of_lens, scene)
        view_of_lens.raster_from_point(np.array([[0.0, 0.0, -1500.0]]))
    progress(f"{len(cache.used)} kernels with those of tilted lenses and pictures in the stop")
    small, scene = lb.Film(36.0, 24.0, 24, 16), lb.builtin_scene("still-life")
    crowded, wall = lamps_scene(2 * MANY_LAMPS), lb.Mesh.of([[0, 0, -900], [90, 0, -900], [0, 90, -900]], [[0, 1, 2]])
    for lit in (crowded, replace(crowded, meshes=(wall,))):
        lb.Rendering(lb.PerspectiveCamera(small), lit).add(1, threads=2)
    lb.Rendering(lb.PerspectiveCamera(small), scene).add(EVEN, threads=2)           # and share out later samples
    view = lb.LensCamera(lenses.load(LENSES[0]), small, 1200.0, 2.8, model="trace")
    field = lb.capture_light_field(view, scene, views=(3, 3), samples=2)
    field.refocus(2000.0)
    field.refocus(900.0, f_number=5.6)
    lb.find_depth(field)
    lb.PlenopticCamera(view, 5).expose(scene, 2, 0).decoded().refocus(1500.0)
    lumigraph = lb.capture_lumigraph(lb.PerspectiveCamera(small), scene, views=(3, 3), distance=1200.0, samples=1)
    lumigraph.seen_by(lb.PerspectiveCamera(small))
    progress(f"{len(cache.used)} kernels with those of light fields")
    lens = lenses.load("lenshh-cooke-triplet-50")
    lb.tolerances.sensitivities(lens)
    lb.tolerances.production(lens, copies=2)
    lb.astigmatic_foci(lens, 0.2)
    lb.analysis.light_budget(lens, (0.0, 0.0, -100.0), (0.0, 0.0, 1.0))
    replace(scene, meshes=(wall,)).distance([[0.0, 0.0, 0.0]], [[0.0, 0.0, -1.0]])
    lb.Sensor().record(np.ones((2, 2, 3), np.float32), 100.0)
    with tempfile.TemporaryDirectory() as folder:
        sky = Path(folder) / "sky.hdr"
        sky.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x80")
        read_hdr(sky, 1)
    progress(f"{len(cache.used)} kernels with those of manufacture, single rays, the sensor and skies")


def analyses(settings: Any) -> None:
    """Compute every figure of the analysis panels that this lens has."""
    from lensbench.app.plots.catalogue import ANALYSES
    from lensbench.app.plots.light_plots import Ripple, bokeh_figure
    from lensbench.app.plots.point_plots import mtf_field_figure
    from lensbench.app.plots.query import query

    bladed = query(replace(settings, blades=7))
    for asked, make in ((query(settings), [analysis.figure for analysis in ANALYSES.values()]),
                        (query(settings), [partial(mtf_field_figure, method="geometric"),
                                           partial(bokeh_figure, ripple=Ripple(0, 1.0, 1e-4))]),
                        (bladed, [ANALYSES["spots"].figure, ANALYSES["sunstar"].figure])):
        for figure in make:
            with suppress(lb.LensError):
                figure(asked, 16)


def asked(listed: Path) -> None:
    """Write the kernels that the exercise asks for to a file.

    A process that compiles a kernel also asks for all that the kernel calls. A process that finds it compiled does not,
    and a wheel needs no more: these are asked anew in a second process, after the first has compiled what was missing.
    """
    exercise()
    kernels = [Kernel.of(*call) for call in cache.used.values()]
    shipped = {(kernel.module, kernel.name) for kernel in kernels}
    left = {key: kernel for key, kernel in called_kernels().items() if key not in shipped}
    kernels += [Kernel(*key, stage_signature(np.float32)) for key, kernel in left.items() if is_stage(kernel)]
    if unknown := [".".join(key) for key, kernel in left.items() if not is_stage(kernel)]:
        sys.exit(f"no picture or figure of `exercise` asks for {', '.join(sorted(unknown))}: add one that does")
    listed.write_bytes(pickle.dumps(kernels))


def main(folder: Path) -> None:
    """Compile and pack the kernels of every level.

    As many processes as there are cores compile each level, neighbours in the list together, for these call the same
    functions. On the machine of the tests the kernels of its own level are there, and all cores have the other level.
    """
    folder.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "lensbench.app.workers.shipped_kernels"]
    with tempfile.TemporaryDirectory() as scratch:
        listed, kept = Path(scratch) / "kernels", None
        while kept != (stored := {*cache.folder.glob("*.kernel")}):     # once more where kernels were compiled
            kept = stored
            if subprocess.run([*command, "--asked", str(listed)]).returncode:
                sys.exit("the kernels could not be listed")
        shares = [f"{i}/{thread_count()}" for i in range(thread_count())]
        working = {level: [subprocess.Popen([*command, "--compile", str(listed), share], stdout=subprocess.PIPE,
                                            text=True, env={**os.environ, "LENSBENCH_LEVEL": level})
                           for share in shares] for level in cache.LEVELS}
        files = {level: {Path(line) for process in processes for line in process.communicate()[0].splitlines()}
                 for level, processes in working.items()}
        if any(process.returncode for processes in working.values() for process in processes):
            sys.exit("the kernels could not be compiled")
    for level in cache.LEVELS:
        archive = folder / f"{level}.zip"
        with replacing(archive) as partial_file, zipfile.ZipFile(
                partial_file, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as packed:
            for file in sorted(files[level]):
                packed.write(file, file.name)
        print(f"{archive}: {fixed(archive.stat().st_size / 1e6, 1)} MB")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--asked", listed]:
            asked(Path(listed))
        case ["--compile", listed, share]:
            index, count = map(int, share.split("/"))
            kernels = pickle.loads(Path(listed).read_bytes())
            ends = [len(kernels) * k // count for k in (index, index + 1)]
            print("\n".join(str(path) for path in [kernel.compile() for kernel in kernels[slice(*ends)]]))
        case [folder]:
            main(Path(folder))
