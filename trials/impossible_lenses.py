"""Impossible lenses under the mouse: does any panel fail for a lens that no one would make?

python -m trials.impossible_lenses --minutes 20 --seed 1

A lens of the library is damaged by random edits of its table, one on top of the other: radii, gaps, rims, glasses,
conics, poses, the stop, its size; some edits cross surfaces, end all light or leave no image. Between them come other
cameras, models, focus distances and comparisons. After each edit, panels of all layouts come to the front, and the
mouse goes over them, clicks and drags. What fails is printed with the lens and its last edit. Ends with 1 for a
failure.
"""

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from trials.hand import Hand
from trials.soak import SIZE, at_home

if TYPE_CHECKING:
    from lensbench.app.settings.settings import Settings
    from lensbench.app.window.session import Session
    from lensbench.lenses.editing.document import LensDocument

DAMAGES = 4                     # to one lens
PANELS, PLACES = 6, 8           # visited after each, and places on each of them


class Spoiler(Hand):
    """Damages lenses, and visits the panels."""

    def script(self, session: "Session", every: float) -> Iterator[None]:
        """One damage after the other; goes on once a frame. every: not used, for nothing is measured at rest."""
        from lensbench import lenses
        from lensbench.app.bench.lens_choice import with_lens
        from lensbench.app.window.layouts import LAYOUTS

        first = session.history.present
        while True:
            start = self.small(replace(with_lens(first, self.random.choice(lenses.names())), samples=8))
            self.doing = f"{start.lens}: "
            session.take(start)
            session.layout = self.random.choice(list(LAYOUTS))
            yield from self.frames(10)
            for _ in range(DAMAGES):
                self.actions += 1
                session.take(self.small(self.damaged(session.history.present)))
                yield from self.frames(self.random.choice([2, 6, 20]))
                for _ in range(PANELS):
                    yield from self.visit()
            yield from self.escape()

    def frames(self, count: int) -> Iterator[None]:
        """So many frames."""
        for _ in range(count):
            yield

    def escape(self) -> Iterator[None]:
        """Close what is open."""
        from imgui_bundle import imgui

        for down in (True, False):
            imgui.get_io().add_key_event(imgui.Key.escape, down)
            yield

    def visit(self) -> Iterator[None]:
        """Bring a panel to the front, and go over it."""
        from imgui_bundle import hello_imgui, imgui

        panel = self.random.choice(hello_imgui.get_runner_params().docking_params.dockable_windows)
        panel.is_visible = panel.focus_window_at_next_frame = True
        yield from self.frames(self.random.choice([2, 8]))
        window = imgui.internal.find_window_by_name(panel.label)
        if window is None:
            return
        for _ in range(PLACES):
            self.move(window.pos.x + self.random.random() * window.size.x,
                      window.pos.y + self.random.random() * window.size.y)
            yield from self.frames(2)
            if self.random.random() < 0.15:
                yield from self.press()

    def press(self) -> Iterator[None]:
        """A click here, or a short drag."""
        from imgui_bundle import imgui

        button = self.random.choice([0, 0, 1])
        imgui.get_io().add_mouse_button_event(button, True)
        yield
        if self.random.random() < 0.5:
            self.move(self.place[0] + self.random.gauss(0.0, 60.0), self.place[1] + self.random.gauss(0.0, 60.0))
            yield
        imgui.get_io().add_mouse_button_event(button, False)
        yield

    def damaged(self, settings: "Settings") -> "Settings":
        """The settings with another random edit of their lens, or another way to look through it."""
        from lensbench.app.bench.constraints import with_camera
        from lensbench.app.session.edited_lens import edited
        from lensbench.app.settings.camera_facts import CAMERA_KINDS, MODEL_TITLES
        from lensbench.app.settings.setting_table import COMPARISONS, OVERLAYS
        from lensbench.lenses.editing.document import EditError

        choose = self.random.choice
        if self.random.random() < 0.2:
            return choose([
                lambda: with_camera(settings, choose(list(CAMERA_KINDS))),
                lambda: with_camera(replace(settings, lens_model=choose(list(MODEL_TITLES))), "lens"),
                lambda: replace(settings, overlay=choose(list(OVERLAYS)), compare=choose(list(COMPARISONS))),
                lambda: replace(settings, tilt=choose([0.0, 0.1, -0.5]), medium=choose(["air", "water"])),
                lambda: replace(settings, focus_distance=choose([1.0, 50.0, 250.0, 1e5, math.inf]),
                                f_number=choose([None, 0.7, 2.8, 64.0])),
            ])()
        name, edit = self.edit(settings)
        self.doing = f"{settings.lens}, {name}: "
        try:
            return edited(settings, edit)[0]
        except (EditError, ValueError, OSError):        # what the table refuses in words
            return settings

    def edit(self, settings: "Settings") -> tuple[str, Callable[["LensDocument"], "LensDocument"]]:
        """A random edit of the lens, and its name."""
        from lensbench.app.session.edited_lens import document_of
        from lensbench.lenses.editing.cells import with_glass, with_radius, with_value
        from lensbench.lenses.editing.elements import with_pose
        from lensbench.lenses.editing.structure import deleted, scaled, with_stop

        random, choose, lens = self.random, self.random.choice, document_of(settings).lens
        count = len(lens.surfaces)
        i = random.randrange(count)
        last = min(count - 1, i + random.randrange(3))

        def all_radii(change: Callable[[float], float]) -> Callable[["LensDocument"], "LensDocument"]:
            def change_all(document: "LensDocument") -> "LensDocument":
                for j, surface in enumerate(lens.surfaces):
                    document = with_radius(document, j, change(surface.radius))
                return document
            return change_all

        edits: dict[str, Callable[[LensDocument], LensDocument]] = {
            f"radius {i}": lambda d: with_radius(d, i, choose([-1.0, 1.0]) * 10.0 ** random.uniform(-0.5, 4.0)),
            f"thickness {i}": lambda d: with_value(d, i, "thickness", choose([-5.0, 0.0, 200.0, 1e4])),
            f"semi-diameter {i}": lambda d: with_value(d, i, "semi_diameter", choose([0.05, 0.5, 2.0, 100.0])),
            "semi-diameter of the stop": lambda d: with_value(d, lens.stop_index, "semi_diameter",
                                                              choose([0.02, 0.5, 2.0, 4.0])),
            "nearly all flat": all_radii(lambda radius: math.inf if random.random() < 0.8 else radius),
            "all turned": all_radii(lambda radius: -radius),
            "all changed": all_radii(lambda radius: radius * random.uniform(0.7, 1.4)),
            f"glass {i}": lambda d: with_glass(d, i, choose(["air", "N-BK7", "N-SF66"])),
            f"delete {i}": lambda d: deleted(d, [i]),
            "scale": lambda d: scaled(d, choose([0.01, 0.1, 10.0, 100.0, -1.0])),
            f"decentre {i} to {last}": lambda d: with_pose(d, i, last, choose(["decentre_x", "decentre_y"]),
                                                           choose([-30.0, 1.0, 8.0])),
            f"tilt {i} to {last}": lambda d: with_pose(d, i, last, choose(["tilt_x", "tilt_y"]),
                                                       choose([-60.0, 3.0, 20.0, 85.0])),
            f"conic {i}": lambda d: with_value(d, i, "conic", choose([-1.0, -50.0, 20.0, 1e4])),
            f"stop {i}": lambda d: with_stop(d, i),
        }
        name = choose(list(edits))
        return name, edits[name]


def main() -> None:
    """Run the trial and print what failed."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    hand = Spoiler(asked.seed, SIZE, toured=True)
    _, _, failures = at_home(asked.minutes, hand)
    print(f"seed {asked.seed}: {hand.actions} edits, {len(failures)} failures")
    print("\n".join(failures))
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
