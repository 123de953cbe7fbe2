"""The section: its glass, its rays, and its handles under a real mouse."""

import math
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import bench_of, design
from lensbench.app.bench.ray_fans import Ray
from lensbench.app.panels.lens_section import panel
from lensbench.app.panels.lens_section.draw import field_names, fitted, round_length
from lensbench.app.panels.lens_section.links import pushed_apart
from lensbench.app.plots.section import elements, sag, sketch
from lensbench.app.session.edited_lens import edited
from lensbench.app.settings.settings import Settings
from lensbench.lenses.editing.structure import deleted
from tests.app.kinds import of_kind
from tests.app.stand import centre, drive
from tests.core.optics.test_surface_pose import posed

START = Settings(lens="pbrt-dgauss-50mm")
some_lenses = pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-wide-22mm", "pbrt-fisheye-10mm",
                                               "lenshh-cooke-triplet-50", "pbrt-telephoto-250mm"])


# Glass


def area(outline: np.ndarray) -> float:
    z, y = outline.T
    return 0.5 * abs(float(np.sum(z * np.roll(y, -1) - np.roll(z, -1) * y)))


@some_lenses
def test_strips_fill_the_glass_without_gap_or_overlap(name):
    for element in elements(lenses.load(name)):
        # Chords of arcs, laid out differently: the outline's and the strips' areas differ by their sagittas
        assert sum(area(strip) for strip in element.strips) == pytest.approx(area(element.outline), rel=3e-3)


@some_lenses
def test_every_strip_is_convex(name):
    for element in elements(lenses.load(name)):
        for strip in element.strips:
            sides = np.roll(strip, -1, axis=0) - strip
            turns = sides[:, 0] * np.roll(sides[:, 1], -1) - sides[:, 1] * np.roll(sides[:, 0], -1)
            assert (turns <= 1e-9).all() or (turns >= -1e-9).all()


@some_lenses
def test_the_outline_lies_on_the_surfaces_and_within_the_edge(name):
    lens = lenses.load(name)
    for element in elements(lens):
        front, rear = lens.surfaces[element.front], lens.surfaces[element.front + 1]
        edge = max(front.semi_diameter, rear.semi_diameter)
        assert np.abs(element.outline[:, 1]).max() <= edge * (1 + 1e-12)
        places = [(front, lens.vertices[element.front]), (rear, lens.vertices[element.front + 1])]
        for z, y in element.outline:
            assert min(abs(z - vertex - sag(surface, 0.0, y)) for surface, vertex in places) < 1e-9 * edge


def test_an_element_holds_its_middle_and_not_the_air_beside_it():
    lens = lenses.load("pbrt-dgauss-50mm")
    for element in elements(lens):
        front, rear = lens.vertices[element.front], lens.vertices[element.front + 1]
        assert element.holds(0.5 * (front + rear), 1e-4)
        assert not element.holds(0.5 * (front + rear), 100.0)
        assert not element.holds(front - 50.0, 1e-4)


# Rays


def live(rays: tuple[Ray, ...]) -> list[Ray]:
    return [ray for ray in rays if ray.kind != "dead"]


@some_lenses
@pytest.mark.parametrize("focus", [math.inf, 1500.0])
def test_drawn_rays_are_what_the_tracer_returns(name, focus):
    shown = sketch(replace(START, lens=name, focus_distance=focus, f_number=None))
    for fan in shown.fans:
        for ray in live(fan.rays):
            start, way = ray.path[0], ray.path[1] - ray.path[0]
            again = lb.trace(shown.lens, [0.0, start[1], start[0]], [0.0, way[1], way[0]], record=True)
            # The path's first stretch is long: its direction is known to 1e-13 of some hundred millimetres
            assert again.fate[0] == lb.Fate.PASSED
            assert ray.path[:-1, 1] == pytest.approx(again.paths[0][:, 1], abs=1e-6)
            assert len(ray.path) == len(shown.lens.surfaces) + 2
            assert ray.path[-1][0] == pytest.approx(shown.film_z)


@some_lenses
def test_the_chief_ray_meets_its_film_point(name):
    shown = sketch(replace(START, lens=name, f_number=8.0))
    for fan in shown.fans:
        chief = [ray for ray in fan.rays if ray.kind == "chief"]
        if fan.dark:
            continue
        # It is found on the film side, then traced back: reversible but for rounding; where vignetting leaves
        # no chief ray, the middle one of those that pass replaces it, and meets the point too
        assert len(chief) == 1
        assert chief[0].path[-1][1] == pytest.approx(fan.height, abs=1e-6 * shown.film_height)


def test_the_marginal_rays_of_the_axis_touch_the_rim_that_limits_them():
    shown = sketch(replace(START, focus_distance=math.inf, f_number=4.0))
    marginal = [ray for ray in shown.fans[0].rays if ray.kind == "marginal"]
    stop = shown.lens.stop_index
    heights = [abs(ray.path[stop + 1][1]) for ray in marginal]
    assert heights == pytest.approx([shown.lens.stop.semi_diameter] * 2, rel=1e-4)


def test_a_fan_has_nine_rays_and_five_when_the_stop_is_small():
    assert all(len(live(fan.rays)) == 9 for fan in sketch(replace(START, f_number=2.8)).fans)
    assert all(len(live(fan.rays)) == 5 for fan in sketch(replace(START, f_number=16.0)).fans)


@some_lenses
def test_blocked_rays_end_where_the_tracer_stops_them_and_say_why(name):
    shown = sketch(replace(START, lens=name, f_number=5.6))
    dead = [ray for fan in shown.fans for ray in fan.rays if ray.kind == "dead"]
    assert dead
    for ray in dead:
        start, way = ray.path[0], ray.path[1] - ray.path[0]
        again = lb.trace(shown.lens, [0.0, start[1], start[0]], [0.0, way[1], way[0]])
        assert again.fate[0] != lb.Fate.PASSED
        assert ray.path[-1] == pytest.approx(again.points[0][[2, 1]], abs=1e-6)
        assert any(word in ray.end for word in ("stop", "vignetted", "misses", "reflected", "backward"))


def test_the_fields_are_those_of_the_film_that_is_used():
    shown = sketch(replace(START, crop=0.5))
    assert [fan.height for fan in shown.fans] == pytest.approx([0.0, 0.7 * 0.25 * math.hypot(36, 24),
                                                                0.25 * math.hypot(36, 24)])


def test_where_the_film_is_larger_than_the_image_the_last_fan_stands_at_the_edge_of_light():
    shown = sketch(replace(START, lens="pbrt-fisheye-10mm", f_number=5.6, focus_distance=math.inf))
    edge = shown.fans[2]
    assert edge.name == "edge of light" and edge.height < shown.film_height and live(edge.rays)
    stand = bench_of(replace(START, lens="pbrt-fisheye-10mm", f_number=5.6, focus_distance=math.inf))
    areas = lb.exit_pupil(stand.lens, stand.film_distance, [0.97 * edge.height, 1.06 * edge.height]).area
    assert areas[0] > 0.0 and areas[1] == 0.0


@pytest.mark.parametrize("model", ["thin", "pinhole", "perspective"])
def test_ideal_rays_meet_on_the_film_and_at_the_distance_in_focus(model):
    settings = replace(of_kind(START, model), focus_distance=2000.0)
    shown = sketch(settings)
    object_z = shown.film_z - 2000.0 if shown.lens is not None else -2000.0
    for fan in shown.fans:
        assert {float(ray.path[-1][1]) for ray in fan.rays} == {fan.height}
        heights = []
        for ray in fan.rays:
            (z0, y0), (z1, y1) = ray.path[0], ray.path[1]
            heights.append(y0 + (object_z - z0) * (y1 - y0) / (z1 - z0))
        # Closed forms throughout: rounding over a lever of 20 times the drawn length
        assert heights == pytest.approx([heights[0]] * len(heights), abs=1e-7)


# Layout


def test_labels_pushed_apart_do_not_touch_and_keep_their_order():
    centres, widths = [10.0, 11.0, 12.0, 80.0], [8.0, 6.0, 8.0, 8.0]
    placed = pushed_apart(centres, widths, 4.0)
    for k in range(3):
        assert placed[k + 1] - placed[k] >= 0.5 * (widths[k] + widths[k + 1]) + 4.0 - 1e-9
    assert placed[3] == 80.0 and np.mean(placed[:3]) == pytest.approx(np.mean(centres[:3]), abs=1.0)


@pytest.mark.parametrize(("width", "height"), [(700.0, 170.0), (30.0, 30.0), (2000.0, 20.0), (100.0, 3000.0)])
def test_a_fitted_view_shows_all_and_its_map_can_be_undone(width, height):
    view, corner = fitted(width, height, -2.0, 90.0, 22.0, 0.0), ImVec2(13.0, 17.0)
    for z, y in ((-2.0, 22.0), (90.0, -22.0)):
        point = view.to_screen(corner, z, y)
        assert 13.0 <= point.x <= 13.0 + width and 17.0 <= point.y <= 17.0 + height
        # imgui's points are float32
        assert view.to_lens(corner, point) == pytest.approx((z, y), abs=1e-3 / view.scale)


def test_a_fitted_view_keeps_room_for_the_names_of_the_fields():
    """In a narrow panel they lay over the lens."""
    for width in (316.0, 1200.0):
        view = fitted(width, 200.0, -2.0, 90.0, 22.0, 0.0, 95.0)
        assert width - view.to_screen(ImVec2(0.0, 0.0), 90.0, 0.0).x >= min(95.0, 0.3 * width) - 1e-3


def test_the_names_of_the_fields_are_short_in_a_narrow_panel():
    shown = sketch(START)
    assert field_names(shown) == ["axis", "0.7 field", "full field"]
    assert field_names(shown, short=True) == ["axis", "0.7", "full"]


@pytest.mark.parametrize(("most", "length"), [(12.0, 10.0), (4.9, 2.0), (0.5, 0.5), (1999.0, 1000.0)])
def test_the_scale_bar_is_round(most, length):
    assert round_length(most) == pytest.approx(length)


# The panel


class Panel:
    def __init__(self, settings: Settings = START, film_radius: float | None = None):
        self.settings, self.film_radius, self.state = settings, film_radius, panel.SectionState()

    def show(self) -> None:
        self.settings = panel.lens_section_panel(self.settings, self.state, self.film_radius)


def drag(ctx, start: ImVec2, dx: float, dy: float) -> None:
    ctx.mouse_move_to_pos(start)
    ctx.mouse_down(0)
    for k in range(1, 5):
        ctx.mouse_move_to_pos(ImVec2(start.x + dx * k / 4, start.y + dy * k / 4))
        ctx.yield_()
    ctx.mouse_up(0)
    ctx.yield_(2)


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-wide-22mm", "lenshh-cooke-triplet-50"])
@pytest.mark.parametrize("size", [(280, 90), (280, 120), (300, 160), (360, 130), (420, 100), (700, 150)])
def test_the_name_of_the_stop_touches_no_sign_of_the_row_below_the_lens(monkeypatch, name, size):
    """Below, where the switches leave it no place above, it lay over them."""
    words, add = {}, imgui.ImDrawList.add_text

    def noted(draw, *args):
        if len(args) == 3:
            corner, _, text = args
            extent = imgui.calc_text_size(text)
            words[text] = corner.x, corner.y, corner.x + extent.x, corner.y + extent.y
        add(draw, *args)

    monkeypatch.setattr(imgui.ImDrawList, "add_text", noted)
    drive(Panel(replace(START, lens=name)).show, lambda ctx: ctx.yield_(4), size)
    left, top, right, bottom = words.pop("Stop")
    assert 0.0 <= left and bottom <= size[1]
    for sign in {"P", "P'", "E", "E'"} & set(words):
        x0, y0, x1, y1 = words[sign]
        assert right <= x0 or x1 <= left or bottom <= y0 or y1 <= top, sign


@pytest.mark.parametrize("is_edited", [False, True])
@pytest.mark.parametrize("width", [200, 330, 520, 700, 1000])
def test_the_reason_why_a_lens_forms_no_image_leaves_the_switches_free(monkeypatch, width, is_edited):
    """In the layout Editor it lay over them."""
    boxes, add = {}, imgui.ImDrawList.add_text

    def noted(draw, *args):
        corner, text, wrap = (args[0], args[2], 0.0) if len(args) == 3 else (args[2], args[4], args[5])
        extent = imgui.calc_text_size(text, False, wrap or -1.0)
        boxes[text] = corner.x, corner.y, corner.x + extent.x, corner.y + extent.y
        add(draw, *args)

    monkeypatch.setattr(imgui.ImDrawList, "add_text", noted)
    triplet = replace(START, lens="lenshh-cooke-triplet-50", f_number=None)
    shown = Panel(edited(triplet, lambda document: deleted(document, [0]))[0])
    shown.state.edit.active = is_edited
    drive(shown.show, lambda ctx: ctx.yield_(4), (width, 200))
    [(left, top, right, bottom)] = [boxes.pop(text) for text in list(boxes) if "does not converge" in text]
    assert 0.0 <= left and right <= width
    switches = [box for text, box in boxes.items() if text.endswith(("Blocked rays", "Edit", "y–z"))]
    assert switches
    for x0, y0, x1, y1 in switches:
        assert right <= x0 or x1 <= left or bottom <= y0 or y1 <= top


def test_the_film_is_dragged_to_focus_and_the_stop_to_another_f_number():
    panel = Panel(replace(START, focus_position="paraxial"))
    values = {}

    def test(ctx):
        ctx.yield_(3)
        scale = panel.state.view.scale
        before = bench_of(panel.settings)
        drag(ctx, centre(ctx, "**/Film plane"), 10.0, 0.0)
        after = bench_of(panel.settings)
        values["film"] = (after.film_distance - before.film_distance) * scale
        drag(ctx, centre(ctx, "**/Film plane"), -60.0, 0.0)
        values["far"] = panel.settings.focus_distance
        drag(ctx, centre(ctx, "**/Film plane"), 500.0, 0.0)
        values["near"] = panel.settings.focus_distance
        ctx.mouse_move_to_pos(centre(ctx, "**/Stop edge"))
        before = bench_of(panel.settings)
        drag(ctx, centre(ctx, "**/Stop edge"), 0.0, 8.0)
        after = bench_of(panel.settings)
        values["stop"] = (before.lens.stop.semi_diameter - after.lens.stop.semi_diameter) * scale
        drag(ctx, centre(ctx, "**/Stop edge, lower"), 0.0, 900.0)
        values["open"] = panel.settings.f_number

    drive(panel.show, test, (720, 200))
    nearest = lb.nearest_focus(design(START))
    # The mouse moves by whole pixels, imgui's handle drag starts with the press: 10 and 8 pixels, exactly
    assert values["film"] == pytest.approx(10.0, abs=1e-3)
    assert values["far"] == math.inf
    assert values["near"] == pytest.approx(nearest, rel=1e-9)
    assert values["stop"] == pytest.approx(8.0, abs=1e-3)
    assert values["open"] == pytest.approx(lb.first_order(design(START)).f_number, rel=1e-9)


@pytest.mark.slow
def test_where_groups_focus_the_film_stays_and_is_pulled_to_what_it_would_focus():
    nikkor = "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed"
    panel = Panel(replace(START, lens=nikkor, focus_distance=math.inf, zoom=1.0, f_number=None,
                          focus_position="paraxial"))
    values = {}

    def test(ctx):
        ctx.yield_(3)
        scale = panel.state.view.scale
        infinity = bench_of(panel.settings)
        drag(ctx, centre(ctx, "**/Film plane"), 10.0, 0.0)
        near = bench_of(panel.settings)
        values["distance"] = panel.settings.focus_distance
        values["unit"] = lb.focused_distance(infinity.lens, infinity.film_distance + 10.0 / scale)
        values["film"] = near.film_z - infinity.film_z
        values["moved"] = infinity.lens.surfaces[4].thickness - near.lens.surfaces[4].thickness
        drag(ctx, centre(ctx, "**/Film plane"), -10.0, 0.0)
        values["back"] = panel.settings.focus_distance
        drag(ctx, centre(ctx, "**/Film plane"), 500.0, 0.0)
        values["nearest"] = panel.settings.focus_distance

    drive(panel.show, test, (720, 200))
    assert values["distance"] == pytest.approx(values["unit"], rel=1e-9)
    assert values["film"] == pytest.approx(0.0, abs=1e-4) and values["moved"] > 0.1    # the table's own rounding
    assert values["back"] > 1e8
    assert values["nearest"] == pytest.approx(1500.0, rel=1e-5)


@pytest.mark.slow
def test_wheel_zooms_at_the_mouse_drag_pans_and_a_double_click_fits():
    panel = Panel()
    views = []

    def test(ctx):
        ctx.yield_(3)
        views.append(panel.state.view)
        point = ImVec2(200.0, 60.0)
        ctx.mouse_move_to_pos(point)
        ctx.mouse_wheel(ImVec2(0.0, 3.0))
        ctx.yield_(2)
        views.append(panel.state.view)
        drag(ctx, point, 30.0, 20.0)
        views.append(panel.state.view)
        ctx.yield_(40)
        ctx.mouse_double_click(0)
        ctx.yield_(3)
        views.append(panel.state.view)

    drive(panel.show, test, (720, 200))
    fit, zoomed, panned, again = views
    assert zoomed.scale > 1.3 * fit.scale
    # The point under the mouse (its place in the panel is 10, 8 off the window's) stays
    assert (190.0 - zoomed.x) / zoomed.scale == pytest.approx((190.0 - fit.x) / fit.scale, abs=0.5 / fit.scale)
    assert (panned.x - zoomed.x, panned.y - zoomed.y) == pytest.approx((30.0, 20.0), abs=1e-3)
    assert again == fit
    assert panel.settings == START


@pytest.mark.slow
def test_blocked_rays_are_shown_or_not_and_tooltips_appear_on_what_is_drawn():
    panel = Panel(film_radius=15.0)
    states = []

    def test(ctx):
        states.append(panel.state.blocked_rays)
        ctx.item_click("**/Blocked rays")
        ctx.yield_(2)
        states.append(panel.state.blocked_rays)
        ctx.item_click("**/Blocked rays")
        for x in range(60, 700, 24):
            ctx.mouse_move_to_pos(ImVec2(float(x), 95.0 - 0.03 * x))
            ctx.yield_()

    drive(panel.show, test, (720, 200))
    assert states == [True, False]


STATES = {
    "no lens": replace(START, lens="no-such-lens"), "too near": replace(START, focus_distance=3.0),
    "too open": replace(START, f_number=0.3), "perspective": replace(START, camera="perspective", f_number=None),
    "huge film": replace(START, film_width=4000.0, film_height=4000.0),
    "closed": replace(START, f_number=900.0, focus_distance=math.inf), "nothing": replace(START, film_width=0.0),
}


@pytest.mark.parametrize("size", [(4, 4), (30, 25), (60, 700), (1600, 90)])
def test_the_section_lives_in_any_window_and_any_state(size):
    panel = Panel(film_radius=12.0)

    def test(ctx):
        for state in STATES.values():
            panel.settings = state
            ctx.yield_(2)
            assert panel.settings == state

    drive(panel.show, test, size)


def test_a_lens_too_steep_for_the_view_from_above_says_so_and_is_turned_back(tmp_path):
    lens = posed(lenses.load("lenshh-cooke-triplet-50"), 2, 2, tilt_x=math.radians(60.0), tilt_y=math.radians(60.0))
    lenses.save(lens, tmp_path / "steep.toml")
    panel = Panel(replace(START, lens=str(tmp_path / "steep.toml"), f_number=None))
    panel.state.above = True

    def test(ctx):
        ctx.yield_(2)
        with pytest.raises(ValueError, match="must lie from −60° to 60°"):
            sketch(panel.settings, above=True)
        ctx.item_click("**/Section side")
        ctx.yield_(2)
        assert not panel.state.above

    drive(panel.show, test, (800, 300))


def test_the_lens_before_its_edits_lies_where_they_have_changed_nothing():
    from lensbench.app.panels.lens_section.handles import ghost_of
    from lensbench.app.plots.section import sketch
    from lensbench.app.session.edited_lens import edited, reverted
    from lensbench.lenses.editing.cells import with_value

    settings = Settings()
    wider, _ = edited(settings, lambda d: with_value(d, 5, "thickness", d.surfaces[5].thickness + 1.0))
    shown = sketch(wider)
    ghost = ghost_of(reverted(wider), wider, shown)
    assert (ghost.shift, ghost.name) == (0.0, "original")
    compared = ghost_of(replace(settings, f_number=8.0), wider, shown)
    assert compared.name == "A" and compared.shift == shown.film_z - compared.sketch.film_z != 0.0
