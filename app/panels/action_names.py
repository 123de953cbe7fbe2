"""Every action of the window by name: its keys, its group in the sheet of keys, and its tooltip.

Menus, command palette, toolbar, keys and the sheet of keys read this table. `window.actions` binds each name to what
it does. Keys are written as people read them; alternatives are separated by " or ".
"""

from typing import NamedTuple

VIEW, RENDER, FILES, COMPARISON, DIALS = "View", "Render", "Files and window", "Comparison", "Dials"


class Named(NamedTuple):
    """Keys, heading in the sheet of keys ("" leaves the action out), and tooltip of an action."""

    keys: str = ""
    group: str = ""
    tip: str = ""


ACTION_NAMES: dict[str, Named] = {
    "Fit picture": Named("F", VIEW, "Show the whole picture"),
    "Zoom to 100 %": Named("1", VIEW, "One pixel of the picture for one of the screen\n"
                           "Ctrl+wheel zooms, Ctrl+drag moves the picture"),
    "Focus peaking": Named("P", VIEW, "Mark edges in focus in amber"),
    "Circle of confusion": Named("C", VIEW, "Show the circle of confusion in pixels as false colour: amber in focus, "
                                 "blue nearer, pink farther"),
    "Plane of focus": Named("O", VIEW, "Draw the plane of focus through the scene as a sheet of amber, denser between "
                            "the near and the far limit; a tilted film tilts it"),
    "Make these sharp": Named(tip="Click two or three things in the picture: tilt and swing of the film, and the "
                              "focus, are solved so that\nthe plane of focus runs through them. Undo takes it back"),
    "Clipping": Named("Z", VIEW, "Stripe the areas that are fully white (orange) or black (blue)"),
    "Histogram": Named("H", VIEW, "Histogram of the tone-mapped picture"),
    "Next view of the samples": Named("V", VIEW),
    "Magnifier": Named("M", VIEW, "Magnify the pixels at the mouse and show their values\n"
                       "Alt+wheel sets the magnification; the highest shows a grid of numbers"),
    "Pin pixel": Named("I", VIEW, "Pin the pixel under the mouse, or unpin it: its rays stay in the section, the exit "
                       "pupil, the plan and the panel “Pixel”"),
    "Look around": Named(tip="Look around inside the panorama: drag to turn, wheel for the angle of view, double click "
                         "to look ahead"),
    "Render follows window": Named(tip="One pixel of the picture for each pixel of the screen that shows it; otherwise "
                                   "the picture keeps the pixels that it has"),
    "Reset camera": Named("Home", VIEW, "Move the camera to where the scene opens, framed and focused on its subject"),
    "Pin picture as A": Named("A", COMPARISON, "Keep the current picture as the reference A; it goes on refining"),
    "Compare side by side": Named("S", COMPARISON, "Reference A at the left, current picture at the right"),
    "Compare with a wipe": Named("W", COMPARISON, "Reference A and current picture in one place: drag the line between "
                                 "them"),
    "Show difference": Named("D", COMPARISON, "Difference of the current picture from A, channel by channel, in linear "
                             "light"),
    "Lock A's dials to B": Named("K", COMPARISON, "A follows every dial turned in B: focus, aperture, exposure, camera "
                                 "position, scene…\nIt keeps its own lens and camera model"),
    "Pause": Named("Space", RENDER, "Pause or resume the render"),
    "Restart render": Named("R", RENDER, "Restart the render"),
    "Undo": Named("Ctrl+Z", RENDER),
    "Redo": Named("Ctrl+Shift+Z or Ctrl+Y", RENDER),
    "Turn dials by keys": Named("T", DIALS, "Give the keyboard to the first dial: Tab and the arrows up and down pass "
                                "it on, left and right turn it\nShift for fine steps, Page Up and Down for full stops, "
                                "Enter to type, Escape to let go"),
    "Focus nearer": Named("[", DIALS),
    "Focus farther": Named("]", DIALS),
    "Open aperture": Named(",", DIALS, "Open the aperture by a third of a stop"),
    "Close aperture": Named(".", DIALS, "Close the aperture by a third of a stop"),
    "Expose less": Named("-", DIALS, "Darken the picture by a third of a stop"),
    "Expose more": Named("+ or =", DIALS, "Brighten the picture by a third of a stop"),
    "Command palette…": Named("Ctrl+K", FILES),
    "Keys and mouse": Named("F1 or ?", FILES),
    "What the terms mean": Named(),
    "Lens browser…": Named("L", FILES),
    "Open…": Named("Ctrl+O", FILES, "Open a lens, a scene, a mesh, a sky, a photograph with depth, settings, a picture "
                   "with its settings, or a light field; a file can also be dropped on the window"),
    "Adjust scene…": Named(tip="Height, turn and material of an opened mesh; turn and brightness of a sky; depth of a "
                               "photograph"),
    "Save scene as…": Named(tip="Write the scene as a scene file, with copies of the files that it names elsewhere"),
    "Save lens…": Named(),
    "Save lens edits": Named("Ctrl+Shift+S", FILES, "Save to the file the lens was opened from; a library lens gets a "
                             "file of its own"),
    "Revert lens": Named(tip="Discard all edits of the surfaces; undo brings them back"),
    "Improve lens…": Named(tip="Let radii or other numbers change until the spots are smaller: in the panel Surfaces"),
    "Save settings…": Named(),
    "Export…": Named("Ctrl+E", FILES, "Render at any size and number of samples, and save"),
    "Save picture…": Named("Ctrl+S", FILES, "Save the picture as it is now, with its settings"),
    "Save screenshot…": Named(tip="Save a picture of the whole window"),
    "Save intrinsics…": Named(tip="Save camera intrinsics and pose as JSON"),
    "Keep snapshot": Named("B", FILES, "Keep the picture with its settings in the panel Snapshots"),
    **{f"Open snapshot {number}": Named(f"Alt+{number}", "", "Open it, or compare it with the reference A")
       for number in range(1, 10)},
    "Contact sheet…": Named(tip="Render several lenses in the current framing, with captions, as one picture"),
    "Copy picture": Named("Ctrl+C", FILES, "Copy the picture to the clipboard"),
    "Copy state as text": Named("Ctrl+Shift+C", FILES, "Copy the settings as a short text for a message: paste it "
                                "here, or open it by lensbench view TEXT"),
    "Paste state": Named("Ctrl+V", FILES, "Open the settings of a state text on the clipboard"),
    "Reset all": Named(tip="Reset all settings except lens and scene"),
    "Dark theme": Named(),
    "Light theme": Named(),
    "Hide panels": Named("Tab", FILES, "Hide all panels but the picture, or show them again"),
    "Full screen": Named("F11", FILES),
    "Reset layout": Named(tip="Put every panel of the layout back in its place, for the current size of the window"),
    "Dismiss all notices": Named(),
    "Quit": Named("Ctrl+Q", FILES),
}


def key_of(name: str) -> str:
    """The first of the keys of an action; "" without any."""
    return ACTION_NAMES[name].keys.split(" or ")[0]


def tip_of(name: str) -> str:
    """The tooltip of an action with its key: its name where nothing more is to be explained."""
    first, *rest = (ACTION_NAMES[name].tip or name).split("\n", 1)
    return "\n".join([f"{first} ({key_of(name)})" if key_of(name) else first, *rest])
