"""Lenses that tests of the optics run on: forty of the library, from Petzval to phone.

`tests/lenses/test_library.py` opens, checks and renders every lens of the library; tests that take long for each lens
run on these, or count as slow for the others.
"""

import pytest

from lensbench import lenses

CLASSICS = tuple(name for name in lenses.names()
                 if name.startswith(("lenshh-", "lentil-", "lib-", "lv-", "optiland-", "pbrt-")))
assert len(CLASSICS) == 40

# For a law of every lens that takes a tenth of a second each
EVERY = [name if name in CLASSICS else pytest.param(name, marks=pytest.mark.slow) for name in lenses.names()]
