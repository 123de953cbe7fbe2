"""Random damage to files: bytes and lines lost, changed, doubled, swapped; and what readers must return."""

import faulthandler
import random
import unicodedata

HANGS = 60.0            # seconds allowed to a reader that needs milliseconds
JUNK = [b"nan", b"-inf", b"1e999", b"1e-400", b"-1", b"0", b'"', b"'''", b"[", b"]" * 3, b"{", b"#", b"\xff", b"\0",
        b"=", b"[" * 3000, b"9" * 5000, b"stop", b'"stop"', b"\r", b"\n", b"axpos", b"(m)", b"true", b"1979-05-27",
        b"1_0", b"0x1f", "−٣".encode()]
WORDS = [b"INFINITY", b"1e400", b"-1e300", b"1e-310", b"1,5", b"1D5", b"S3", b"99999999999", b"REFL", b"MIRROR",
         b"'", b'"', b"&", b";", b"ZOO", b"PRV", b"END", b"NXT", b"SURF 1", b"PARM 1 5", b"GLAS X 2 5 0 0", b"GLA",
         b"ASP ARA 3", b"XDAT 1 400", b"AsphericalOddCount\t-3", b"MNUM 1e9", b"null", b"true", b"[]", b"{}", b"NaN",
         b"-Infinity"]


def by_bytes(content, rng):
    """The bytes after one to four random changes that ignore lines.

    Changes: cut, inserted, changed, removed, one bit flipped.
    """
    for _ in range(rng.randint(1, 4)):
        i = rng.randrange(len(content) + 1)
        kind = rng.randrange(6)
        if kind == 0 and rng.random() < 0.3:
            content = content[:i]
        elif kind == 1:
            content = content[:i] + rng.choice(JUNK) + content[i:]
        elif kind == 2:
            content = content[:i] + bytes([rng.randrange(256)]) + content[i + 1:]
        elif kind == 3:
            content = content[:i] + content[i + rng.randint(1, 20):]
        elif kind == 4:
            j = rng.randrange(len(content) + 1)
            content = content[:i] + content[j:j + rng.randint(1, 40)] + content[i:]
        elif i < len(content):
            content = content[:i] + bytes([content[i] ^ 1 << rng.randrange(8)]) + content[i + 1:]
    return content


def by_lines(content, rng):
    """The bytes after one to four random changes of whole lines or words: lost, doubled, swapped, moved, replaced."""
    lines = content.split(b"\n")
    for _ in range(rng.randint(1, 4)):
        i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
        kind = rng.randrange(6)
        if kind == 0 and len(lines) > 1:
            del lines[i]
        elif kind == 1:
            lines.insert(j, lines[i])
        elif kind == 2:
            lines[i], lines[j] = lines[j], lines[i]
        elif kind == 3:
            words = lines[i].split(b" ")
            words[rng.randrange(len(words))] = rng.choice(JUNK + WORDS)
            lines[i] = b" ".join(words)
        elif kind == 4:
            words, others = lines[i].split(b" "), lines[j].split(b" ")
            words[rng.randrange(len(words))] = rng.choice(others)
            lines[i] = b" ".join(words)
        else:
            lines[i:i + rng.randint(1, 5)] = []
            lines = lines or [b""]
    return b"\n".join(lines)


def outlive(path, whole, mutate, times, seed, read, errors, longest=500):
    """What `read(path)` returns after each of `times` random changes of a file's bytes.

    A traceback or a hang fails, and so does an error of `errors` whose message is longer than `longest`, or has more
    than one line of visible characters.
    """
    rng = random.Random(f"{path.name} {mutate.__name__} {seed}")
    found = []
    for _ in range(times):
        path.write_bytes(mutate(whole, rng))
        faulthandler.dump_traceback_later(HANGS, exit=True)
        try:
            found.append(read(path))
        except errors as error:
            text = str(error).replace(str(path), path.name)
            assert len(text) < longest
            assert not any(unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp") for c in text), text
        finally:
            faulthandler.cancel_dump_traceback_later()
    return found


def also_wide(mutate, whole):
    """The same change to text in UTF-8 and, at times, in UTF-16, as programs on Windows write it."""
    wide = whole[:2] in (b"\xff\xfe", b"\xfe\xff")

    def changed(content, rng):
        content = mutate(whole.decode("utf-16").encode() if wide and rng.random() < 0.5 else whole, rng)
        return content.decode("latin-1").encode("utf-16") if rng.random() < 0.1 else content

    changed.__name__ = mutate.__name__
    return changed
