"""Renders interrupted at random moments, with bounds checked: does the process fall, does a picture fail or hang?

python -m trials.interrupts --times 20000 --seed 1

Small pictures of random lenses, cameras and scenes go through the window's render worker. At a random moment, from its
set-up to its last pass, each is replaced by the next one, paused or stopped with its worker. The kernels check every
index (NUMBA_BOUNDSCHECK) and have a folder of their own (--kernels), for which the first run compiles them; a fault of
memory prints the stacks of all threads (faulthandler). Now and then a picture may end: it must be finite.
Printed once a minute: interruptions, pictures that ended, refused settings, failures. Ends with 1 for a failure.
"""

import argparse
import faulthandler
import os
import random
import sys
import threading
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep
from typing import Any, NamedTuple

LENSES = 12             # each with its own kinds of surfaces
VARIETIES = 120         # of lens × camera × scene: each may have kernels of its own
LONGEST = 96            # pixels of a side
PATIENCE = 900.0        # s: a picture that takes longer, its kernels included, hangs
VIEWS = ("picture", "picture", "picture", "picture", "picture", "depth", "direction")


class Tally(NamedTuple):
    """What became of the pictures; ended: those that had all samples."""

    interrupted: int
    ended: int
    refused: int
    failures: list[str]


def bounds_are_checked() -> bool:
    """Whether a stage that reads beyond its parameters raises, through the driver that renders."""
    from lensbench.core.kernels.block import RED, Step, stage
    from lensbench.core.kernels.program import Program

    @stage
    def beyond(lanes, p, ints, key):
        lanes[0] = p[p.size]

    try:
        Program([Step(beyond, [1.0])]).run({}, [RED], 1)
    except IndexError:
        return True
    return False


def varieties(chance: random.Random, number: int) -> list[Any]:
    """Settings of random lenses, cameras and scenes, each valid before it is changed further."""
    import lensbench as lb
    from lensbench import lenses
    from lensbench.app.bench.constraints import with_camera
    from lensbench.app.bench.lens_choice import with_lens
    from lensbench.app.settings.camera_facts import CAMERA_KINDS
    from lensbench.app.settings.settings import Settings

    names, outcomes = chance.sample(list(lenses.names()), LENSES), []
    for _ in range(number):
        settings = with_camera(with_lens(Settings(), chance.choice(names)), chance.choice(list(CAMERA_KINDS)))
        outcomes.append(replace(settings, scene=chance.choice(list(lb.SCENES)), samples=chance.choice((1, 3, 16, 64)),
                             ghosts=chance.random() < 0.1, view=chance.choice(VIEWS),
                             lens_model=chance.choice((settings.lens_model, "trace"))))
    return outcomes


def changed(settings: Any, chance: random.Random) -> Any:
    """The settings with another film raster and another camera position, as a drag gives them."""
    x, y, z = settings.position
    return replace(settings, pixels_x=chance.randint(1, LONGEST), pixels_y=chance.randint(1, LONGEST),
                   position=(x + chance.gauss(0.0, 50.0), y + chance.gauss(0.0, 20.0), z),
                   yaw=chance.gauss(0.0, 0.2), seed=chance.randrange(1000))


class Watched:
    """A render worker whose pictures are interrupted."""

    def __init__(self, chance: random.Random, settings: Any):
        from lensbench.app.workers.render_worker import RenderWorker

        self.chance, self.settings = chance, settings
        self.worker = RenderWorker(settings, threads=2, urgent=chance.random() < 0.5)

    @property
    def complete(self) -> bool:
        """Whether the current picture has all samples, or those that it gets in a pause, or an error."""
        from lensbench.app.workers.render_worker import PAUSED_SAMPLES

        update, samples = self.worker.newest(), self.settings.samples
        samples = min(samples, PAUSED_SAMPLES) if self.worker.paused else samples
        return self.worker.error is not None or (
            update is not None and update.generation == self.worker.generation and update.samples >= samples)

    def wait(self) -> None:
        """For a random time: none, less than a set-up, a pass, or a second."""
        sleep(min(self.chance.choice((0.0, self.chance.expovariate(500.0), self.chance.expovariate(50.0),
                                      self.chance.expovariate(8.0))), 1.0))

    def outcome(self) -> str:
        """Wait for the end of the picture: "", "refused", or what is wrong with it."""
        end = monotonic() + PATIENCE
        self.worker.resume()
        while not self.complete:
            if monotonic() > end:
                faulthandler.dump_traceback()
                return f"no picture after {PATIENCE:.0f} s: {self.settings}"
            sleep(0.002)
        return self.fault() or self._picture_fault()

    def fault(self) -> str:
        """The error of the current picture: "" without one, "refused" for one that names the setting."""
        failure = self.worker.error
        if failure is None:
            return ""
        return "refused" if isinstance(failure.error, ValueError | OSError) else f"{failure.error!r}: {self.settings}"

    def _picture_fault(self) -> str:
        import numpy as np

        update = self.worker.newest()
        size = self.settings.pixels_y, self.settings.pixels_x
        if update is None or self.settings.view != "picture":
            return ""
        if update.image.shape[:2] != size or not np.isfinite(update.image).all():
            return f"a picture {update.image.shape} that is not finite or not of the size {size}: {self.settings}"
        return ""

    def restart(self, settings: Any) -> None:
        """Replace the current picture."""
        self.settings = settings
        getattr(self.worker, self.chance.choice(("pause", "resume", "resume")))()
        self.worker.want_depth(self.chance.random() < 0.5)
        self.worker.restart(settings)


def interrupt(times: int, seed: int, number: int, minutes: float) -> Tally:
    """Interrupt so many renders of this number of varieties, or for so long."""
    chance, start, told = random.Random(seed), monotonic(), 0.0
    known, before = varieties(chance, number), set(threading.enumerate())
    interrupted, ended, refused, failures = 0, 0, 0, list[str]()
    while interrupted < times and monotonic() - start < 60.0 * minutes:
        settings = chance.choice(known)
        watched = Watched(chance, settings)
        for _ in range(chance.randint(1, 60)):                  # a session
            watched.wait()
            fault = watched.outcome() if chance.random() < 0.03 else watched.fault()
            refused, ended = refused + (fault == "refused"), ended + (watched.complete and not fault)
            interrupted += not watched.complete
            failures += [fault] if fault not in ("", "refused") else []
            settings = chance.choice(known) if chance.random() < 0.1 else settings
            watched.restart(changed(settings, chance))
            if monotonic() - start >= told + 60.0:
                told = monotonic() - start
                print(f"{told / 60.0:6.1f} min {interrupted} interrupted {ended} ended {refused} refused "
                      f"{len(failures)} failures", flush=True)
        watched.wait()
        interrupted += not watched.complete
        watched.worker.stop()
    left = [thread.name for thread in set(threading.enumerate()) - before if thread.name.startswith("lensbench")]
    return Tally(interrupted, ended, refused, failures + [f"a thread is left: {name}" for name in left])


def main() -> None:
    """Run the trial and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--times", type=int, default=20000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--varieties", type=int, default=VARIETIES, help="of lens, camera and scene")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="end after this time")
    parser.add_argument("--kernels", type=Path, default=Path("build/checked"), help="folder of the checked kernels")
    asked = parser.parse_args()
    folder = str(asked.kernels.resolve())
    os.environ.update(NUMBA_BOUNDSCHECK="1", XDG_CACHE_HOME=folder, NUMBA_CACHE_DIR=folder)     # numba's: of this file
    faulthandler.enable()
    if not bounds_are_checked():
        sys.exit("the kernels do not check their bounds")
    tally = interrupt(asked.times, asked.seed, asked.varieties, asked.minutes)
    print(f"seed {asked.seed}: {tally.interrupted} interrupted, {tally.ended} ended, {tally.refused} refused, "
          f"{len(tally.failures)} failures")
    print("\n".join(tally.failures))
    sys.exit(bool(tally.failures))


if __name__ == "__main__":
    main()
