"""The examples of the documentation run unchanged, one after the other."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from lensbench import lenses
from lensbench.optics.finding import Kind, note

DOCS = Path(__file__).parents[3] / "docs"
PAGES = {"python.md": 3, "own-cameras.md": 4, "exercises.md": 8, "editing.md": 1}      # examples, at least
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
            at, _ = names["eye"](offset).raster_from_point([[0.0, 0.0, -1200.0]])
            np.testing.assert_allclose(at, [[120.0, 80.0]], atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("notebook", ["pbr_chapter_6", "photographer", "designer"])
def test_a_notebook_runs(notebook, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(lenses, "check", lambda lens: [note(Kind.FOCAL_LENGTH, "what a check finds")])
    runpy.run_path(str(DOCS / "notebooks" / f"{notebook}.py"))
    pictures = list(tmp_path.glob("*.png"))
    assert pictures and all(picture.stat().st_size > 10_000 for picture in pictures)
