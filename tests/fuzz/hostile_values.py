"""Values that no file should hold, and values that look as if it might."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from random import Random
from typing import Any


@dataclass(frozen=True)
class Raw:
    """Text that stands in a file as it is: numbers and nests that no parser should have to make first."""

    text: str


EXTREME = [
    0.0, -0.0, 5e-324, 1e-308, 1e-160, 1e-30, 1e30, 1e77, 1e150, 1e155, 1e200, 1e300,
    1.7976931348623157e308,
]  # fmt: skip
# Degrees, millimetres, grams, milliseconds and cm/s^2 where radians, metres, kilograms and seconds belong.
SLIPS = [-90.0, 180.0, 431.8, 17400.0, 981.0, 1e3, 1e-3]
WHOLE = [0, 1, -1, 2, 3, 99, 2**31, 2**53 + 1, 2**63 - 1, 2**63, -(2**63) - 1, 2**64, 10**30, 10**400]
TEXTS = [
    "", " ", "x", "q1", "nan", "inf", "1_000", "0.3_1", "0x10", "１２", "٣", "1,5", "−1", "1e", "true",
    "null", "[bold]x[/bold]", "<img src=x onerror=alert(1)>", "[link](javascript:x)", "%s {0} {arm}",
    "=1+1", "../../etc/passwd", "a\nb", "a\rb", "a\tb", "\x1b[31mred\x1b[0m", "\x1b]0;title\x07", "\x00",
    "\x7f", "\x85", "\u2028", "\u200b", "\u202eabc", "\ufeff", "\ud800", "é", "🤖", "ﬁ", "x" * 300,
    "q" * 10_000, "9" * 400, "9" * 5_000, "q1" + "0" * 5_000, "\u0301" * 200,
]  # fmt: skip
RAW = [
    "NaN", "Infinity", "-Infinity", "nan", "inf", "-inf", "1e999", "-1e999", "1e-999", "9" * 400,
    "9" * 5_000, "0." + "0" * 5_000 + "1", "01", "1.", ".5", "+1", "0x7fffffffffffffff",
    "1979-05-27T07:32:00Z", "12:00:00", "[" * 40 + "]" * 40, "[" * 3_000 + "]" * 3_000, "[" * 100_000,
    '{"a":' * 2_000 + "1" + "}" * 2_000, "{a=" * 400 + "1" + "}" * 400, "'''\n'''", "",
]  # fmt: skip


ODD = [None, True, False, [], {}, [[]], [1], [0.0, 0.0, 0.0], {"a": 1}, ["a", 1, None]]
NOT_FINITE = [math.nan, math.inf, -math.inf]


def number(random: Random) -> Any:
    """A finite number: ordinary, extreme, slipped by a unit, whole, or any."""
    kind = random.randrange(5)
    if kind == 0:
        return random.uniform(-10.0, 10.0)
    if kind == 1:
        return random.choice((1, -1)) * random.choice(EXTREME)
    if kind < 4:
        return random.choice(SLIPS if kind == 2 else WHOLE)
    (any_float,) = struct.unpack("d", random.randbytes(8))
    return any_float if math.isfinite(any_float) else 0.5


def text(random: Random) -> str:
    """A text that steers terminals, breaks parsers or is too long, or any."""
    if random.randrange(3):
        return random.choice(TEXTS)
    last = random.choice((0x7F, 0x2FFF, 0xFFFF, 0x10FFFF))
    return "".join(chr(random.randrange(last)) for _ in range(random.randrange(1, 8)))


def leaf(random: Random) -> Any:
    """Anything that may stand for a value."""
    kind = random.randrange(9)
    if kind < 4:
        return number(random)
    if kind < 6:
        return text(random)
    if kind < 8:
        return random.choice(ODD if kind == 6 else NOT_FINITE)
    return Raw(random.choice(RAW))
