"""Random use of the window, as by a person's hand: clicks, drags, turns of the wheel, keys and text between two frames.

A tour shows all that there is once; a rest closes what is open and shows the first settings.
"""

import gc
import random
from collections.abc import Iterator
from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lensbench.app.settings.settings import Settings
    from lensbench.app.window.session import Session

KEYS = ("a b c d e f g h i j k l m n o p q r s t u v w x y z _0 _1 _2 _5 enter escape tab space backspace delete home "
        "left_arrow right_arrow up_arrow down_arrow page_up page_down").split()
MODIFIERS = ((), (), (), (), ("ctrl",), ("shift",), ("ctrl", "shift"), ("alt",))
QUIT = {("q", "ctrl"), ("q", "ctrl", "shift")}          # would end the trial
REST = 120                                              # actions between two looks at another lens, scene or camera
QUIET = 30.0                                            # s of rest before one: longer than free memory is kept
LENSES = 72                                             # of the tour: more than any cache holds
STAY = 6.0                                              # s for which the tour waits for one picture and its panels
BROWSED = 300.0                                         # s for which it waits for all pictures of the lens browser


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
        from lensbench.app.bench.constraints import with_camera
        from lensbench.app.bench.lens_choice import with_lens
        from lensbench.app.session.notices import Request
        from lensbench.app.settings.camera_facts import CAMERA_KINDS
        from lensbench.app.settings.setting_table import COMPARISONS, OVERLAYS, TONES
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
        for request in (Request.KEEP_SNAPSHOT, Request.PIN, Request.SHOW_HELP, Request.SHOW_PALETTE, Request.SHOW_TERMS,
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

        name, modifiers = self.random.choice(KEYS), self.random.choice(MODIFIERS)
        if (name, *modifiers) in QUIT:
            return
        io, keys = imgui.get_io(), [getattr(imgui.Key, f"mod_{modifier}") for modifier in modifiers]
        for key in (*keys, getattr(imgui.Key, name)):
            io.add_key_event(key, True)
        yield
        for key in (getattr(imgui.Key, name), *keys):
            io.add_key_event(key, False)
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
        for snapshot in list(session.snapshots.shelf.snapshots):
            session.snapshots.shelf.remove(snapshot)
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
        from lensbench.app.bench.constraints import with_camera
        from lensbench.app.bench.lens_choice import with_lens
        from lensbench.app.settings.camera_facts import CAMERA_KINDS
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
