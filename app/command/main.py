"""The command `lensbench`: open the bench, render a picture, print the data of a lens.

The exit code is 2 for bad input, with one line on stderr; 1 for a failure of the program, with its traceback where
LENSBENCH_DEBUG is set; 130 for Ctrl-C. Each command imports the heavy modules that it needs.
"""

import argparse
import ctypes
import math
import os
import signal
import sys
from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Any, NoReturn

from lensbench.app.command.errors import UsageError
from lensbench.app.command.output import print_json, progress
from lensbench.kernels.figures import f_number_text, fixed, significant

SCREENSHOT = "lensbench-window.png"     # where there is no display
LIBRARIES = ("libEGL.so.1", "libGL.so.1", "libX11.so.6", "libXext.so.6")
PIXELS = 960                            # across a picture, for intrinsics: as the bench has it
PACKAGES = "libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libx11-6 libxext6"     # that bring them, on Debian and Ubuntu


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message} (see {self.prog} --help)")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with these arguments (those of the process when None) and return its exit code."""
    try:
        code = _run(list(sys.argv[1:] if argv is None else argv))
        sys.stdout.flush()                              # here, where a closed pipe can be handled
        return code
    except SystemExit as ended:                         # --help, --version, a termination
        return ended.code if isinstance(ended.code, int) else 0
    except KeyboardInterrupt:
        return _end("stopped", 130)
    except BrokenPipeError:                             # the reader of the output has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        if os.environ.get("LENSBENCH_DEBUG"):
            raise
        if isinstance(error, _mistakes()):
            return _end(str(error), 2)
        return _end(f"failed: {type(error).__name__}: {error} (LENSBENCH_DEBUG=1 shows where)", 1)


def _run(argv: list[str]) -> int:
    if argv[:1] == ["bench"]:
        from lensbench.app.studies.benchmark.main import main as benchmark
        return benchmark(argv[1:]) or 0
    arguments = _parser().parse_args(argv or ["view"])
    return arguments.command(arguments)


def _end(message: str, code: int) -> int:
    print("lensbench: " + " ".join(message.split()), file=sys.stderr)
    return code


def _mistakes() -> tuple[type[Exception], ...]:
    """The errors that bad input can cause; their messages say what to do."""
    import lensbench as lb
    from lensbench import lenses
    from lensbench.app.command.lens_files import RaysError
    from lensbench.app.files.export import ExportError
    from lensbench.app.state.scene_file import SceneFileError
    from lensbench.app.state.settings import SettingsError

    return (UsageError, SettingsError, ExportError, SceneFileError, RaysError, lenses.LensFileError, lb.LensError,
            lb.LightFieldError, lb.GlassError, lb.MediumError, lb.ExposureError, lb.TransformError,
            lb.FilmError, lb.CameraError, lb.SceneError)


def _parser() -> argparse.ArgumentParser:
    from lensbench.app.command import chart, check, lens_files, library, light_field
    from lensbench.app.command.options import (
        add_close_option,
        add_lens_options,
        add_picture_options,
        option,
    )
    from lensbench.app.command.stability import add_stability_options, stability
    from lensbench.app.state.text_values import read_count

    parser = _Parser("lensbench", description="A bench of lenses and cameras: a real lens, rendered live, beside its "
                     "section. Without a command it opens the bench.")
    parser.add_argument("--version", action="version", version=f"lensbench {version('lensbench')}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)

    def command(name: str, run, summary: str) -> argparse.ArgumentParser:
        made = commands.add_parser(name, help=summary, description=summary)
        made.set_defaults(command=run)
        return made

    lens_help = "a lens of the library (see `lensbench lenses`), a lens file, or an exported picture with its settings"
    view = command("view", _view, "Open the bench on a lens and a scene.")
    view.add_argument("lens", nargs="?", metavar="LENS", help=lens_help)
    add_picture_options(view)
    view.add_argument("--screenshot", metavar="FILE.png",
                      help="write a picture of the whole window and end; needs no display")

    render = command("render", _render, "Render a picture through a lens.")
    render.add_argument("lens", nargs="?", metavar="LENS",
                        help=f"{lens_help}; not needed with --settings, or for a --camera without a lens")
    add_picture_options(render)
    render.add_argument("-o", "--output", required=True, metavar="FILE",
                        help="developed picture (.png, .ppm) or linear light (.exr, .pfm)")
    render.add_argument("--bits", type=int, choices=(8, 16), default=8, help="depth of a PNG or PPM")
    render.add_argument("--text", action="store_true", help="write a PPM as numbers in text (P3)")
    render.add_argument("--save-settings", metavar="FILE.toml",
                        help="write the settings too, to be read by --settings or changed by hand")
    render.add_argument("--threads", type=option(read_count), metavar="N", help="threads; one a core by default")
    render.add_argument("--json", action="store_true", help="print the result as JSON")

    info = command("info", _info, "Print provenance, first-order data, glasses and check of a lens.")
    info.add_argument("lens", metavar="LENS", help="a lens of the library, or a lens file")
    add_lens_options(info)
    add_close_option(info)
    info.add_argument("--json", action="store_true", help="print JSON: lengths in mm, angles in degrees")

    library.add_library_options(command("lenses", library.library, "List the lenses of the library."))

    check.add_check_options(command("check", check.check, "Report what looks wrong in lens files."))
    lens_files.add_convert_options(command("convert", lens_files.convert,
                                              "Write a lens file in the format of another program."))
    lens_files.add_trace_options(command("trace", lens_files.trace, "Trace a table of rays through a lens."))

    light_field.add_light_field_options(command(
        "lightfield", None, "Record a light field through a lens; focus it afterwards."))
    chart.add_chart_options(command("chart", chart.chart,
                                            "Chart the speed of methods against their accuracy."))
    add_stability_options(command("stability", stability,
                                  "Show where each numerical method breaks down, and what it returns there."))
    commands.add_parser("bench", help="Measure the program's speed on this machine.", add_help=False)
    return parser


def _view(arguments: argparse.Namespace) -> int:
    from lensbench.app.command.options import settings_from

    settings = settings_from(arguments)
    missing = [name for name in LIBRARIES if not _loads(name)] if sys.platform == "linux" else []
    if missing:
        raise UsageError(f"the window needs {', '.join(missing)}: on Debian or Ubuntu, apt-get install {PACKAGES}")
    from lensbench.app.window import window

    screenshot = arguments.screenshot or (None if _has_display() else SCREENSHOT)
    if screenshot is None:
        window.run(settings)
        return 0
    try:
        is_early = window.run(settings, screenshot=Path(screenshot))
    except OSError as error:
        raise UsageError(f"{screenshot}: {error.strerror}" if error.strerror else str(error)) from error
    why = "" if arguments.screenshot else "no display: "
    print(f"{why}wrote the window to {screenshot}")
    if is_early:
        print("lensbench: the picture was not ready in time, the screenshot shows the window without it: "
              "run the command again, the kernels are compiled then", file=sys.stderr)
        return 1
    return 0


def _has_display() -> bool:
    if sys.platform != "linux":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def _render(arguments: argparse.Namespace) -> int:
    from lensbench.app.command.options import settings_from
    from lensbench.app.files.export import export_render
    from lensbench.app.files.settings_file import save_settings
    from lensbench.app.state.auto_model import choice_summary, record
    from lensbench.app.state.camera_kinds import CAMERA_KINDS
    from lensbench.app.workers.warm_cache import compile_ahead

    needs_lens = CAMERA_KINDS[arguments.camera or "lens"].has_lens
    if needs_lens and arguments.lens is None and arguments.settings is None:
        raise UsageError("which LENS? Name one, an exported picture, or --settings (see lensbench render --help)")
    settings = settings_from(arguments)
    if arguments.save_settings is not None:
        save_settings(arguments.save_settings, settings)
    compile_ahead(settings.scene)
    # Let a termination unwind, so that a half-written file is removed
    former = signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    started = perf_counter()
    chosen: list[Any] = []                              # the choice of the automatic model, if any
    try:
        with progress() as show:
            export_render(settings, arguments.output, bits=arguments.bits, progress=show, threads=arguments.threads,
                          text=arguments.text, on_choice=chosen.append)
    finally:
        signal.signal(signal.SIGTERM, former)
    seconds = perf_counter() - started
    across, down = settings.pixels_x, settings.pixels_y
    if arguments.json:
        print_json({"path": arguments.output, "pixels": [across, down], "samples": settings.samples,
                    "seconds": seconds, "samples_per_second": across * down * settings.samples / seconds,
                    "chosen": record(chosen[0]) if chosen else None})
    else:
        each = f"{settings.samples} sample{'s' if settings.samples > 1 else ''} each"
        print(f"{arguments.output}: {across} × {down} pixels, {each}, {fixed(seconds, 1)} s")
        if chosen:
            print(", ".join(choice_summary(chosen[0], None)))
    return 0


def _info(arguments: argparse.Namespace) -> int:
    import lensbench as lb
    from lensbench.app.command import lens_card
    from lensbench.app.state.build import design
    from lensbench.app.state.coating import AUTO, coating
    from lensbench.app.state.settings import Settings
    from lensbench.app.state.zoom import positioned, station_lines, stations
    from lensbench.lenses.paraxial import is_d_line

    lens = design(replace(Settings(), lens=arguments.lens, focal_length=arguments.focal_length).checked())
    card = lens_card.lens_card(lens)
    lens = positioned(lens, arguments)
    if getattr(arguments, "f_number", None) is not None:
        lens = lb.stopped_down(lens, arguments.f_number)
    assumed = coating(replace(Settings(), coating=arguments.coating or AUTO), lens)
    data = {**_lens_data(lens, assumed.name), **card, "coating": assumed.name, "positions": stations(lens)}
    if arguments.json:
        print_json({"units": {"length": "mm", "angle": "degrees"}, **data})
        return 0
    rows = [(label, text(data[key]) if data[key] is not None else "not known") for key, label, text in (
        ("efl", "Effective focal length", _mm),
        *([("efl_across", "  across, in the section x–z", _mm)] if data["efl_across"] is not None else []),
        ("stated_efl", "  as published", lambda length: f"{significant(length)} mm"),
        ("f_number", "f-number", lambda number: f_number_text(number, 2)),
        ("t_number", "T-number", lambda number: f"{f_number_text(number, 2, 'T/')}, {assumed.name}: {assumed.why}"),
        ("bfl", "Back focus", _mm),
        *([("bfl_across", "  across, in the section x–z", _mm)] if data["bfl_across"] is not None else []),
        ("ffl", "Front focus", _mm),
        ("front_principal", "Front principal plane, from the first vertex", _mm),
        ("rear_principal", "Rear principal plane, from the last vertex", _mm))]
    rows += [(label, f"{_mm(data[key]['z'])}, radius {_mm(data[key]['radius'])}") for key, label in (
        ("entrance_pupil", "Entrance pupil, from the first vertex"),
        ("exit_pupil", "Exit pupil, from the first vertex"))]
    view = data["field_of_view"]
    rows += [("Petzval radius", f"{fixed(data['petzval_radius'], 1)} mm"),
             ("Nearest focus, from the film", "none: it forms no real image" if data["nearest_focus"] is None
              else f"{fixed(data['nearest_focus'] / 1000.0, 3)} m"),
             ("Field of view on 36 × 24, h × v, diagonal",
              f"{fixed(view['horizontal'], 1)}° × {fixed(view['vertical'], 1)}°, {fixed(view['diagonal'], 1)}°")]
    if data["intrinsics"]:
        pixels = data["intrinsics"]
        rows.append((f"Intrinsics at {pixels['width']} × {pixels['height']} pixels of that film",
                     f"fx {fixed(pixels['fx'], 2)}, fy {fixed(pixels['fy'], 2)}, cx {fixed(pixels['cx'], 2)}, cy "
                     f"{fixed(pixels['cy'], 2)}"))
    if not is_d_line(data["wavelength"]):
        rows.insert(0, ("Figures at the primary wavelength", f"{significant(1000.0 * data['wavelength'])} nm"))
    year = f"{data['year']}{lens_card.star(card, 'year')}" if data["year"] else ""
    print(", ".join(word for word in (data["name"] or arguments.lens, data["kind"], year) if word))
    print("\n".join([*lens_card.card_lines(card, data["source"]),
                     *(f"{label:{lens_card.WIDTH}}{text}{lens_card.star(card, label)}" for label, text in rows),
                     *station_lines(data["positions"]), *lens_card.glass_lines(card)]))
    print("".join(f"Found: {finding}\n" for finding in data["findings"]), end="")
    return 0


def _mm(length: float) -> str:
    """A length in mm to the micrometre."""
    return f"{fixed(length, 3)} mm"


def _lens_data(lens, coating: str) -> dict[str, Any]:
    """The figures of `lensbench info`: lengths in mm, angles in degrees (by efl, distortion left out)."""
    import lensbench as lb
    from lensbench.lenses.paraxial import reference_wavelength

    wavelength = reference_wavelength(lens.surfaces, lens.system)
    fo = lb.first_order(lens, wavelength)
    try:
        nearest = lb.nearest_focus(lens)
    except lb.FocusError:                               # it does not converge: the other figures stand
        nearest = None
    across = None if lens.is_rotationally_symmetric else lb.first_order(lens.section("x"), wavelength)
    squeeze = fo.efl / across.efl if across and math.isfinite(fo.efl) and math.isfinite(across.efl) else 1.0
    film = lb.Film(36.0 * abs(squeeze), 24.0)               # as wide as what a lens with cylinders squeezes into it
    return {
        "name": lens.name, "kind": lens.kind, "year": lens.year, "source": lens.source,
        "stated_efl": lens.stated_efl, "stated_f_number": lens.stated_f_number,
        "surfaces": len(lens.surfaces), "stop_index": lens.stop_index, "length": lens.length,
        "wavelength": wavelength, "efl": fo.efl, "bfl": fo.bfl, "ffl": fo.ffl, "f_number": fo.f_number,
        "efl_across": across and across.efl, "bfl_across": across and across.bfl,
        "t_number": lb.t_number(lens, coating), "transmission": lb.transmission(lens, coating=coating),
        "front_principal": fo.front_principal, "rear_principal": fo.rear_principal,
        "entrance_pupil": {"z": fo.entrance_pupil.z, "radius": fo.entrance_pupil.radius},
        "exit_pupil": {"z": fo.exit_pupil.z, "radius": fo.exit_pupil.radius},
        "petzval_radius": fo.petzval_radius, "stop_radius": fo.stop_radius,
        "nearest_focus": nearest,
        "field_of_view": {axis: math.degrees(lb.field_of_view(abs(fo.efl), film, axis))
                          for axis in ("horizontal", "vertical", "diagonal")},
        "intrinsics": _intrinsics(lens, film),
        "findings": [str(finding) for finding in lens.findings],
    }


def _intrinsics(lens, film) -> dict[str, float] | None:
    """Focal length and principal point in pixels, of a film of PIXELS across, focused at infinity.

    None where the lens forms no image there, and of one with cylinders, which has two focal lengths.
    """
    import lensbench as lb

    if not lens.is_rotationally_symmetric:
        return None
    film = replace(film, pixels_x=PIXELS, pixels_y=round(PIXELS * film.height / film.width))
    try:
        found = lb.LensCamera(lens, film).intrinsics
    except (lb.FocusError, lb.CameraError):
        return None
    return {"width": film.pixels_x, "height": film.pixels_y, **found._asdict()}


if __name__ == "__main__":
    sys.exit(main())
