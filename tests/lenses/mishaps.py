"""Random damage to lens files: bytes and lines lost, changed, doubled, swapped; and what readers must return."""

import faulthandler
import math
import random
from dataclasses import fields

from lensbench import Lens, lenses
from lensbench.lenses import Kind

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


def outlive(path, whole, mutate, times, seed):
    """Lenses loaded from a file after each of `times` random changes; a traceback, a hang or a NaN fails."""
    rng = random.Random(f"{path.name} {mutate.__name__} {seed}")
    wide = whole[:2] in (b"\xff\xfe", b"\xfe\xff")
    found = []
    for turn in range(times):
        content = mutate(whole.decode("utf-16").encode() if wide and turn % 2 else whole, rng)
        if turn % 10 == 0:
            content = content.decode("latin-1").encode("utf-16")
        path.write_bytes(content)
        faulthandler.dump_traceback_later(HANGS, exit=True)
        try:
            lens = lenses.load(path)
        except lenses.LensFileError as error:
            assert "\n" not in str(error) and len(error.reason) < 400
            continue
        finally:
            faulthandler.cancel_dump_traceback_later()
        assert_sound(lens)
        found.append(lens)
    return found


def assert_sound(lens):
    """Assert that every number of a lens is finite."""
    assert isinstance(lens, Lens)
    for surface in lens.surfaces:
        for field in fields(surface):
            value = getattr(surface, field.name)
            assert not isinstance(value, float) or math.isfinite(value)
        assert all(math.isfinite(a) for _, a in surface.aspheric)
        assert math.isfinite(surface.glass.n_d) and math.isfinite(surface.glass.v_d or 0.0)
    assert all(value is None or math.isfinite(value) for value in (lens.stated_efl, lens.stated_f_number))
    assert not any("\n" in finding.message for finding in lens.findings)
    assert not any("nan" in finding.message.split() for finding in lens.findings if finding.kind is not Kind.NOT_READ)
