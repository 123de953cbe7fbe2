"""Random use of the window by mouse and keyboard: does its memory grow, does anything fail, does a thread stay?

python -m trials.soak --minutes 120 --seed 1

The window needs no display; its folder is empty at first. A tour comes first: every layout and panel, every scene and
camera, more lenses than a cache holds, every way to develop a picture, the lens browser until it has all pictures. What
a first use takes is then there, and what grows later is growth. After the tour come clicks, drags, wheel turns, keys
and text, on every panel of every layout; now and then another lens, scene and camera.

Printed once a minute: resident memory, frames, actions, and the parts of that memory. What is shown at that moment
takes 50 MB more or less, so that every few minutes the first settings and layout come back, rest, and are measured
alone; moments and light fields that were kept are removed then, for these are the user's. At the end: growth after the
tour and after 10, 20 and 40 minutes from its end (least squares, with its standard error), of all samples and of those
at rest, exceptions, threads left. Ends with 1 for an exception or a thread. A run of less than 20 minutes has no tour,
unless it is to hurry: then the tour waits for no picture.
"""

import argparse
import ctypes
import gc
import math
import os
import random
import sys
import tempfile
import threading
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lensbench.app.state.settings import Settings
    from lensbench.app.window.session import Session

KEYS = ("a b c d e f g h i j k l m n o p q r s t u v w x y z _0 _1 _2 _5 enter escape tab space backspace delete home "
        "left_arrow right_arrow up_arrow down_arrow page_up page_down").split()
MODIFIERS = ((), (), (), (), ("ctrl",), ("shift",), ("ctrl", "shift"), ("alt",))
QUIT = {("q", "ctrl"), ("q", "ctrl", "shift")}          # would end the trial
SIZE = (1280, 720)
AFTER = (0.0, 10.0, 20.0, 40.0)                         # minutes after the tour, from which on growth is measured
SHARED = ("pymp", "lensbench analysis_")                # threads that stay for the next analysis, at most two
REST = 120                                              # actions between two looks at another lens, scene or camera
HOME = 5.0                                              # least minutes between two samples at rest
QUIET = 30.0                                            # s of rest before one: longer than free memory is kept
SHORT = 20.0                                            # minutes: a shorter run has no tour
LENSES = 72                                             # of the tour: more than any cache holds
STAY = 6.0                                              # s for which the tour waits for one picture and its panels
BROWSED = 300.0                                         # s for which it waits for all pictures of the lens browser


def memory() -> float:
    """Resident memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


class Mallinfo(ctypes.Structure):
    """What glibc says of its heap, bytes."""

    _fields_ = tuple((name, ctypes.c_size_t) for name in (  # noqa: RUF012
        "arena", "ordblks", "smblks", "hblks", "mapped", "usmblks", "fsmblks", "used", "free", "keepcost"))


def parts() -> str:
    """The parts of the resident memory in words: what C's heap holds, what is free in it, small Python objects."""
    library = ctypes.CDLL(None)
    if not hasattr(library, "mallinfo2"):
        return ""
    library.mallinfo2.restype = Mallinfo
    heap = library.mallinfo2()
    return (f"heap {(heap.used + heap.mapped) / 1e6:.1f} MB used, {heap.free / 1e6:.1f} free; "
            f"{sys.getallocatedblocks() / 1e3:.0f} thousand Python blocks")


def growth(samples: Sequence[tuple[float, float]], after: float) -> tuple[float, float]:
    """MB a minute, by least squares, of (minutes, MB) from a time on, and its standard error."""
    import numpy as np

    late = np.array([each for each in samples if each[0] >= after]).reshape(-1, 2)
    if len(late) < 4:
        return math.nan, math.nan
    slope, variance = np.polyfit(late[:, 0], late[:, 1], 1, cov=True)
    return float(slope[0]), math.sqrt(float(variance[0, 0]))


class Hand:
    """Random events, as a person's hand makes them between two frames."""

    def __init__(self, seed: int, size: tuple[int, int], toured: bool = False, hurries: bool = False):
        self.random, self.size, self.hurries = random.Random(seed), size, hurries
        self.place = (0.5 * size[0], 0.5 * size[1])
        self.actions = 0
        self.rests = [0.0]                              # when the window was at rest, in minutes
        self.toured = toured                            # the tour is over, or there is none
        self.doing = ""                                 # what a failure comes after

    def script(self, session: "Session", every: float) -> Iterator[None]:
        """One action after the other; goes on once a frame. every: minutes between two rests."""
        choices = (self.click, self.drag, self.wheel, self.key, self.text, self.wander)
        first, layout, start = session.history.present, session.layout, monotonic()
        if not self.toured:
            yield from self.tour(session)
            yield from self.home(session, first, layout)
            self.toured = True
            self.rests.append((monotonic() - start) / 60.0)
            yield
        while True:
            if monotonic() - start >= 60.0 * (self.rests[-1] + every):
                yield from self.home(session, first, layout)
                self.rests.append((monotonic() - start) / 60.0)
                yield
            self.actions += 1
            if self.actions % REST == 0:
                self.elsewhere(session)
                yield
            yield from self.random.choices(choices, (5, 5, 2, 3, 1, 3))[0]()

    def tour(self, session: "Session") -> Iterator[None]:
        """Show all that there is once."""
        from dataclasses import replace

        from imgui_bundle import hello_imgui, imgui

        import lensbench as lb
        from lensbench import lenses
        from lensbench.app.state.camera_kinds import CAMERA_KINDS
        from lensbench.app.state.constraints import with_camera
        from lensbench.app.state.lens_choice import with_lens
        from lensbench.app.state.request import Request
        from lensbench.app.state.setting_table import COMPARISONS, OVERLAYS, TONES
        from lensbench.app.window.layouts import LAYOUTS

        first, docking = session.history.present, hello_imgui.get_runner_params().docking_params

        def panels() -> Iterator[None]:
            """Each panel in turn before those of its dock."""
            for label in [panel.label for panel in docking.dockable_windows]:
                for panel in docking.dockable_windows:
                    if panel.label == label:
                        panel.is_visible = panel.focus_window_at_next_frame = True
                yield from self.stay(session)

        for name in LAYOUTS:
            session.layout = name
            yield from self.stay(session)
        yield from panels()
        for name in lb.SCENES:
            session.take(self.small(replace(first, scene=name)))
            yield from self.stay(session)
        for name in CAMERA_KINDS:
            session.take(self.small(with_camera(first, name)))
            yield from self.stay(session)
        for tone in TONES:
            for overlay in OVERLAYS:
                session.take(replace(first, tone=tone, overlay=overlay))
                yield from self.stay(session)
        names = lenses.names()
        for name in names[::max(1, len(names) // LENSES)]:
            session.take(self.small(with_lens(first, name)))
            yield from self.stay(session)
        session.take(first)
        for request in (Request.KEEP_MOMENT, Request.PIN, Request.SHOW_HELP, Request.SHOW_PALETTE, Request.SHOW_TERMS,
                        Request.EXPORT):
            yield from self.stay(session)
            session.requests.add(request)
            yield from self.stay(session)
            for down in (True, False):
                imgui.get_io().add_key_event(imgui.Key.escape, down)
                yield
        for name in COMPARISONS:
            session.take(replace(first, compare=name))
            yield from self.stay(session)
        session.take(first)
        session.browsing.toggle()
        start = monotonic()
        while not self.hurries and monotonic() - start < BROWSED and not session.browsing.complete:
            yield
        if not session.browsing.complete:
            print("the tour ends before the lens browser has all its pictures", flush=True)

    def stay(self, session: "Session") -> Iterator[None]:
        """Until the picture and the figures of the panels are there, or STAY is over."""
        start = monotonic()
        yield
        yield
        while not self.hurries and monotonic() - start < STAY and (
                session.analyses.worker.busy or not session.worker.on_screen):
            yield

    @staticmethod
    def small(settings: "Settings") -> "Settings":
        """The settings with few pixels."""
        from dataclasses import replace

        return replace(settings, pixels_x=min(settings.pixels_x, 480), pixels_y=min(settings.pixels_y, 480))

    def move(self, x: float, y: float) -> None:
        """Put the mouse there."""
        from tests.app.conftest import mouse_to

        self.place = min(max(x, 0.0), self.size[0] - 1.0), min(max(y, 0.0), self.size[1] - 1.0)
        mouse_to(*self.place)

    def wander(self) -> Iterator[None]:
        """Hover over things."""
        self.move(*(self.random.uniform(0.0, side) for side in self.size))
        for _ in range(self.random.randint(1, 25)):
            yield

    def click(self) -> Iterator[None]:
        """Click somewhere, twice now and then."""
        from imgui_bundle import imgui

        yield from self.wander()
        button = self.random.choices((0, 1, 2), (8, 2, 1))[0]
        for _ in range(self.random.choices((1, 2), (6, 1))[0]):
            imgui.get_io().add_mouse_button_event(button, True)
            yield
            imgui.get_io().add_mouse_button_event(button, False)
            yield

    def drag(self) -> Iterator[None]:
        """Press, move, release."""
        from imgui_bundle import imgui

        yield from self.wander()
        button = self.random.choices((0, 1), (4, 1))[0]
        imgui.get_io().add_mouse_button_event(button, True)
        yield
        (x, y), steps = self.place, self.random.randint(2, 20)
        dx, dy = self.random.gauss(0, 120), self.random.gauss(0, 60)
        for i in range(steps):
            self.move(x + dx * (i + 1) / steps, y + dy * (i + 1) / steps)
            yield
        imgui.get_io().add_mouse_button_event(button, False)
        yield

    def wheel(self) -> Iterator[None]:
        """Turn the wheel."""
        from imgui_bundle import imgui

        yield from self.wander()
        for _ in range(self.random.randint(1, 5)):
            imgui.get_io().add_mouse_wheel_event(0.0, self.random.choice((-1.0, 1.0)))
            yield

    def key(self) -> Iterator[None]:
        """Press a key, with its modifiers."""
        from imgui_bundle import imgui

        name, held = self.random.choice(KEYS), self.random.choice(MODIFIERS)
        if (name, *held) in QUIT:
            return
        io, keys = imgui.get_io(), [getattr(imgui.Key, f"mod_{each}") for each in held]
        for each in (*keys, getattr(imgui.Key, name)):
            io.add_key_event(each, True)
        yield
        for each in (getattr(imgui.Key, name), *keys):
            io.add_key_event(each, False)
        yield

    def text(self) -> Iterator[None]:
        """Type some characters, as into a dial or a search, and Enter."""
        from imgui_bundle import imgui

        io = imgui.get_io()
        io.add_input_characters_utf8("".join(self.random.choices("0123456789.,-e f/mm∞abcxyz", k=6)))
        yield
        for down in (True, False):
            io.add_key_event(imgui.Key.enter, down)
            yield

    def home(self, session: "Session", first: "Settings", layout: str) -> Iterator[None]:
        """Close all that lies over the panels, and show these settings in this layout until the window is at rest."""
        from imgui_bundle import imgui

        for _ in range(3):                              # a popup of a popup
            for down in (True, False):
                imgui.get_io().add_key_event(imgui.Key.escape, down)
                yield
        if session.browsing.is_open:
            session.browsing.toggle()
        session.layout = layout
        for moment in list(session.moments.shelf.moments):
            session.moments.shelf.remove(moment)
        session.light_field.worker.cancel()
        session.light_field.worker.forget()
        yield
        session.take(first)
        start = monotonic()
        while monotonic() - start < QUIET:
            yield
        gc.collect()

    def elsewhere(self, session: "Session") -> None:
        """Close popups and dialogs, and take another lens, scene, camera or layout."""
        from dataclasses import replace

        from imgui_bundle import hello_imgui, imgui

        import lensbench as lb
        from lensbench import lenses
        from lensbench.app.state.camera_kinds import CAMERA_KINDS
        from lensbench.app.state.constraints import with_camera
        from lensbench.app.state.lens_choice import with_lens
        from lensbench.app.window.layouts import LAYOUTS

        imgui.get_io().add_key_event(imgui.Key.escape, True)
        imgui.get_io().add_key_event(imgui.Key.escape, False)
        settings, what = session.history.present, self.random.randrange(5)
        if what == 0:
            settings = with_lens(settings, self.random.choice(lenses.names()))
        elif what == 1:
            settings = replace(settings, scene=self.random.choice(list(lb.SCENES)))
        elif what == 2:
            settings = with_camera(settings, self.random.choice(list(CAMERA_KINDS)))
        elif what == 3:
            session.layout = self.random.choice(list(LAYOUTS))
        else:
            for panel in hello_imgui.get_runner_params().docking_params.dockable_windows:
                panel.is_visible = self.random.random() < 0.6
        session.take(self.small(settings))


Samples = list[tuple[float, float]]                     # minutes, MB


def soak(minutes: float, hand: Hand) -> tuple[Samples, Samples, list[str]]:
    """Memory once a minute, memory at rest from the end of the tour on, and what failed."""
    from lensbench.app.window import window

    failures: list[str] = []

    def failed(*error: Any, **ignored: Any) -> None:
        raised = next(each for each in error if isinstance(each, BaseException))
        failures.append(hand.doing + "".join(traceback.format_exception(raised)))
        print(failures[-1], flush=True)

    sys.excepthook = failed
    threading.excepthook = lambda given: failed(given.exc_type, given.exc_value, given.exc_traceback)
    traceback.print_exception = failed                  # the window shows it and goes on
    before = set(threading.enumerate())
    session = window.Session(window.Settings(pixels_x=480, pixels_y=320, samples=64), remember=False, threads=2)
    window.without_display()
    runner = window.parameters(session, SIZE)
    runner.fps_idling.enable_idling = False
    start = monotonic()
    steps, samples, frames = hand.script(session, HOME), [(0.0, memory())], [0]
    rests: Samples = []

    def step() -> None:
        frames[0] += 1
        now = (monotonic() - start) / 60.0
        if now >= samples[-1][0] + min(1.0, minutes / 20.0):
            samples.append((now, memory()))
            print(f"{now:6.1f} min {samples[-1][1]:7.1f} MB {frames[0]} frames {hand.actions} actions "
                  f"{len(failures)} exceptions; {parts()}{'' if hand.toured else '; on tour'}", flush=True)
        if now >= minutes:
            runner.app_shall_exit = True
        elif session.presenter.update is not None:      # from the first picture on
            next(steps)
            if len(hand.rests) > len(rests) + 1:
                rests.append((now, memory()))
                print(f"{now:6.1f} min {rests[-1][1]:7.1f} MB at rest; {parts()}", flush=True)

    runner.callbacks.after_swap = step
    try:
        window.show(runner)
    except Exception as error:
        failed(error)
    gc.collect()
    left = [thread.name for thread in set(threading.enumerate()) - before if not thread.name.startswith(SHARED)]
    return samples, rests, failures + [f"a thread is left: {name}" for name in left]


def at_home(minutes: float, hand: Hand) -> tuple[Samples, Samples, list[str]]:
    """`soak` in an empty folder of its own, which is the home of the user and the present one."""
    os.environ.setdefault("XDG_CACHE_HOME", str(Path.home() / ".cache"))        # the kernels
    with tempfile.TemporaryDirectory() as home:
        os.environ["HOME"] = os.environ["XDG_CONFIG_HOME"] = home
        os.chdir(home)
        return soak(minutes, hand)


def main() -> None:
    """Run the trial and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=120.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--hurry", action="store_true", help="tour in a short run too, and wait for no picture there")
    asked = parser.parse_args()
    hand = Hand(asked.seed, SIZE, asked.minutes < SHORT and not asked.hurry, asked.hurry)
    samples, rests, failures = at_home(asked.minutes, hand)
    print(f"seed {asked.seed}: {samples[-1][1]:.0f} MB after {samples[-1][0]:.0f} minutes, {len(failures)} failures")
    toured = rests[0][0] if rests and (asked.minutes >= SHORT or asked.hurry) else 0.0
    print(f"growth in MB a minute after a tour of {toured:.0f} minutes; nan where there are too few samples:")
    for after in (each for each in AFTER if toured + each < samples[-1][0]):
        (over_all, error), (resting, its_error) = (growth(each, toured + after) for each in (samples, rests))
        print(f"from {after:2.0f} minutes on {over_all:.3f} ± {error:.3f}, at rest {resting:.3f} ± {its_error:.3f}")
    print("\n".join(failures))
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
