"""Small lens files of other programs, made for the tests, and random lenses for round trips."""

import json
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

from hypothesis import strategies as st

from lensbench import AIR, Glass, Lens, Surface, lenses

DATA = Path(__file__).parent / "data"


def loaded(folder, name, content):
    """The lens of a file with this content (text or bytes)."""
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return lenses.load(path)


def changed_sample(sample, folder, *changes):
    """The lens of a sample file after replacements of text, each a pair of old and new."""
    text = (DATA / sample).read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return loaded(folder, f"lens{Path(sample).suffix}", text)


def bare(lens, like):
    """The lens with the system data of another: a writer states an aperture, a field and lines for a lens without."""
    return replace(lens, system=like.system)


def changed_json(model, keys, value):
    """The text of a JSON file with one value set."""
    node = model = deepcopy(model)
    for key in keys[:-1]:
        node = node[key]
    node[keys[-1]] = value
    return json.dumps(model, indent=1)


def refusal(folder, name, content):
    """The error of a refused file, which is one line."""
    try:
        lens = loaded(folder, name, content)
    except lenses.LensFileError as error:
        assert "\n" not in str(error)
        return error
    raise AssertionError(f"this was read: {lens}")


names = st.text("ABCDEFGHKLMNPSTZ-0123456789", min_size=2, max_size=8).filter(lambda text: text[0].isalpha())
model_glasses = st.builds(Glass, st.floats(1.3, 2.2), st.none() | st.floats(15.0, 100.0), st.just("") | names)
curvatures = st.just(0.0) | st.floats(1e-9, 0.5) | st.floats(-0.5, -1e-9)
positive = st.floats(1e-3, 1e3)
lengths = st.floats(-100.0, 1e4)
coefficients = st.floats(1e-25, 1e-3) | st.floats(-1e-3, -1e-25)
plain_words = st.text("abcdefghijkqrstuvwxyzABC 012389.()/", max_size=20).map(lambda text: " ".join(text.split()))


def terms(powers):
    return st.dictionaries(st.sampled_from(powers), coefficients, max_size=5).map(lambda table: tuple(table.items()))


def prescriptions(powers, cylinders=True, toroids=True, glasses=model_glasses, **words):
    """Lenses whose aspheric terms have these powers; words: strategies for fields of the lens."""
    media = st.just(AIR) | glasses
    bodies = st.builds(Surface, lengths, positive, media, st.just(0.0) | st.floats(-20.0, 20.0), terms(powers),
                       curvature=curvatures)
    rods = st.builds(Surface, lengths, positive, media, curvature=curvatures,
                     curvature_x=curvatures if toroids else st.just(0.0))
    if not toroids:
        rods |= st.builds(Surface, lengths, positive, media, curvature=st.just(0.0), curvature_x=curvatures)

    @st.composite
    def lens(draw):
        table = draw(st.lists(bodies | rods if cylinders else bodies, min_size=1, max_size=6))
        table[-1] = Surface(table[-1].thickness, table[-1].semi_diameter, curvature=table[-1].curvature)
        return Lens(tuple(table), draw(st.integers(0, len(table) - 1)), **{key: draw(s) for key, s in words.items()})
    return lens()
