"""Changes to a text as text and as bytes: lines and letters, ends of lines, encodings, noise."""

from __future__ import annotations

from random import Random

from hostile_values import text
from plans import Stage

ENDS = ["\r\n", "\r", "\n\n", "\x0b", "\u2028", "\x85", "\n\r"]
ENCODINGS = ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "latin-1", "cp1252", "utf-7"]
TAILS = [b"\0", b"\0" * 5000, b"\x1a", b"\xff", b"\n" * 5000, b" "]


def _insert(random: Random, old: str) -> str:
    place = random.randint(0, len(old))
    return old[:place] + text(random) + old[place:]


def _replace_span(random: Random, old: str) -> str:
    place, length = random.randint(0, len(old)), random.choice([1, 1, 2, 5, 40])
    return old[:place] + random.choice(["", text(random)]) + old[place + length :]


def _lines(random: Random, old: str) -> str:
    """A line removed, said twice, moved or put in place of another."""
    lines = old.split("\n")
    one, two = random.randrange(len(lines)), random.randrange(len(lines))
    kind = random.randrange(4)
    if kind == 0:
        del lines[one]
    elif kind == 1:
        lines.insert(two, lines[one])
    elif kind == 2:
        lines[one], lines[two] = lines[two], lines[one]
    else:
        lines[one] = lines[two]
    return "\n".join(lines)


def _ends(random: Random, old: str) -> str:
    return old.replace("\n", random.choice(ENDS), random.choice([-1, 1, 5]))


def _encode(random: Random, old: bytes) -> bytes:
    return old.decode(errors="replace").encode(random.choice(ENCODINGS), errors="replace")


def _noise(random: Random, old: bytes) -> bytes:
    place, length = random.randint(0, len(old)), random.choice([0, 1, 8])
    return old[:place] + random.randbytes(random.randint(1, 8)) + old[place + length :]


def _cut(random: Random, old: bytes) -> bytes:
    return old[: random.randint(0, len(old))]


def _tail(random: Random, old: bytes) -> bytes:
    return old + random.choice(TAILS)


TEXT = Stage(
    {"insert": _insert, "replace text": _replace_span, "lines": _lines, "ends": _ends},
    lambda changed: changed.encode(errors="surrogatepass"),
)
BYTES = Stage({"encode": _encode, "noise": _noise, "cut": _cut, "tail": _tail}, bytes)
