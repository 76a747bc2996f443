"""Arguments of public calls: True or False, what shows progress, and one of some words."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import wraps
from inspect import signature
from types import NoneType
from typing import ParamSpec, TypeVar

import numpy as np

from gd_analyze.arrays import members
from gd_analyze.errors import UsageError, require_type
from gd_analyze.progress import Progress
from gd_analyze.text import in_python

Parameters = ParamSpec("Parameters")
Answer = TypeVar("Answer")
Member = TypeVar("Member")
# What an annotation allows, and says in words.
_CHECKED = {
    "bool": ((bool, np.bool_), "True or False"),
    "bool | None": ((bool, np.bool_, NoneType), "True, False or None"),
    "Progress": ((Progress,), "an object of a class derived from `gd_analyze.types.Progress`"),
}


def require_flags(values: Mapping[str, object], kinds: Mapping[str, str]) -> None:
    """Raise a UsageError for a value that is not what its annotation says: True or False, or a `Progress`.

    The text "no" is true.
    """
    for name, kind in kinds.items():
        if kind in _CHECKED and name in values:
            types, expected = _CHECKED[kind]
            require_type(values[name], types, name, expected)


def strict(function: Callable[Parameters, Answer]) -> Callable[Parameters, Answer]:
    """Check a public function's flags and its progress whenever it is called."""
    kinds = {name: str(parameter.annotation) for name, parameter in signature(function).parameters.items()}

    @wraps(function)
    def checked(*arguments: Parameters.args, **keywords: Parameters.kwargs) -> Answer:
        require_flags(dict(zip(kinds, arguments, strict=False)) | keywords, kinds)
        return function(*arguments, **keywords)

    return checked


def require_flags_of(settings: object) -> None:
    """The same check of a dataclass's fields."""
    kinds = {name: str(kind) for name, kind in type(settings).__annotations__.items()}
    require_flags(vars(settings), kinds)


def require_word(value: object, words: Iterable[str], where: str) -> None:
    """Raise a UsageError unless an argument is one of these words."""
    words = list(words)
    if not isinstance(value, str) or value not in words:
        near = difflib.get_close_matches(str(value), words, n=1)
        step, expected = f"did you mean {near[0]!r}?" if near else None, ", ".join(words)
        message = f"there is no such {where.removesuffix('s')}"
        raise UsageError(message, where=where, expected=expected, found=in_python(value), next_step=step)


def several(words: str | Iterable[Member]) -> tuple[str | Member, ...]:
    """Take one word for a collection of it."""
    return (words,) if isinstance(words, str) else tuple(members(words))


def words_of(values: str | Iterable[str], words: Collection[str], where: str) -> tuple[str, ...]:
    """Some of these words, given as one or as a collection; a UsageError for anything else."""
    require_type(values, (str, list, tuple, set, frozenset), where, f"some of {', '.join(words)}")
    chosen = several(values)
    for value in chosen:
        require_word(value, words, where)
    return chosen
