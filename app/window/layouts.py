"""Layouts of the window: which panels are shown, and where. The render lies in the middle of each."""

from dataclasses import dataclass

from imgui_bundle import hello_imgui, imgui


@dataclass(frozen=True)
class Layout:
    """Panels by dock, the front tab first; what is for whom in words; and the width of the right column.

    right: its part of the window; narrowest and widest in em. Docks: Left, LeftBottom, Bottom, Right, RightBottom, and
    BottomRight where there are panels for it. white: light of analyses, one of WHITES.
    """

    about: str
    docks: dict[str, tuple[str, ...]]
    right: tuple[float, float, float] = (0.215, 19.4, 30.0)
    bottom: float = 0.30
    white: str = "picture"


LEFT = {"Left": ("Controls",), "LeftBottom": ("Read-outs", "Lens card", "Spaces")}
BENCH = "Bench"
CONTROLS = 32.6                 # em: height of a window whose controls need not scroll
SHORT, LOW = 45.3, 32.0         # em: heights below which the read-outs, and the dock below the picture, fold
NARROWEST = 19.4                # em: of a dock next to another below the picture
LAYOUTS = {
    BENCH: Layout(
        "Picture, section, blur and pupil", {
            **LEFT, "Bottom": ("Section", "Surfaces", "3-D", "Stability", "Snapshots"),
            "Right": ("Circle of confusion", "Plan", "Pixel"),
            "RightBottom": ("Exit pupil", "Falloff", "Models", "Light field")}),
    "Photographer": Layout(
        "Picture, section, and how sharp the lens draws", {
            **LEFT, "Bottom": ("Section", "3-D", "Snapshots"),
            "Right": ("MTF", "MTF map", "Focus shift", "Depth of field", "Illumination"),
            "RightBottom": ("Bokeh", "Sunstar", "Spots", "Pixel")}, (0.25, 19.4, 46.0)),
    "Student": Layout(
        "Coordinate spaces, stability of the formulas, models of the lens", {
            "Left": ("Controls",), "LeftBottom": ("Spaces", "Read-outs", "Lens card"),
            "Bottom": ("Section", "3-D", "Stability", "Snapshots"),
            "Right": ("Models", "Circle of confusion", "Plan"), "RightBottom": ("Exit pupil", "Pixel", "Falloff")}),
    "Designer": Layout(
        "Spots and the aberrations behind them", {
            **LEFT, "Bottom": ("Section", "3-D", "Snapshots"), "BottomRight": ("Seidel", "Illumination"),
            "Right": ("Spots", "Wavefront", "Point spread", "Field curves"),
            "RightBottom": ("Ray fans", "MTF", "MTF map", "Ghosts")}, (0.30, 22.0, 70.0), 0.36, "lens"),
    "Editor": Layout(
        "Surfaces to edit, the section, and what an edit does to the picture", {
            **LEFT, "Bottom": ("Section", "3-D", "Snapshots"), "BottomRight": ("Surfaces",),
            "Right": ("Spots", "MTF", "Field curves"), "RightBottom": ("Ray fans", "Wavefront", "Seidel")},
        (0.26, 21.0, 60.0), 0.36, "lens"),
}


def folds(name: str, width: float, height: float, em: float) -> dict[str, str]:
    """Docks that a window of this size (pixels) has no room for, and the docks that take their panels as tabs.

    The right column folds before the picture has less than half of the width, the dock below the picture before it has
    less than half of the height, and the read-outs before the controls have to scroll.
    """
    narrow = _left(width, em) + LAYOUTS[name].right[1] * em > 0.5 * width
    if height < LOW * em:
        into = "Left" if narrow else "Right"
        return {"LeftBottom": "Left", "Bottom": into, "BottomRight": into, "Right": into, "RightBottom": into}
    taken = {"LeftBottom": "Left"} if height < SHORT * em else {}
    if narrow:
        halves = width - _left(width, em) >= 2.0 * NARROWEST * em
        into = "BottomRight" if halves else "Bottom"
        taken |= {"BottomRight": into, "Right": into, "RightBottom": into}
    return {dock: into for dock, into in taken.items() if dock != into}


def docks(name: str, folded: dict[str, str]) -> dict[str, tuple[str, ...]]:
    """Panels by dock, as the window has them. folded: docks without room, and those that take their panels."""
    panels_of: dict[str, tuple[str, ...]] = {}
    for dock, panels in LAYOUTS[name].docks.items():
        into = folded.get(dock, dock)
        panels_of[into] = panels_of.get(into, ()) + panels
    return panels_of


def splits(name: str, width: float, height: float, em: float) -> list[hello_imgui.DockingSplit]:
    """The splits of a window of this size (pixels) for a layout: columns at the sides, the section below."""
    chosen, side, used = LAYOUTS[name], imgui.Dir, docks(name, folds(name, width, height, em))
    share, least, most = chosen.right
    left = _left(width, em)
    right = min(max(share * width, least * em), most * em, max(0.5 * width - left, least * em))
    made = [
        hello_imgui.DockingSplit("MainDockSpace", "Left", side.left, left / width),
        hello_imgui.DockingSplit("MainDockSpace", "Right", side.right, min(right / max(width - left, 1.0), 0.5)),
        hello_imgui.DockingSplit("MainDockSpace", "Bottom", side.down, chosen.bottom),
        hello_imgui.DockingSplit("Left", "LeftBottom", side.down, min(1.0 - CONTROLS * em / height, 0.5)),
        hello_imgui.DockingSplit("Right", "RightBottom", side.down, 0.55),
        hello_imgui.DockingSplit("Bottom", "BottomRight", side.right, 0.5),
    ]
    return [split for split in made if split.new_dock in used]


def _left(width: float, em: float) -> float:
    return min(max(0.165 * width, 18.0 * em), 22.0 * em, 0.42 * width)


def placed(name: str, folded: dict[str, str], windows: list[hello_imgui.DockableWindow],
           ) -> list[hello_imgui.DockableWindow]:
    """The panels in the order of a layout, shown in its docks; the others are hidden, the render stays.

    The first of each dock is its front tab.
    """
    places = {panel: (dock, panel == panels[0]) for dock, panels in docks(name, folded).items() for panel in panels}
    for window in windows:
        if window.label in places:
            window.dock_space_name, window.focus_window_at_next_frame = places[window.label]
            window.is_visible = True
        elif window.dock_space_name != "MainDockSpace":
            window.dock_space_name, window.is_visible = folded.get("Right", "Right"), False
    order = list(places)
    return sorted(windows, key=lambda window: order.index(window.label) if window.label in places else len(order))
