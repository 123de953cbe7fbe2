"""A measured start of the window on no display: `python -m lensbench.app.command.start T` prints what it takes.

That is the seconds from T, of `time.time()`, to the first picture on the screen. Arguments are read and modules are
loaded as by `lensbench view`.
"""

import sys
import time

from lensbench.app.command.main import loading, parsed

if __name__ == "__main__":
    began = float(sys.argv[1])
    with loading():
        parsed(["view"])
        from lensbench.app.benchmark.live import SMALL, DrivenSession, run

    def first(session: DrivenSession) -> bool:
        """Print the time when the first picture is on the screen, and end."""
        if session.current:
            print(time.time() - began)
        return session.current

    run(SMALL, first, idle=True)
