"""The panels of a window: what each draws, and the passage of the settings through them.

What the panels keep from frame to frame: made, and its panel imported, when that is first drawn.
"""

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, hello_imgui, imgui
from numpy.typing import NDArray

from lensbench.app.bench.readouts import lit
from lensbench.app.panels.image.image_panel import image_panel
from lensbench.app.session.notices import Request
from lensbench.app.settings.settings import Settings, differences
from lensbench.app.window.analyses import PANELS, Analyses
from lensbench.app.window.bars import status_bar
from lensbench.app.window.docking import RENDER, Docking
from lensbench.app.window.lens_browsing import LensBrowsing
from lensbench.app.window.snapshots import Snapshots
from lensbench.app.window.state import WindowState
from lensbench.app.workers.render_worker import RenderWorker

# States that a panel keeps from frame to frame, by attribute of `PanelStates`: the file and the class in `app.panels`
STATES = {"confusion": "circle_of_confusion.CocState", "pupil": "exit_pupil.PupilState",
          "falloff": "falloff.FalloffState", "card": "lens_card.LensCardState",
          "section": "lens_section.panel.SectionState", "table": "lens_table.cell.LensTableState",
          "models": "models.ModelsState", "pixel": "pixel.PixelState", "plan": "plan.PlanState",
          "view_3d": "view_3d.View3DState"}


class PanelStates:
    """The states of the panels of one window, except those for analysis; each is made when first asked for."""

    def __init__(self, window: WindowState):
        self._window = window

    def __getattr__(self, name: str) -> Any:
        if name not in STATES:
            raise AttributeError(name)
        file, _, kind = STATES[name].rpartition(".")
        make = getattr(import_module(f"lensbench.app.panels.{file}"), kind)
        if name == "card":
            state = make(self._window.wake)
        elif name == "table":
            from lensbench.app.workers.study_workers import ImprovementWorker

            state = make(self._window.requests, worker=ImprovementWorker(self._window.wake))
        else:
            state = make()
        setattr(self, name, state)
        return state

    @property
    def has_table(self) -> bool:
        """Whether something asked for the state of the surface table, so that a lens may be improved."""
        return "table" in vars(self)

    def stop(self) -> None:
        """End the workers of the panels; the window is about to close."""
        if "card" in vars(self):
            self.card.checks.stop()
        if self.has_table:
            self.table.worker.stop()


PATIENCE = 0.3                  # s that panels of another lens wait for its picture, at most


class Followed:
    """Settings of the panels whose geometry takes time: one frame after the picture, which does not wait for them.

    Of another lens all of it is new: until its first picture is on the screen, they show the lens before.
    """

    def __init__(self, settings: Settings):
        self._settings = settings

    def now(self, current: Settings, worker: RenderWorker) -> Settings:
        """The settings to draw, from those of the frame before and the worker that renders them."""
        if current.lens == self._settings.lens or worker.on_screen or worker.waiting > PATIENCE:
            self._settings = current
        return self._settings


class Panels:
    """Draws the panels of a window, each in its `docking`.

    All but the render are imported when they are first drawn, for the first picture does not need them.
    """

    def __init__(self, window: WindowState, browsing: LensBrowsing, analyses: Analyses, snapshots: Snapshots):
        self._state, self._browsing, self._analyses, self._snapshots = window, browsing, analyses, snapshots
        self._stability_worker: Any = None              # from when the panel is first looked at
        self._stability_state: Any = None
        self.docking = Docking(window, browsing)
        self.kept = PanelStates(window)
        self._followed = Followed(window.history.present)
        self._field = 0.7                   # the film point of the exit pupil, as a part of the illuminated film

    def windows(self) -> list[hello_imgui.DockableWindow]:
        """All panels, for hello_imgui: a row for each. `layouts` says where they lie."""
        docked = self.docking.docked
        return [
            docked("Controls", self._controls),
            docked("Read-outs", self._readouts),
            docked("Lens card", self._lens_card),
            docked("Spaces", self._spaces),
            docked("Section", self._section, padding=4.0),
            docked("Surfaces", self._surfaces, padding=6.0),
            docked("3-D", self._view_3d),
            docked("Stability", self._stability),
            docked("Snapshots", self._snapshots.draw, padding=8.0),
            docked("Circle of confusion", self._confusion),
            docked("Plan", self._plan),
            docked("Pixel", self._pixel),
            docked("Exit pupil", self._pupil),
            docked("Falloff", self._falloff),
            docked("Models", self._models),
            docked("Light field", self._light_field),
            *(docked(name, self._analysis(name), padding=8.0) for name in PANELS),
            docked(RENDER, self._render, "MainDockSpace", padding=0.0),
        ]

    def _render(self) -> None:
        window = self._state
        window.worker.await_first()
        window.light_field.await_field_picture()
        window.presenter.take(window.view)    # the first picture of this frame's change may be there already
        picture = window.presenter.picture(window.edited, window.view)
        if picture.first:
            picture = replace(picture, plan=tuple(window.compilers.plan()))
        work = window.light_field.worker.task or self._snapshots.task or (
            window.export.task if window.export.busy else None)
        if work is not None and window.presenter.field_picture is None and picture.samples < window.edited.samples:
            picture = replace(picture, held=f"{work.description[:1].lower()}{work.description[1:]}")
        self._beside_browser()
        window.edited = image_panel(window.edited, picture, window.view)

    def _controls(self) -> None:
        from lensbench.app.panels.controls.controls import controls_panel

        window = self._state
        window.edited = controls_panel(window.edited, window.chooser)

    def _readouts(self) -> None:
        from lensbench.app.panels.readouts import Status, readouts_panel

        update = self._state.presenter.update
        pinned = self._state.presenter.pinned
        readouts_panel(self._state.edited, Status(update.rate if update else 0.0, hello_imgui.frame_rate(),
                                                  update.samples if update else 0),
                       self._other, Status(samples=pinned.samples if pinned else 0))

    @property
    def _other(self) -> Settings | None:
        """The settings A, while they are compared with the current ones."""
        return self._state.view.pinned if self._state.edited.compare != "off" else None

    def _lens_card(self) -> None:
        from lensbench.app.panels.lens_card import lens_card_panel

        lens_card_panel(self._state.edited, self.kept.card, self._state.view.links.surfaces)

    def _spaces(self) -> None:
        from lensbench.app.panels.spaces import spaces_panel

        window, film = self._state, self._state.edited.film
        view = window.view
        raster = view.pointed or (film.pixels_x / 2.0, film.pixels_y / 2.0)
        raster = (min(raster[0], float(film.pixels_x)), min(raster[1], float(film.pixels_y)))
        if spaces_panel(window.edited, raster, window.presenter.depth(window.edited), self._image):
            window.requests.add(Request.SAVE_INTRINSICS)

    def _plan(self) -> None:
        from lensbench.app.panels.plan import plan_panel

        self._state.edited = plan_panel(self._state.edited, self.kept.plan, self._state.view.links)

    def _pixel(self) -> None:
        from lensbench.app.panels.pixel import pixel_panel

        window = self._state
        pixel_panel(self.behind, window.view.links, self._image, self.kept.pixel)

    @property
    def _image(self) -> NDArray[np.float32] | None:
        """The picture, unless it is a coarse one of a drag."""
        update, current = self._state.presenter.update, self._state.history.present
        fine = update is not None and update.image.shape[:2] == (current.pixels_y, current.pixels_x)
        return update.image if fine and update is not None else None

    def _beside_browser(self) -> None:
        """Begin right of the lens browser, so that what changes with the lens stays in sight."""
        corner = imgui.get_cursor_screen_pos()
        if 0.0 < self._browsing.covers > corner.x:      # panels of a tiny window begin left of it
            imgui.set_cursor_screen_pos(ImVec2(self._browsing.covers, corner.y))

    def _following(self, draw: Callable[[Settings], Settings]) -> None:
        """Draw a panel whose geometry takes time.

        draw: receives the settings that it shows, and returns them with the panel's own changes.
        """
        window, before = self._state, self.behind
        changed = draw(before)
        if changed is not before:
            window.edited = replace(window.edited, **differences(changed, before))

    @property
    def behind(self) -> Settings:
        """The settings of panels whose geometry takes time."""
        return self._followed.now(self._state.history.present, self._state.worker)

    def _section(self) -> None:
        from lensbench.app.panels.lens_section.panel import lens_section_panel

        self._beside_browser()
        table = self.kept.table
        self.kept.section.edit.selected = (table.first, table.last) if table.last > table.first else None
        self._following(lambda before: lens_section_panel(before, self.kept.section, self._field * lit(before),
                                                          self._state.view.links, self._under(before)))
        if self.kept.section.edit.begun:
            self._state.history.part()

    def _under(self, settings: Settings) -> Settings | None:
        """The settings whose lens is ghosted under the section: A, or the lens before its edits."""
        from lensbench.app.session.edited_lens import reverted

        if self._other is None and self.kept.table.ghost and settings.edited:
            return reverted(settings)
        return self._other

    def _surfaces(self) -> None:
        from lensbench.app.panels.lens_table.panel import lens_table_panel

        window, state = self._state, self.kept.table
        window.edited = lens_table_panel(window.edited, state, window.view.links)
        window.keyed = window.keyed or state.keyed
        if state.parted:
            window.history.part()
        for sentence in state.said:
            window.view.say(sentence, note=True, change=True)
        state.said.clear()

    def _view_3d(self) -> None:
        from lensbench.app.panels.view_3d import view_3d_panel

        window = self._state
        self._beside_browser()
        view_3d_panel(self.behind, window.view.links, self.kept.view_3d, window.presenter.solid_picture)

    def _confusion(self) -> None:
        from lensbench.app.panels.circle_of_confusion import circle_of_confusion_panel

        self._following(lambda before: circle_of_confusion_panel(before, self.kept.confusion, self._state.view.links,
                                                                 self._other))

    def _pupil(self) -> None:
        from lensbench.app.panels.exit_pupil import exit_pupil_panel

        settings = self.behind
        full = lit(settings)
        radius = exit_pupil_panel(settings, self._field * full, self.kept.pupil, self._state.view.links,
                                  self._other)
        if radius != self._field * full and full > 0.0:
            self._field = radius / full

    def _analysis(self, name: str) -> Callable[[], None]:
        draw = self._analyses.panel(name)
        return lambda: self._following(draw)

    def _falloff(self) -> None:
        from lensbench.app.panels.falloff import falloff_panel

        falloff_panel(self.behind, self.kept.falloff, self._other)

    def _models(self) -> None:
        from lensbench.app.panels.models import models_panel

        window, update = self._state, self._state.presenter.update
        choice = update.choice if update is not None else None
        window.edited = models_panel(window.edited, window.charts, self.kept.models,
                                     choice and (choice.model, choice.degree))

    def _light_field(self) -> None:
        from lensbench.app.panels.light_field.panel import light_field_panel

        window = self._state
        controller = window.light_field
        controller.look = light_field_panel(window.edited, controller.look, controller.form, controller.worker,
                                            window.presenter.strip)
        controller.ask()                        # at once: drawing the other panels takes time

    def _stability(self) -> None:
        from lensbench.app.panels.stability import StabilityState, stability_panel  # loads every study
        from lensbench.app.workers.study_workers import StabilityWorker

        if self._stability_worker is None:
            self._stability_worker, self._stability_state = StabilityWorker(self._state.wake), StabilityState()
        stability_panel(self._stability_worker, self._stability_state)

    def follow_improvement(self) -> None:
        """Before the panels: the newest step of an improvement becomes the lens, whether or not the table is shown."""
        if not self.kept.has_table:
            return
        self.kept.table.follow(self._state.edited)
        self._state.edited = self.kept.table.improved(self._state.edited)
        if self.kept.table.begun:
            self.kept.table.begun = False
            self._state.history.part()

    @property
    def improving(self) -> bool:
        """Whether an improvement changes the lens step by step: all of it is one gesture."""
        if not self.kept.has_table:
            return False
        worker = self.kept.table.worker
        return worker.running or worker.pending or self.kept.table.stepped

    def closed(self) -> None:
        """Cancel the running measurement; the window is about to close."""
        self.kept.stop()
        if self._stability_worker is not None:
            self._stability_worker.stop()

    def status(self) -> None:
        """The line at the bottom."""
        window = self._state
        presenter = window.presenter
        status_bar(window.edited, presenter.update, window.view,
                   presenter.renderer.split()[0] if presenter.software else "",
                   window.opening or window.export.task or self._snapshots.task,
                   window.layout == "Photographer")
