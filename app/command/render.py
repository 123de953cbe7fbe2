"""The command `lensbench render`: one picture, or the frames of a camera or scene that moves."""

import argparse
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from lensbench.app.command.output import UsageError, print_json, progress, stop_signals
from lensbench.core.text import fixed, significant

if TYPE_CHECKING:
    from lensbench.app.session.picture_render import Rendered
    from lensbench.app.settings.settings import Settings

MOST_SAMPLES = 1 << 16          # where the noise is to end the render and no number of samples is given
MOST_FRAMES = 100_000


def add_render_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench render`."""
    from lensbench.app.command.lens_options import LENS_HELP, option
    from lensbench.app.command.options import add_picture_options
    from lensbench.app.settings.text_values import read_count, read_percent

    add = parser.add_argument
    add("lens", nargs="?", metavar="LENS",
        help=f"{LENS_HELP}; not needed with --settings, or for a --camera without a lens")
    add_picture_options(parser)
    add("-o", "--output", required=True, metavar="FILE",
        help="developed picture (.png, .ppm) or linear light (.exr, .pfm)")
    add("--bits", type=int, choices=(8, 16), help="depth of a PNG or PPM; 8 by default")
    add("--text", action="store_true", help="write a PPM as numbers in text (P3)")
    add("--until-noise", type=option(read_percent), metavar="PART",
        help="render until the noise of the developed picture is at most this part of white, such as 1%%; --samples "
             f"are then the most, {MOST_SAMPLES} by default")
    add("--resume", action="store_true",
        help="keep the samples next to the picture, in FILE.part.npz, while it is rendered and when Ctrl-C or a "
             "termination stops it; go on from such a file. With --frames, leave out the frames "
             "that are there, newer than the files of lens and scene")
    add("--frames", type=option(read_count), metavar="N",
        help="render so many frames, evenly spaced over --duration, to FILE-0001 and so on; camera or scene must move")
    add("--save-settings", metavar="FILE.toml",
        help="write the settings too, to be read by --settings or changed by hand")
    add("--threads", type=option(read_count), metavar="N", help="threads; one a core by default")
    add("--json", action="store_true", help="print the result as JSON")


def render(arguments: argparse.Namespace) -> int:
    """Render what the arguments ask for; the exit code."""
    import lensbench as lb
    from lensbench.app.bench.build import wavelength_remark
    from lensbench.app.bench.camera_kinds import camera
    from lensbench.app.command.lens_options import say
    from lensbench.app.command.options import LINEAR, settings_from
    from lensbench.app.scenes.scene_file import cached_scene
    from lensbench.app.session.picture_render import export_render, kept_path
    from lensbench.app.session.states import save_settings
    from lensbench.app.settings.camera_facts import CAMERA_KINDS
    from lensbench.app.workers.compilers import compiling_ahead

    needs_lens = CAMERA_KINDS[arguments.camera or "lens"].has_lens
    if needs_lens and arguments.lens is None and arguments.settings is None:
        raise UsageError("which LENS? Name one, an exported picture, or --settings (see lensbench render --help)")
    settings = settings_from(arguments)
    said = set()
    for option, amount in (("ghosts", settings.ghosts), ("stars", settings.stars)):
        if amount and (reason := lb.why_no_ghosts(camera(settings), cached_scene(settings.scene))):
            said.add(reason.replace("ghosts", option))
            say(f"--{option}: {reason.replace('ghosts', option)}")
    remark = wavelength_remark(settings)
    if remark:
        say(f"{settings.lens}: {remark}")
    if arguments.until_noise is not None and not 0.0 < arguments.until_noise <= 1.0:
        raise UsageError("--until-noise: it must be more than 0 and at most 100 %, such as 1%")
    if arguments.bits is not None and Path(arguments.output).suffix.lower() in LINEAR:
        say(f"--bits has no effect on {arguments.output}: it holds linear light as floats")
    if arguments.until_noise is not None and settings.sample_view:
        say(f"--until-noise has no effect on the view {settings.view}: give --view picture")
        arguments.until_noise = None
    elif arguments.until_noise is not None and arguments.samples is None:
        settings = replace(settings, samples=MOST_SAMPLES)
    if arguments.save_settings is not None:
        save_settings(arguments.save_settings, settings)
    pictures = [(settings, Path(arguments.output))]
    if arguments.frames is not None:
        pictures = frames(settings, Path(arguments.output), arguments.frames)

    def show_part(i: int, share: float) -> None:
        show((i + share) / len(pictures))

    begun = perf_counter()
    done: list[dict[str, Any]] = []
    with compiling_ahead(settings.scene), progress() as show, stop_signals(arguments.resume) as signals:
        for i, (picture, path) in enumerate(pictures):
            if arguments.resume and arguments.frames is not None and _is_there(
                    picture, path, arguments.until_noise is not None):
                continue
            started = perf_counter()
            rendered = export_render(picture, path, arguments.bits or 8,
                                  partial(show_part, i), threads=arguments.threads,
                                  text=arguments.text, noise=arguments.until_noise, resume=arguments.resume,
                                  stopping=lambda: bool(signals))
            if rendered is None:
                which = f"in picture {i + 1} of {len(pictures)}, " if len(pictures) > 1 else ""
                print(f"lensbench: stopped {which}after {fixed(perf_counter() - begun, 0)} s; the samples are in "
                      f"{kept_path(path)}, and the same command goes on from there", file=sys.stderr)
                return 128 + signals[0]
            for finding in rendered.findings:
                if finding.message not in said:
                    said.add(finding.message)
                    say(f"{path}: {finding}")
            done.append(_figures(path, rendered, arguments.until_noise, perf_counter() - started))
            if not arguments.json:
                print(_summary(done[-1], rendered))
    if len(done) < len(pictures) and (arguments.until_noise is not None or arguments.bits is not None):
        say("--resume: frames that were there keep their noise and bit depth")
    if arguments.json:
        print_json(done[0] if arguments.frames is None else done)
    elif len(done) < len(pictures):
        print(f"{len(pictures) - len(done)} of {len(pictures)} frames were there already")
    return 0


def frames(settings: "Settings", path: Path, count: int) -> list[tuple["Settings", Path]]:
    """The frames of a sequence: settings and path of each.

    They begin at the moment of the settings and are evenly spaced up to their duration, so that one more frame
    would be at its end. UsageError where nothing moves.
    """
    from lensbench.app.settings.text_values import format_time

    if not 2 <= count <= MOST_FRAMES:
        raise UsageError(f"--frames {count}: 2 to {MOST_FRAMES} frames make a sequence")
    if not settings.moves:
        raise UsageError("--frames: nothing moves. Give the camera a second keyframe (--end-position), or choose a "
                         "scene that moves, such as fairground")
    if settings.moment >= settings.duration:
        raise UsageError(f"--frames: --moment {format_time(settings.moment)} is not before the end, --duration "
                         f"{format_time(settings.duration)}")
    length, digits = settings.duration - settings.moment, max(4, len(str(count)))
    return [(replace(settings, moment=settings.moment + length * i / count),
             path.with_name(f"{path.stem}-{i + 1:0{digits}}{path.suffix}")) for i in range(count)]


def _is_there(settings: "Settings", path: Path, any_samples: bool) -> bool:
    """Whether a frame of these settings (any_samples: but for their number) is newer than the files they name."""
    from lensbench.app.bench.build import own_picture
    from lensbench.app.scenes.scene_file import scene_files
    from lensbench.app.session.export import ExportError, read_settings

    named = [*scene_files(settings.scene), *map(Path, (settings.lens, settings.stop_image, own_picture(settings)))]
    if path.exists() and any(file.is_file() and file.stat().st_mtime_ns > path.stat().st_mtime_ns for file in named):
        return False
    try:
        there = read_settings(path) if path.exists() else None
        return there is not None and (replace(there, samples=settings.samples) if any_samples else there) == settings
    except ExportError:                     # a picture of something else, which is rendered over
        return False


def _figures(path: Path, rendered: "Rendered", noise: float | None, seconds: float) -> dict[str, Any]:
    from lensbench.app.bench.auto_model import record

    down, across = rendered.shape
    return {"path": str(path), "pixels": [across, down], "samples": rendered.samples, "seconds": seconds,
            "samples_per_second": across * down * rendered.samples / seconds, "noise": rendered.noise,
            "noise_reached": None if noise is None else rendered.noise is not None and rendered.noise <= noise,
            "findings": [str(finding) for finding in rendered.findings],
            "chosen": rendered.choice and record(rendered.choice)}


def _summary(figures: dict[str, Any], rendered: "Rendered") -> str:
    """The figures of a picture in a line, and the choice of its model in another."""
    from lensbench.app.bench.auto_model import choice_summary

    across, down = figures["pixels"]
    words = [f"{across} × {down} pixels", f"{rendered.samples} sample{'s' if rendered.samples > 1 else ''} each",
             f"{fixed(figures['seconds'], 1)} s"]
    if rendered.noise is not None:
        words.append(f"noise {significant(100.0 * rendered.noise, 2)} %"
                     + ("" if figures["noise_reached"] else ", above the noise asked for: give more --samples"))
    lines = [f"{figures['path']}: {', '.join(words)}"]
    if rendered.choice is not None:
        lines.append(", ".join(choice_summary(rendered.choice, None)))
    return "\n".join(lines)
