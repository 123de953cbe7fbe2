"""The examples of the documentation run unchanged, one after the other."""

import json
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from lensbench import lenses
from lensbench.app.command.main import main
from lensbench.core.optics.finding import Kind, note

DOCS = Path(__file__).parents[3] / "docs"
# Examples, at least
PAGES = {"python.md": 3, "own-cameras.md": 4, "exercises.md": 8, "editing.md": 1, "course-notes.md": 6}
MOST_LINES = 20                 # of an exercise


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_the_examples_of_a_page_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    examples = re.findall(r"```python\n(.*?)```", (DOCS / page).read_text(encoding="utf-8"), re.DOTALL)
    assert len(examples) >= PAGES[page]
    names = {"__name__": "__main__"}
    for example in examples:
        assert page != "exercises.md" or example.count("\n") <= MOST_LINES
        exec(compile(example, page, "exec"), names)
    if page == "exercises.md":                  # the eyes of the pair see the screen's middle at the same place
        for offset in (-32.0, 32.0):
            pixel, _ = names["eye"](offset).raster_from_point([[0.0, 0.0, -1200.0]])
            np.testing.assert_allclose(pixel, [[120.0, 80.0]], atol=1e-9)


@pytest.mark.slow
def test_the_example_of_the_analyses_has_the_figures_of_the_command(tmp_path):
    example = next(block for block in re.findall(r"```python\n(.*?)```", (DOCS / "analysis.md").read_text("utf-8"),
                                               re.DOTALL) if "white_rms_radius" in block)
    names: dict = {}
    exec(compile(example, "analysis.md", "exec"), names)
    path = tmp_path / "spots.json"
    assert main(["analyse", "lib-tronnier-1953", "--what", "spots", "-o", str(path)]) == 0
    columns = json.loads(path.read_text("utf-8"))["analyses"]["spots"]["columns"]
    rows = zip(*(columns[name] for name in ("field (mm)", "film shift (mm)", "wavelength (um)", "rms radius (um)")),
               strict=True)
    shown = {line: radius for field, shift, line, radius in rows if field == shift == 0.0}
    spots = names["lb"].analysis.spots(names["grid"])
    radii = dict(zip(names["light"].wavelengths, (1000.0 * spots.rms_radius[0, :, 0]).tolist(), strict=True))
    assert len(shown) == 6 and shown == pytest.approx(radii, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("notebook", ["pbr_chapter_6", "photographer", "designer"])
def test_a_notebook_runs(notebook, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(lenses, "check", lambda lens: [note(Kind.FOCAL_LENGTH, "what a check finds")])
    runpy.run_path(str(DOCS / "notebooks" / f"{notebook}.py"))
    pictures = list(tmp_path.glob("*.png"))
    assert pictures and all(picture.stat().st_size > 10_000 for picture in pictures)
