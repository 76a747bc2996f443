"""Numbers, units and names as a reader meets them; terminal, HTML and PDF show the same digits."""

from __future__ import annotations

import json
import math
import re
import unicodedata
from decimal import ROUND_CEILING, Decimal
from functools import lru_cache
from itertools import takewhile
from typing import TYPE_CHECKING, Any

from markupsafe import escape

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Mapping, Sequence

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

# The largest share that is written as percent: ten thousand.
_MOST_PERCENT = 100


def number(value: float, digits: int = 3) -> str:
    """Format to three significant digits, or another number of them: 41, 12300, 2.10e-14."""
    if value == 0.0:
        return "0"
    if abs(value) < 1e-3 or abs(value) >= 1e5:
        return f"{value:.{digits - 1}e}"
    return f"{float(f'{value:.{digits}g}'):g}"


def significant(value: float) -> str:
    """Format to three significant digits, trailing zeros included, with the power of ten set out."""
    if not math.isfinite(value):
        return "∞"
    if value == 0.0:
        return "0"
    if abs(value) < 1e-3 or abs(value) >= 1e5:
        return pretty(f"{value:.2e}")
    rounded = float(f"{value:.3g}")
    return f"{rounded:.0f}" if abs(rounded) >= 1e3 else f"{rounded:#.3g}".removesuffix(".")


def given(value: float | None) -> str:
    """Format data as given: up to six digits, no trailing zeros; a dash where unknown."""
    if value is None:
        return "–"
    return pretty(f"{value + 0.0:.6g}").replace("-", "−") if math.isfinite(value) else "∞"


# Prefixes of powers of 1000; kilograms use those of grams.
_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M"}


def prefixed(largest: float, unit: str) -> tuple[float, str]:
    """Prefix a unit so that values of this size have up to three digits before the point.

    Returns one new unit in old units, and the new unit; a unit that takes no prefix is unchanged.
    """
    size, weighed = abs(largest), unit.startswith("kg")
    takes_one = (weighed or unit.startswith("N")) and " or " not in unit
    if not takes_one or 0.1 <= size < 1e4 or not 0 < size < math.inf:
        return 1.0, unit
    power = 3 * math.floor(math.log10(size * (1 + 1e-9)) / 3)
    grams = power + 3 * weighed
    if (power >= 0 and weighed) or grams not in _PREFIXES:
        return 1.0, unit
    return 10.0**power, _PREFIXES[grams] + (unit[1:] if weighed else unit)


def amount(value: float, unit: str) -> str:
    """Format to three significant digits with the unit, prefixed where that saves a power of ten."""
    factor, prefixed_unit = prefixed(value, unit)
    return f"{number(value / factor)} {prefixed_unit}"


def with_error(value: float, error: float) -> str:
    """Format a value to the digits of its standard error, and the error, to two digits."""
    if not math.isfinite(value):
        return "–"
    if not 0.0 < error < math.inf:
        return number(value)
    if not 1e-3 <= max(abs(value), error) < 1e5:
        return f"{number(value)} ± {error:.1e}"
    return " ± ".join(to_digits_of(x, error) for x in (value, error))


def to_digits_of(value: float, error: float) -> str:
    """Format a value to two digits of its standard error."""
    if not 0.0 < error < math.inf:
        return number(value)
    place = 1 - math.floor(math.log10(float(f"{error:.1e}")))
    return f"{round(value, place) + 0.0:.{max(place, 0)}f}"


def percent(share: float) -> str:
    """Format a share as percent with two significant digits; a huge one has no digits of interest."""
    if not math.isfinite(share):
        return "∞"
    if abs(share) > _MOST_PERCENT:
        return f"more than {_MOST_PERCENT} times" if share > 0 else f"less than -{_MOST_PERCENT} times"
    value = 100 * share
    if value == 0.0:
        return "0 %"
    return "< 0.01 %" if abs(value) < 0.01 else f"{value:.2g} %" if abs(value) < 9.95 else f"{value:.0f} %"


def rounded_up(value: float, digits: int = 3) -> float:
    """Round to significant digits, never down: a bound is never shown smaller than it is."""
    if value == 0.0 or not math.isfinite(value):
        return value
    exact = Decimal(value)
    step = Decimal(1).scaleb(exact.adjusted() - digits + 1)
    return float(exact.quantize(step, rounding=ROUND_CEILING))


def share_up(share: float) -> float:
    """Round a share up to the digits that `percent` shows."""
    return rounded_up(share, 2 if share < 1.0 or not math.isfinite(share) else 3 + int(math.log10(share)))


def enumerated(words: Sequence[str]) -> str:
    """Join words: "a", "a and b", "a, b and c"."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def named_joints(numbers: Sequence[int], of: int) -> str:
    """Name some of an arm's joints: "joint 3", "joints 1, 4 and 5", "joints 4 to 6", "every joint"."""
    if len(numbers) == of > 1:
        return "every joint"
    if len(numbers) > 2 and [*numbers] == [*range(numbers[0], numbers[-1] + 1)]:
        return f"joints {numbers[0]} to {numbers[-1]}"
    return f"joint{'s' if len(numbers) > 1 else ''} {enumerated([*map(str, numbers)])}"


def thousands(count: int) -> str:
    """Write a count: "200 000"."""
    return f"{count:,}".replace(",", " ")


@lru_cache(maxsize=4096, typed=True)  # a report asks ten thousand times for a few hundred
def counted(count: int, noun: str) -> str:
    """Write a number of things: "1 set point", "31 set points"."""
    return f"{count} {noun}{'s' * (count != 1)}"


def pretty(text: str) -> str:
    """Raise the exponents of a unit or of numbers: kg m^2 to kg m², 2.1e-14 to 2.1 × 10⁻¹⁴."""
    text = re.sub(r"(?<=[A-Za-z])\^(-?\d+)", lambda m: m[1].translate(_SUPERSCRIPTS), text)
    # Whole words only: an "e" between the digits of a hash is no exponent.
    return re.sub(
        r"\b(\d[\d.]*)e([+-]\d+)\b", lambda m: f"{m[1]} × 10{str(int(m[2])).translate(_SUPERSCRIPTS)}", text
    )


def unbroken(text: str) -> str:
    """Keep a number, its groups of digits and its percent sign on one line, by no-break spaces."""
    return re.sub(r"(?<=\d) (?=%|\d{3}\b)", "\N{NO-BREAK SPACE}", text)


def signed(text: str) -> str:
    """Write a number's leading hyphen as a minus sign."""
    return f"−{text[1:]}" if re.match(r"-\d", text) else text


def visible(text: str) -> str:
    """Escape control, format and line characters, which act on a terminal or a page instead of showing."""
    if text.isprintable():
        return text

    def escaped(sign: str) -> str:
        is_harmless = sign.isprintable() or unicodedata.category(sign) == "Zs"  # spaces of every width
        return sign if is_harmless else sign.encode("unicode_escape").decode("ascii")

    return "".join(map(escaped, text))


def in_python(value: object) -> str:
    """Write a value as Python does, or only its type where Python refuses to, as for 10**5000."""
    try:
        return repr(value)
    except (ValueError, RecursionError):
        return f"{type(value).__name__}, too large to be shown"


def json_fault(error: Exception) -> str:
    """Say what stands where JSON cannot be read, of what `json.loads` raises."""
    if isinstance(error, RecursionError):
        return "brackets nested too deep"
    if not isinstance(error, json.JSONDecodeError):
        return "a number of thousands of digits"
    unread = error.doc[error.pos :].strip()
    if not unread or error.msg.startswith("Unterminated"):
        return "the end of the file within a value: it is cut off"
    return in_python(unread.splitlines()[0][:30])


def field_fault(fault: Mapping[str, Any]) -> tuple[str, str]:
    """Say what was expected in a field, and what was found, of what pydantic notes of it."""
    if fault["type"] == "missing":
        return f"a field {fault['loc'][-1]}", "none"
    if fault["type"] == "extra_forbidden":
        return "no field of this name", in_python(fault.get("input"))
    message = str(fault["msg"]).removeprefix("Value error, ").removeprefix("Input should be ")
    return message, in_python(fault.get("input"))


def shortened(text: str, most: int) -> str:
    """Cut the middle out of a text of more than `most` characters, and say how long it was."""
    if len(text) <= most:
        return text
    gap, end = f" ... ({len(text)} characters) ... ", 40  # a path's name, a message's line and column
    return f"{text[: most - end - len(gap)]}{gap}{text[-end:]}"


def joined(joints: Iterable[int]) -> str:
    """Write joints, which count from 0, the way labels have them, from 1: "12", but "1,10"."""
    numbers = [str(joint + 1) for joint in joints]
    return ("," if any(len(number) > 1 for number in numbers) else "").join(numbers)


def parted(index: str, n_joints: int, lengths: Container[int]) -> tuple[int, ...] | None:
    """Read what `joined` wrote for a number of joints among `lengths`; commas may separate digits, too.

    None where this names no joints (from 0) of the arm, or could name several.
    """
    matches = set()
    for reading in {tuple(index.split(",")), (index,) if "," in index else tuple(index)}:
        if len(reading) in lengths and all(number.isdecimal() for number in reading):
            joints = tuple(int(number) - 1 for number in reading)
            if all(0 <= joint < n_joints for joint in joints):
                matches.add(joints)
    return matches.pop() if len(matches) == 1 else None


def inertia_label(i: int, j: int) -> str:
    """Label of an element of the symmetric matrix D; joints count from 0."""
    return f"D{joined(sorted((i, j)))}"


def short_name(name: str, most: int) -> str:
    """Leave out the middle of a name longer than `most` characters; names differ at their ends."""
    if len(name) <= most:
        return name
    ends = max(most - 1, 2)
    return f"{name[: ends - ends // 2]}…{name[len(name) - ends // 2 :]}"


def short_names(names: Sequence[str]) -> list[str]:
    """Leave out the words at the beginning that all names share: panda_joint1, ... become joint1, ..."""
    signs = takewhile(lambda column: len(set(column)) == 1, zip(*names, strict=False))
    shared = "".join(column[0] for column in signs) if len(set(names)) > 1 else ""
    # What remains begins with a letter: joint_3 as the second joint would read "2 3".
    ends = [mark.end() for mark in re.finditer(r"[^A-Za-z0-9]+", shared)]
    end = next((end for end in reversed(ends) if all(name[end : end + 1].isalpha() for name in names)), 0)
    return [name[end:] for name in names]


def joint_name(number: int, name: str) -> str:
    """A joint's number and name; only the number if the name is the same."""
    return name if name == str(number) else f"{number} {name}"


# SI: a billion tonnes, seven times as far as the sun, 32 000 years. A larger number has the wrong unit or
# comes from a damaged file. It also keeps results finite: torque is of the first power in mass and of the
# second in lengths and in velocities, so that its square stays below 1e130; doubles end at 1.8e308.
LARGEST = 1e12

# A term's coefficient is made of a mass and two lengths, 1e36 at most; a program may add them up and divide
# one by another. A larger one was never written by gd-analyze, and its products would overflow.
LARGEST_COEFFICIENT = 1e100

# Multiplications and additions that a sine or cosine counts as in a search. In exported C it takes as long as
# 18, of many states at once 30; but of 4, 8, 12 and 20 along four motions 8 found the cheapest models in C.
SINE_PRICE = 8

# float() also takes 1_000, digits of other scripts, "infinity" and "nan", which nobody means in a table.
UNSIGNED = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_NUMBER = re.compile(rf"[-+]?{UNSIGNED}")


def number_in(text: str) -> float | None:
    """Read a number in decimal digits of ASCII; None where there is none, infinity where it overflows."""
    stripped = text.strip()
    return float(stripped) if _NUMBER.fullmatch(stripped) else None


def html_of(
    title: str, headings: Sequence[str], rows: Iterable[Sequence[str]], note: str = "", more: str = ""
) -> str:
    """Write a value as HTML for notebooks: a table, a note below, lines folded away; names are escaped."""

    def text(value: str) -> str:
        return str(escape(visible(value)))

    def cell(value: str) -> str:
        style = ' style="text-align: left"' if value[:1].isalpha() else ""
        return f"<td{style}>{text(value)}</td>"

    caption = f"<caption>{text(title)}</caption>" if title else ""
    head = "".join(f"<th>{text(heading)}</th>" for heading in headings)
    head = f"<tr>{head}</tr>" if head else ""
    body = "".join(f"<tr>{''.join(map(cell, row))}</tr>" for row in rows)
    below = f"<p>{text(note)}</p>" if note else ""
    lines = "\n".join(text(line) for line in more.splitlines())
    folded = f"<details><summary>equations</summary><pre>{lines}</pre></details>" if more else ""
    return f"<table>{caption}{head}{body}</table>{below}{folded}"


# Levels of simplification, here so that the command line offers them without loading NumPy; the levels are
# those of `simplification/levels.py`, in this order.
LEVEL_NAMES = {
    "term": "torque terms one by one",
    "element": "parts of D and h as a whole, [FGL87]'s method",
    "energy": "the model remains a mechanical system, with symmetric D and its own energy",
}
