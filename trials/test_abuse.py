"""4,000 random commands of `render`, of odd and impossible values: a picture of finite numbers, or one clear line.

LENSBENCH_ABUSE_TIMES=N is another number of commands; a warning of numpy counts as a fault.
"""

import os
import shlex

import pytest

from tests.app.command.abuse import faults

TIMES, PARTS = int(os.environ.get("LENSBENCH_ABUSE_TIMES", "4000")), 20


@pytest.mark.parametrize("share", range(PARTS))
def test_random_commands_end_with_a_picture_or_one_clear_line(tmp_path, capsys, share):
    faulty = faults(TIMES // PARTS, f"trial {share}", tmp_path, capsys)
    assert not faulty, "\n".join(f"{wrong}: {shlex.join(words)}" for wrong, words in faulty)
