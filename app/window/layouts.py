"""Layouts of the window: which panels are shown, and where. The render lies in the middle of each."""

from dataclasses import dataclass

from imgui_bundle import hello_imgui, imgui


@dataclass(frozen=True)
class Layout:
    """Panels by dock, the front tab first; what is for whom in words; and the width of the right column.

    right: its part of the window; narrowest and widest in em. Docks: Left, LeftBottom, Bottom, Right, RightBottom, and
    BottomRight where there are panels for it.
    """

    about: str
    docks: dict[str, tuple[str, ...]]
    right: tuple[float, float, float] = (0.215, 19.4, 30.0)
    bottom: float = 0.30


LEFT = {"Left": ("Controls",), "LeftBottom": ("Read-outs", "Lens card", "Spaces")}
BENCH = "Bench"
LAYOUTS = {
    BENCH: Layout(
        "Picture, section, blur and pupil", {
            **LEFT, "Bottom": ("Section", "Surfaces", "3-D", "Stability", "Moments"),
            "Right": ("Circle of confusion", "Plan", "Pixel"),
            "RightBottom": ("Exit pupil", "Falloff", "Models", "Light field")}),
    "Photographer": Layout(
        "Picture, section, and how sharp the lens draws", {
            **LEFT, "Bottom": ("Section", "3-D", "Moments"),
            "Right": ("MTF", "MTF map", "Focus shift", "Depth of field", "Illumination"),
            "RightBottom": ("Bokeh", "Sunstar", "Spots", "Pixel")}, (0.25, 19.4, 46.0)),
    "Student": Layout(
        "Coordinate spaces, stability of the formulas, models of the lens", {
            "Left": ("Controls",), "LeftBottom": ("Spaces", "Read-outs", "Lens card"),
            "Bottom": ("Section", "3-D", "Stability", "Moments"),
            "Right": ("Models", "Circle of confusion", "Plan"), "RightBottom": ("Exit pupil", "Pixel", "Falloff")}),
    "Designer": Layout(
        "Spots and the aberrations behind them", {
            **LEFT, "Bottom": ("Section", "3-D", "Moments"), "BottomRight": ("Seidel", "Illumination"),
            "Right": ("Spots", "Wavefront", "Point spread", "Field curves"),
            "RightBottom": ("Ray fans", "MTF", "MTF map")}, (0.30, 22.0, 70.0), 0.36),
    "Editor": Layout(
        "Surfaces to edit, the section, and what an edit does to the picture", {
            **LEFT, "Bottom": ("Section", "3-D", "Moments"), "BottomRight": ("Surfaces",),
            "Right": ("Spots", "MTF", "Field curves"), "RightBottom": ("Ray fans", "Wavefront", "Seidel")},
        (0.26, 21.0, 60.0), 0.36),
}


def splits(name: str, width: float, height: float, em: float) -> list[hello_imgui.DockingSplit]:
    """The splits of a window of this size (pixels) for a layout: columns at the sides, the section below."""
    chosen, side = LAYOUTS[name], imgui.Dir
    part, least, most = chosen.right
    left = min(max(0.165 * width, 18.0 * em), 22.0 * em)
    right = min(max(part * width, least * em), most * em)
    made = [
        hello_imgui.DockingSplit("MainDockSpace", "Left", side.left, min(left / width, 0.4)),
        hello_imgui.DockingSplit("MainDockSpace", "Right", side.right, min(right / max(width - left, 1.0), 0.45)),
        hello_imgui.DockingSplit("MainDockSpace", "Bottom", side.down, chosen.bottom),
        hello_imgui.DockingSplit("Left", "LeftBottom", side.down, min(max(1.0 - 32.6 * em / height, 0.28), 0.45)),
        hello_imgui.DockingSplit("Right", "RightBottom", side.down, 0.55),
    ]
    if "BottomRight" in chosen.docks:
        made.append(hello_imgui.DockingSplit("Bottom", "BottomRight", side.right, 0.5))
    return made


def placed(name: str, windows: list[hello_imgui.DockableWindow]) -> list[hello_imgui.DockableWindow]:
    """The panels in the order of a layout, shown in its docks; the others are hidden, the render stays.

    The first of each dock is its front tab.
    """
    docks = {panel: (dock, panel == panels[0]) for dock, panels in LAYOUTS[name].docks.items() for panel in panels}
    for window in windows:
        if window.label in docks:
            window.dock_space_name, window.focus_window_at_next_frame = docks[window.label]
            window.is_visible = True
        elif window.dock_space_name != "MainDockSpace":
            window.dock_space_name, window.is_visible = "Right", False
    order = list(docks)
    return sorted(windows, key=lambda window: order.index(window.label) if window.label in docks else len(order))
