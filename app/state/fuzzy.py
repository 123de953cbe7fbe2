"""Fuzzy search: the characters of a query in their order anywhere in a text, best where they begin words."""

import re
import unicodedata
from functools import lru_cache

WORD, RUN, FIRST = 8.0, 5.0, 6.0        # points: for the beginning of a word, a run of characters, the first of all
VERBATIM, INITIALS = 2.0, 1.5           # more for a part as it is written, and for the initials of successive words
GAP = 0.15                              # points lost for each character that is passed over
KEYS = str.maketrans("–—−×", "---x")    # characters that keyboards lack, and those that are typed for them


def score(query: str, text: str) -> float | None:
    """How well a text answers a query, the higher the better; None where a character of the query is missing.

    Spaces of the query separate parts that may come in any order. Case and accents do not count, and a hyphen finds
    every dash.
    """
    total = 0.0
    for part in _typed(query).split():
        found = _part(part, _typed(text))
        if found is None:
            return None
        total += found
    return total - 0.02 * len(text)


@lru_cache(maxsize=4096)
def _typed(text: str) -> str:
    """The text as it is typed on a plain keyboard."""
    bare = "".join(c for c in unicodedata.normalize("NFKD", text.lower()) if not unicodedata.combining(c))
    return bare.translate(KEYS)


def _part(part: str, text: str) -> float | None:
    """The best score of one part, over all places where its first character begins."""
    best = None
    at = text.find(part)                # as it is written: at the beginning of a word if there is such a place
    while at >= 0:
        points = RUN * len(part) + (WORD if _begins(text, at) else 0.0) + (FIRST if at == 0 else 0.0)
        best = points if best is None else max(best, points)
        at = text.find(part, at + 1)
    if best is not None:
        return best + VERBATIM
    if len(part) > 2 and part in "".join(word[0] for word in re.findall(r"\w+", text)):
        return RUN * len(part) + WORD + INITIALS
    points, at, run = 0.0, -1, False
    for character in part:
        ahead = text.find(character, at + 1)
        if ahead < 0:
            return None
        word = next((i for i in range(ahead, len(text)) if text[i] == character and _begins(text, i)), None)
        if not (run and ahead == at + 1) and word is not None:
            ahead = word
        run = 0 <= at == ahead - 1
        points += (RUN if run else 0.0) + (WORD if _begins(text, ahead) else 0.0) - GAP * (ahead - at - 1)
        at = ahead
    return points


def _begins(text: str, at: int) -> bool:
    return at == 0 or not text[at - 1].isalnum()


def ranked(query: str, texts: list[str], most: int) -> list[int]:
    """Indices of the best answers to a query, the best first; the first texts for an empty query."""
    if not query.strip():
        return list(range(min(most, len(texts))))
    scores = [(score(query, text), i) for i, text in enumerate(texts)]
    return [i for _, i in sorted(((-value, i) for value, i in scores if value is not None))[:most]]
