"""Names from outside made into identifiers: unique, and reserved in no language."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from functools import cache

from gd_analyze.exporting.registry import LANGUAGES, language_class

# MATLAB takes 63 signs, and what is appended to a name needs some.
LONGEST = 40

# Arguments and outputs, which stand beside the name of a function, and file names that Windows keeps.
_COMMON = {"q", "qd", "qdd", "tau", "d", "h", "c", "stated", "con", "prn", "aux", "nul"} | {
    f"{port}{k}" for port in ("com", "lpt") for k in range(10)
}


@cache
def reserved() -> frozenset[str]:
    """Words that no language may find as a name, in lower case: one model has one name in all of them."""
    words = frozenset().union(*(language_class(name).reserved for name in LANGUAGES))
    return frozenset(word.lower() for word in words) | _COMMON


def identifier(name: str, otherwise: str = "arm") -> str:
    """Make a name a word of ASCII letters, digits and underscores that is reserved in no language.

    Parameters
    ----------
    name
        Any text.
    otherwise
        What it becomes where nothing is left of it, and the prefix of digits and reserved words.

    Examples
    --------
    >>> identifier("Überarm 3000*/"), identifier("double"), identifier("7-bot"), identifier("腕")
    ('Uberarm_3000', 'arm_double', 'arm_7_bot', 'arm')
    """
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode("ascii")
    word = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_")
    if not word:
        return otherwise
    if not word[0].isalpha() or word.lower() in reserved():
        word = f"{otherwise}_{word}"
    return word[:LONGEST].rstrip("_")


def identifiers(names: Sequence[str], otherwise: str = "joint") -> tuple[str, ...]:
    """Make identifiers of names, no two alike, not even where capitals do not count.

    Examples
    --------
    >>> identifiers(["a b", "A-b", "a_b_2", ""])
    ('a_b', 'A_b_2', 'a_b_2_2', 'joint')
    """
    taken: set[str] = set()
    made = []
    for name in names:
        base = word = identifier(name, otherwise)
        number = 1
        while word.lower() in taken:
            number += 1
            word = f"{base}_{number}"
        taken.add(word.lower())
        made.append(word)
    return tuple(made)
