"""Radio buttons and check boxes are drawn with an edge everywhere: off, their fill alone is hardly seen."""

import re
from pathlib import Path

APP = Path(__file__).parents[3] / "app"


def test_no_panel_draws_a_box_without_an_edge():
    bare = re.compile(r"imgui\.(checkbox|checkbox_flags|radio_button)\(")
    drawn = {path.relative_to(APP).as_posix() for path in APP.rglob("*.py")
             if bare.search(path.read_text(encoding="utf-8"))}
    assert drawn == {"drawing/controls.py"}
