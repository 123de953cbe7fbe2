"""A picture on the clipboard of the system, by the program that the system has for it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

SECONDS = 5.0


class ClipboardError(ValueError):
    """No picture can be copied; the message says what to do."""


def command(path: Path) -> tuple[list[str], bool]:
    """The program that copies a PNG, with its arguments; and whether it reads the picture from its standard input."""
    if sys.platform == "darwin":
        text = str(path).replace("\\", "\\\\").replace('"', '\\"')
        return ["osascript", "-e", f'set the clipboard to (read (POSIX file "{text}") as «class PNGf»)'], False
    if sys.platform == "win32":
        text = str(path).replace("'", "''")
        return ["powershell", "-NoProfile", "-Sta", "-Command",
                "Add-Type -AssemblyName System.Windows.Forms, System.Drawing; [Windows.Forms.Clipboard]::SetImage("
                f"[Drawing.Image]::FromFile('{text}'))"], False
    if os.environ.get("WAYLAND_DISPLAY") and shutil.which("wl-copy"):
        return ["wl-copy", "--type", "image/png"], True
    if os.environ.get("DISPLAY") and shutil.which("xclip"):
        return ["xclip", "-selection", "clipboard", "-t", "image/png", "-i"], True
    raise ClipboardError("a picture is copied by wl-copy (Wayland) or xclip (X11): install one of them, or save it")


def copy_picture(path: Path) -> None:
    """Put a PNG file on the clipboard; ClipboardError if it cannot be."""
    program, piped = command(path)
    try:
        with path.open("rb") as file:
            subprocess.run(program, stdin=file if piped else subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL, check=True, timeout=SECONDS)
    except (OSError, subprocess.SubprocessError) as error:
        raise ClipboardError(f"{program[0]} could not copy the picture: {error}") from error
