"""Pipes, devices, sockets and folders: every reader refuses each at once, in one line."""

import os
import socket
import threading
from pathlib import Path

import pytest

from lensbench import lenses
from lensbench.app.bench.build import stop_picture
from lensbench.app.command.lens_files import read_rays
from lensbench.app.scenes.scene_file import cached_scene, load_scene, scene_files
from lensbench.app.session.edited_lens import document_named
from lensbench.app.session.export import read_settings
from lensbench.app.session.file_kinds import file_kind
from lensbench.app.session.recordings import load_light_field
from lensbench.app.session.states import load_settings
from lensbench.lenses.file_error import open_regular
from lensbench.lenses.glass import agf
from lensbench.lenses.picture_file import read_picture_file
from lensbench.lenses.stop_picture import read_picture

SECONDS = 20.0
BALL = '[[sphere]]\ncentre = [0, 0, -1000]\nradius = 100\n'


def named_by_scene(text):
    """A reader of a file that a scene names."""
    def read(path):
        scene = path.parent / "scene.toml"
        scene.write_text(text.format(path.name))
        load_scene(scene)

    return read


READERS = {
    "lens": ("a.zmx", lenses.load), "lens of the project": ("a.toml", lenses.load),
    "edited lens": ("a.toml", lambda path: document_named(str(path))),
    "scene": ("a.toml", load_scene), "scene of the window": ("b.toml", lambda path: cached_scene(str(path))),
    "settings": ("a.toml", load_settings), "settings in PNG": ("a.png", load_settings),
    "settings in EXR": ("a.exr", read_settings), "settings in PPM": ("a.ppm", read_settings),
    "recording": ("a.npz", load_light_field), "glass catalogue": ("a.agf", agf.read),
    "picture": ("a.png", read_picture_file), "picture in the stop": ("a.png", read_picture),
    "stop of the settings": ("a.png", lambda path: stop_picture(str(path))),
    "rays": ("a.csv", lambda path: read_rays(str(path))),
    "kind of a dropped file": ("a.toml", file_kind), "any": ("a", open_regular),
    "texture": ("a.png", named_by_scene('[floor]\ntexture = "{}"\n')),
    "sky": ("a.hdr", named_by_scene('[sky]\nimage = "{}"\n')),
    "photograph": ("a.jpg", named_by_scene('[photograph]\nimage = "{}"\n')),
    "depth map": ("a.exr", named_by_scene('[photograph]\nfov = 50\nimage = "x.png"\ndepth = "{}"\n')),
    "mesh": ("a.obj", named_by_scene('[[mesh]]\nfile = "{}"\n')),
}


def place(kind, path):
    """Something at a path that is no ordinary file; what must stay alive."""
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "folder":
        path.mkdir()
    else:
        server = socket.socket(socket.AF_UNIX)
        server.bind(str(path))
        return server
    return None


@pytest.mark.parametrize("kind", ["pipe", "device", "socket", "folder"])
@pytest.mark.parametrize("reader", READERS)
def test_what_is_no_ordinary_file_is_refused_at_once_in_one_line(reader, kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)                             # the path of a socket is short
    name, read = READERS[reader]
    kept = place(kind, Path(name))
    caught = []

    def run():
        try:
            read(tmp_path / name)
        except (ValueError, OSError) as error:
            caught.append(error)

    thread = threading.Thread(target=run, daemon=True)      # a reader that waits does not hold up the tests
    thread.start()
    thread.join(SECONDS)
    assert not thread.is_alive(), "it waits for the file"
    assert len(caught) == 1
    text = str(caught[0]) if not isinstance(caught[0], OSError) else caught[0].strerror
    assert "\n" not in text and ("folder" in text or "device" in text)
    if kept is not None:
        kept.close()


def test_an_ordinary_file_behind_a_link_is_read_and_a_missing_one_is_named(tmp_path):
    (tmp_path / "a").write_bytes(b"content")
    (tmp_path / "link").symlink_to("a")
    with open_regular(tmp_path / "link") as file:
        assert file.read() == b"content"
    with pytest.raises(FileNotFoundError):
        open_regular(tmp_path / "none")


def test_the_stamp_and_the_names_of_a_scene_that_is_a_pipe_wait_for_nothing(tmp_path):
    os.mkfifo(tmp_path / "a.toml")
    assert scene_files(str(tmp_path / "a.toml")) == (tmp_path / "a.toml",)
