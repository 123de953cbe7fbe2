"""The fonts of the window hold every character that the program can write there."""

import ast
from collections import defaultdict
from pathlib import Path

from imgui_bundle import imgui

from tests.app.stand import drive

ROOT = Path(__file__).parents[3]
READ_ALONE = set("\x7f⌀")         # in what users give, never written


def written(path: Path) -> set[str]:
    """The characters of the texts in a source file, without its docstrings and comments."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    docs = {id(node.body[0].value) for node in ast.walk(tree)
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and isinstance(node.body[0], ast.Expr)}
    return {character for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)
            and id(node) not in docs for character in node.value}


def test_the_fonts_hold_every_character_that_the_program_writes():
    """Powers of aspheres, exponents and the numbers of tilted and decentred surfaces were boxes."""
    files = defaultdict(list)
    for folder in ("app", "core", "lenses"):
        for path in (ROOT / folder).rglob("*.py"):
            for character in set(path.read_text(encoding="utf-8")):
                if ord(character) > 126 and character not in READ_ALONE:
                    files[character].append(path)
    missing: list[str] = []
    drive(lambda: None, lambda ctx: missing.extend(
        character for character in files if not imgui.get_font().is_glyph_in_font(ord(character))))
    assert {character for character in missing if any(character in written(path) for path in files[character])} == set()
