"""The words of words.toml, and names split into them."""

from __future__ import annotations

import re
import tomllib
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

Words = tuple[str, ...]

# TCP | Position, deg, wrist | 12 | words of other scripts
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+|[^\W\d_A-Za-z]+")

VOCABULARY: Mapping[str, Mapping[str, frozenset[str]]] = {
    table: {name: frozenset(phrases) for name, phrases in lists.items()}
    for table, lists in tomllib.loads(
        (Path(__file__).parent / "words.toml").read_text(encoding="utf-8")
    ).items()
}
MOTION_QUANTITIES = ("q", "qd", "qdd", "torque", "current")


@dataclass(frozen=True)
class Meaning:
    """What a phrase means."""

    of: str  # a table of words.toml: "q", "kind", "joint"
    kind: str = ""  # "measured" or "target"
    unit: str = ""
    second: bool = False  # whether another word of the same table is preferred


def _meanings() -> dict[Words, Meaning]:
    meanings = {}
    for table, lists in VOCABULARY.items():
        for name, phrases in lists.items():
            if table in ("time", "unit") or name in ("letters", "external", "first_target", "anywhere"):
                continue  # these mean something in their place only
            kind, _, unit = name.partition("_")
            kind = kind if kind in ("measured", "target") else ""
            for phrase in phrases:
                meanings[tuple(phrase.split())] = Meaning(table, kind, unit, name == "second")
    return meanings


MEANINGS = _meanings()
LONGEST_PHRASE = max(map(len, MEANINGS))


@dataclass(frozen=True)
class NameWord:
    """A word of a name, in lower case without accents, and where it stands."""

    text: str
    start: int
    end: int

    @property
    def is_count(self) -> bool:
        """Whether it may be the number of a joint."""
        return self.text.isascii() and self.text.isdigit() and len(self.text) < 7


def placed_words(text: str, offset: int = 0) -> list[NameWord]:
    """Words of a text that begins at `offset` of a name."""
    plain = "".join(unicodedata.normalize("NFKD", sign)[0] if sign.isalpha() else sign for sign in text)
    return [
        NameWord(match[0].lower(), match.start() + offset, match.end() + offset)
        for match in _WORD.finditer(plain)
    ]


def words_in(text: str) -> Words:
    """Split a text into words, in lower case without accents."""
    return tuple(word.text for word in placed_words(text))


def split_in_two(word: str) -> tuple[Meaning, Meaning] | None:
    """Meanings of a quantity and a kind written as one word: qdes, posact, istwinkel; None for others."""
    for k in range(1, len(word)):
        pair = MEANINGS.get((word[:k],)), MEANINGS.get((word[k:],))
        first, second = pair
        if first is not None and second is not None and {"kind"} < {first.of, second.of} <= _OF_TWO:
            return first, second
    return None


_OF_TWO = {"kind", *MOTION_QUANTITIES[:4]}
