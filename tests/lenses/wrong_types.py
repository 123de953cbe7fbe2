"""Values of another type in lens files: JSON and TOML by a grammar of values, text formats by words."""

import json
import random
import re

from lensbench import lenses
from lensbench.lenses import WRITERS
from tests.lenses.samples import DATA

VALUES = (None, True, False, 0, -1, 1.5, 1e308, -1e308, 5e-324, float("nan"), float("inf"), 10**400, -10**400, "",
          "text", "NaN", "1e999", [], [1.0], [[]], [None], ["x"] * 3, {}, {"a": 1}, {"type": []}, [[1.0, 2.0], [3.0]])
WORDS = ("nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "9" * 400, "text", "[]", "{}", "0", "-1", "1e400", "''",
         '""', "1,5", "S99", "None", "1e9", "-1e9")

TOKEN = re.compile(r'(?<=[=\[,\s])("[^"\n]*"|-?[\d.]+(e-?\d+)?|inf)(?=[\s,\]}]|$)')     # a value of TOML


def wrong(data, rng):
    """The data with one of its values, at any depth, replaced by one of another type, removed, or listed twice."""
    nodes = list(_places(data))
    holder, key = rng.choice(nodes)
    kind = rng.random()
    if kind < 0.1 and isinstance(holder, dict):
        del holder[key]
    elif kind < 0.2 and isinstance(holder, list):
        holder.append(holder[key])
    else:
        holder[key] = rng.choice(VALUES)
    return data


def _places(data):
    for key in (data if isinstance(data, dict) else range(len(data))):
        yield data, key
        if isinstance(data[key], dict | list):
            yield from _places(data[key])


def texts(name, rng, times):
    """Files with one wrong value each: the suffix, and their text."""
    path = DATA / name if isinstance(name, str) else name
    text, suffix = path.read_text(encoding="utf-8"), path.suffix
    for _ in range(times):
        if suffix in (".json", ".roa", ".lhlt"):
            yield json.dumps(wrong(json.loads(text), rng), indent=1)
        elif suffix == ".toml" and rng.random() < 0.7:
            token = rng.choice(list(TOKEN.finditer(text)))
            yield text[:token.start()] + toml_text(rng.choice(VALUES)) + text[token.end():]
        else:
            lines = text.split("\n")
            i = rng.choice([i for i, line in enumerate(lines) if line.split()])
            separator = "\t" if "\t" in lines[i] else None
            words = lines[i].split(separator)
            words[rng.randrange(len(words))] = rng.choice(WORDS)
            margin = lines[i][:len(lines[i]) - len(lines[i].lstrip())] if separator is None else ""
            lines[i] = margin + (separator or " ").join(words)
            yield "\n".join(lines)


def toml_text(value):
    """A value in TOML."""
    if value is None or isinstance(value, dict):
        return "{ a = 1 }" if value else "{}"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return f"[{', '.join(map(toml_text, value))}]"
    return json.dumps(value) if isinstance(value, str) else str(value)


def outlived(path, text):
    """Whether a file with this text is read; any error but that of a lens file fails, and so does one of two lines."""
    path.write_text(text, encoding="utf-8")
    try:
        lens = lenses.load(path)
    except lenses.LensFileError as error:
        assert "\n" not in str(error)
        return False
    for suffix in WRITERS:                      # what was read can be written
        WRITERS[suffix](lens)
    return True


def sources():
    """Samples of every format, by a name for the test."""
    return sorted(path.name for path in DATA.iterdir())


def rng_of(name):
    """Reproducible random numbers of a sample."""
    return random.Random(f"types of {name}")

