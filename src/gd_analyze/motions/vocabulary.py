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
    rank: int = 1  # of a quantity: 0 for a symbol, 1 for a word, 2 for a word of second choice


_RANKS = {"symbol": 0, "second": 2}


def _meanings() -> dict[Words, Meaning]:
    meanings = {}
    for table, lists in VOCABULARY.items():
        for name, phrases in lists.items():
            if table in ("time", "unit") or name in ("letters", "external", "first_target", "anywhere"):
                continue  # these mean something in their place only
            kind, _, unit = name.partition("_")
            kind = kind if kind in ("measured", "target") else ""
            for phrase in phrases:
                meanings[tuple(phrase.split())] = Meaning(table, kind, unit, _RANKS.get(name, 1))
    return meanings


MEANINGS = _meanings()
LONGEST_PHRASE = max(map(len, MEANINGS))


@dataclass(frozen=True)
class Phrase:
    """A word of a name, or several with one meaning, in lower case without accents, and where it stands."""

    text: str
    start: int
    end: int
    meaning: Meaning | None = None  # None for a number, and for a word that is not known

    @property
    def is_count(self) -> bool:
        """Whether it may be the number of a joint."""
        return self.text.isascii() and self.text.isdigit() and len(self.text) < 7

    @property
    def is_strange(self) -> bool:
        """Whether it is a word that is not known."""
        return self.meaning is None and not self.is_count

    def means(self, *tables: str) -> bool:
        """Whether its meaning is one of these tables of words.toml."""
        return self.meaning is not None and self.meaning.of in tables


def placed_words(text: str, offset: int = 0) -> list[Phrase]:
    """Words of a text that begins at `offset` of a name, without their meanings."""
    plain = "".join(unicodedata.normalize("NFKD", sign)[0] if sign.isalpha() else sign for sign in text)
    return [
        Phrase(match[0].lower(), match.start() + offset, match.end() + offset)
        for match in _WORD.finditer(plain)
    ]


def words_in(text: str) -> Words:
    """Split a text into words, in lower case without accents."""
    return tuple(word.text for word in placed_words(text))


def meanings_of(words: Words) -> tuple[Meaning, ...]:
    """Meaning of a phrase; of a word that joins quantity and kind, qdes, posact, istwinkel, both; or none."""
    if words in MEANINGS:
        return (MEANINGS[words],)
    for k in range(1, len(words[0])) if len(words) == 1 else ():
        first, second = MEANINGS.get((words[0][:k],)), MEANINGS.get((words[0][k:],))
        if first is not None and second is not None and {"kind"} < {first.of, second.of} <= _OF_TWO:
            return first, second
    return ()


_OF_TWO = {"kind", *MOTION_QUANTITIES[:4]}
