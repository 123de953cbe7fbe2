"""400 cameras at random: images of lights through the chosen model are those through the lens, and no simpler one does.

Prints the confusion table of docs/benchmark.md: the chosen model against the simplest that passes by the images. The
short form, of ten cameras, is in tests/core/analysis/test_model_choice.py.
"""

from collections import Counter
from dataclasses import replace

import lensbench as lb
from lensbench.core.analysis.model_choice import LADDER
from tests.core.point_lights import setting, verdict

SETTINGS = 400
NAMES = {("polynomial", degree): f"poly {degree}" for _, degree in LADDER} | {
    (model, 0): model for model, degree in LADDER if not degree}


def test_the_choice_is_right_for_four_hundred_cameras_and_seldom_too_careful():
    table: Counter = Counter()
    wrong = []
    scene = lb.builtin_scene("room")
    for seed in range(SETTINGS):
        name, camera, depths = setting(seed)
        choice = lb.choose_model(camera, replace(scene, depth_range=depths))
        chosen = choice.model, choice.degree
        judged = verdict(camera, depths, LADDER, chosen)
        table[chosen, next(filter(judged.passes, LADDER))] += 1
        if not judged.passes(chosen):
            wrong.append(f"{seed} {name}: {choice.name} is off by {judged.off[chosen]}")
    print("\n| chosen \\ simplest that passes | " + " | ".join(NAMES[rung] for rung in LADDER) + " |")
    print("|---" * (len(LADDER) + 1) + "|")
    for chosen in LADDER:
        print(f"| {NAMES[chosen]} | " + " | ".join(str(table[chosen, rung] or "") for rung in LADDER) + " |")
    simplest = sum(count for (chosen, rung), count in table.items() if chosen == rung)
    print(f"{SETTINGS - len(wrong)} of {SETTINGS} within the tolerances; {simplest} the simplest that is")
    assert not wrong, "\n".join(wrong)
    assert simplest >= 0.9 * SETTINGS
