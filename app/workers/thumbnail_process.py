"""A second process that renders small pictures through lenses, so that the window never waits for their set-up.

Each line of the input is a name of the library, a tab, and the PNG file to be written; each line of the output is
“ok”, or why there is no picture. The process ends with its input.
"""

import sys
from dataclasses import replace

from lensbench.app.state.settings import Settings

LONGER_SIDE = 192               # pixels
SAMPLES = 24


def thumbnail_settings(name: str) -> Settings:
    """A lens at its best before the still life, in the d line."""
    from lensbench.app.state.constraints import with_longer_side
    from lensbench.app.state.lens_choice import with_lens

    settings = replace(Settings(), lens_model="trace", dispersion="off", samples=SAMPLES)
    return with_longer_side(with_lens(settings, name), LONGER_SIDE)


def main() -> None:
    """Answer the lines of the input one after the other."""
    from lensbench.app.files.export import render, save_picture
    from lensbench.app.workers.threads import lower_priority, thread_count

    lower_priority()                            # the rendering threads inherit it
    for line in sys.stdin:
        name, _, path = line.rstrip("\n").partition("\t")
        try:
            settings = thumbnail_settings(name)
            image = render(settings, threads=thread_count())
            assert image is not None            # nothing cancels it
            save_picture(path, image, settings)
            answer = "ok"
        except Exception as error:              # the window shows it in the lens's place
            answer = f"{type(error).__name__}: {error}"
        print(" ".join(answer.split()), flush=True)


if __name__ == "__main__":
    main()
