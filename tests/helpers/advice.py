"""What error messages advise, held against the command line: its verbs, its options, and their values."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator

import click

from gd_analyze.cli.app import app

# An option, and the word behind it unless that begins a new clause.
_OPTION = re.compile(
    r"(?<![\w-])(--[a-z][a-z-]*)(?:[ =]('[^']*'|\"[^\"]*\"|[^\s;,.'\"`)-](?:[^\s;,`)]|,(?=\S))*))?"
)
_COMMAND = re.compile(r"`gd-analyze ([^`]*)`")
# Words of a sentence behind an option whose value is left to the user.
_SENTENCE = re.compile(r"[a-z]+")


def false_advice(advice: str, verb: click.Command | None) -> Iterator[str]:
    """Options that no verb takes, or not the `verb` that was called, and values that they refuse."""
    rest = advice
    for command in _COMMAND.findall(advice):
        rest = rest.replace(command, "")
        words = command.split()
        name = words[0] if words and words[0] in app.commands else "analyze"
        yield from _false_options(command, [app.commands[name]])
    yield from _false_options(rest, list(app.commands.values()) if verb is None else [verb])


def _false_options(text: str, verbs: list[click.Command]) -> Iterator[str]:
    for option, word in advised_options(text):
        if option == "--help":
            continue
        every = [(verb, param) for verb in verbs for param in verb.params]
        takers = [(verb, param) for verb, param in every if option in (*param.opts, *param.secondary_opts)]
        if not takers:
            yield f"{option} of {', '.join(str(verb.name) for verb in verbs[:2])}"
        elif word and not any(_takes(verb, param, word) for verb, param in takers):
            yield f"{option} {word}"


def advised_options(text: str) -> list[tuple[str, str]]:
    """Options that a text names, each with the word behind it, or ""."""
    return _OPTION.findall(text)


def _takes(verb: click.Command, param: click.Parameter, word: str) -> bool:
    """Whether an option takes a word; a placeholder, and the next word of a sentence, are no value."""
    value = shlex.split(word)[0].rstrip(".:")
    if getattr(param, "is_flag", False) or value.isupper() or _SENTENCE.fullmatch(value):
        choices = param.type.choices if isinstance(param.type, click.Choice) else ()
        return not choices or value in choices or value in ("or", "and", "to", "takes", "needs", "shows")
    context = click.Context(verb, resilient_parsing=True)
    try:
        param.type.convert(value, param, context)
    except Exception:
        return False
    return True
