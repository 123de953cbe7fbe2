"""A process that draws sections of lenses for the lens browser; its arguments are the look of these pictures."""

import sys

from lensbench import lenses
from lensbench.app.panels.lens_browser.section import SectionLook, section_picture
from lensbench.app.workers.lens_pictures import answer
from lensbench.app.workers.task import lower_priority


def main() -> None:
    """Answer as `workers.lens_pictures` describes."""
    lower_priority()
    width, height, theme, pixel = sys.argv[1:]          # as `SectionLook.command` writes them
    look = SectionLook((int(width), int(height)), theme == "dark", float(pixel))
    answer(lambda name: section_picture(lenses.load(name), look))


if __name__ == "__main__":
    main()
