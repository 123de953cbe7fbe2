"""Requests of panels, menus and keys to the window."""

from enum import Enum, auto


class Request(Enum):
    """The window answers a request at the beginning of its next frame."""

    # The render
    PAUSE = auto()                      # or go on
    RESTART = auto()
    PIN = auto()                        # keep the picture as A
    EXPORT = auto()

    # Files to open
    OPEN_LENS = auto()
    OPEN_SCENE = auto()
    OPEN_PICTURE = auto()
    OPEN_SETTINGS = auto()
    OPEN_LIGHT_FIELD = auto()
    OPEN_STOP_IMAGE = auto()

    # Files to save
    SAVE_LENS = auto()
    SAVE_EDITED = auto()                # the edited lens, in its own file
    SAVE_SETTINGS = auto()
    SAVE_INTRINSICS = auto()
    SAVE_RENDER = auto()
    SAVE_WINDOW = auto()
    SAVE_LIGHT_FIELD = auto()
    SAVE_REFOCUSED = auto()
    SAVE_PLOT_CSV = auto()              # the figure of an analysis
    SAVE_PLOT_SVG = auto()
    SAVE_PLOT_PNG = auto()
    CHOOSE_EXPORT_PATH = auto()

    # The light field
    RECORD = auto()
    FIND_DEPTH = auto()
    COMPARE = auto()                    # render the same picture with the camera

    # The window
    BROWSE_LENSES = auto()
    RESET_LAYOUT = auto()
    SHOW_HELP = auto()
    SHOW_PALETTE = auto()
    SHOW_TERMS = auto()

    # Moments
    KEEP_MOMENT = auto()
    COPY_PICTURE = auto()
    COPY_STATE = auto()
    PASTE = auto()
    SAVE_CARD = auto()
