"""Options that a message advises, taken from its text and typed."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from typing import Any

import click

from advice import advised_options
from gd_analyze.cli.log_options import log_options, reading_asked
from gd_analyze.types import Reading

# Words that stand for something which only the user knows, and a value of each.
PLACEHOLDERS = {"RATEHz": "100Hz", "COLUMN": "#1", "NAME": "other", "JOINT": "1", "LIST": "1", "SECONDS": "9"}
_FLAGS = ("--measured", "--planned", "--drop-rows")


def remedies(message: str) -> Iterator[tuple[list[str], bool]]:
    """Alternatives that a message advises, as words of a command, and whether nothing is to be filled in.

    Options that follow each other belong together; "or" and a semicolon part alternatives.
    """
    for part in re.split(r" or |; ", message):
        options = [[option, *shlex.split(word)] for option, word in advised_options(part)]
        # An option without its value is only mentioned: "give a larger --largest-gap".
        mentioned = any(len(words) < 2 and words[0] not in _FLAGS for words in options)
        if options and not mentioned and not part.startswith("omit"):
            advised = [word for words in options for word in _words(words)]
            filled = [_filled(word) for word in advised]
            yield filled, filled == advised


def _words(option: list[str]) -> list[str]:
    name, *values = option
    return [name] if name in _FLAGS else [name, *(value.rstrip(",") for value in values)]


def _filled(word: str) -> str:
    names = "|".join(PLACEHOLDERS)
    return re.sub(rf"(?<![A-Za-z])({names})(?![A-Za-z])", lambda m: PLACEHOLDERS[m[1]], word)


def as_options(asked: dict[str, Any]) -> list[str]:
    """The options of keywords of `Reading.of`."""
    words: list[str] = []
    for name, value in asked.items():
        option = f"--{name.replace('_', '-')}"
        if isinstance(value, bool):
            words += [option if value else "--planned"] if value or name == "measured" else []
        else:
            values = value if isinstance(value, list) else [value]
            words += [word for one in values for word in (option, str(one))]
    return words


@click.command()
@log_options
def _command() -> Reading | None:
    return reading_asked()[0]


def typed(words: list[str]) -> Reading | None:
    """The reading that options of the command line ask for."""
    reading: Reading | None = _command.main(words, standalone_mode=False)
    return reading
