"""Half a minute of impossible lenses under the mouse (`make impossible` takes twenty): no panel fails for one."""

import random
import re
import subprocess
import sys

import pytest

from lensbench import lenses
from lensbench.app.session.edited_lens import document_of
from lensbench.app.settings.settings import Settings
from trials.impossible_lenses import Spoiler
from trials.soak import SIZE


def test_most_random_edits_change_the_lens_and_what_they_make_is_read_again():
    hand, changed = Spoiler(1, SIZE, toured=True), 0
    hand.random = random.Random(4)
    for name in lenses.names()[::20]:
        settings = Settings(lens=name)
        for _ in range(4):
            before, settings = settings, hand.damaged(settings)
            if settings.has_lens and settings.edited and settings.edited != before.edited:
                changed += 1
                document_of(settings)
    assert changed > 25


@pytest.mark.slow
@pytest.mark.long
def test_impossible_lenses_end_without_a_failure():
    done = subprocess.run([sys.executable, "-m", "trials.impossible_lenses", "--minutes", "0.5", "--seed", "2"],
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(re.findall(r"(\d+) edits, 0 failures", done.stdout)[0]) > 1
