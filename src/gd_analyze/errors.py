"""One exception tree; every message says in at most three lines what, where, expected and what to do next."""

from __future__ import annotations

import ast
import contextlib
import re
import shlex
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from typing import Any

from gd_analyze.text import in_python, shortened, visible

# Files of the frames between a warning and the call that it is about: the library, and its context managers.
_OURS = (str(Path(__file__).parent), contextlib.__file__)
# A value from a file takes a line or two; a path of common length and a list of ours stay whole.
_LONGEST = {"what": 400, "where": 400, "expected": 1000, "found": 160, "next": 1000}

# An argument in a message, see `argument`, or name=True; and what a message is about, at its beginning.
_IN_TEXT = r"`(?P<name>\w+)(?:=(?P<value>'[^'`]*'|\"[^\"`]*\"|\[[^`]*\]))?`|\b(?P<flag>\w+=(?:True|False))\b"
_ABOUT = rf"^(?P<about>\w+)(?=$|[,;\[]| \d)|{_IN_TEXT}"
_ARGUMENTS = {"where": re.compile(_ABOUT), "expected": re.compile(_IN_TEXT), "next": re.compile(_IN_TEXT)}


@dataclass(frozen=True)
class Location:
    """A place in a file, as exactly as it is known; lines and columns count from 1."""

    path: str | Path
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        place = str(self.path)
        if self.line is not None:
            place += f", line {self.line}"
        if self.column is not None:
            place += f", column {self.column}"
        return place


class GdAnalyzeError(Exception):
    """Something the user can fix, told in one to three lines.

    Names and values of files and commands may be passed as given: control characters are escaped and long
    texts are cut here.

    Parameters
    ----------
    what
        One sentence: what is wrong.
    where
        File, line and column, or the argument or element concerned.
    expected, found
        What was wanted, and what was found instead; each of several things found is cut to a length.
    next_step
        What to do now.
    """

    def __init__(
        self,
        what: str,
        *,
        where: Location | str | None = None,
        expected: str | None = None,
        found: str | Sequence[str] | None = None,
        next_step: str | None = None,
    ) -> None:
        self.what = _line("what", what)
        self.details = {
            label: _line(label, value)
            for label, value in zip(_LONGEST, (None, where, expected, found, next_step), strict=True)
            if value is not None
        }
        super().__init__("\n".join(_lines(self.what, self.details)))

    def with_options(self, options: Mapping[str, str] | None = None) -> str:
        """The message, with options in place of arguments: those of a verb, by the arguments' names.

        "name=False" may be one of the names. Without a verb every argument is an option of its own name.
        """
        details = {
            label: _as_options(text, options, _ARGUMENTS[label]) if label in _ARGUMENTS else text
            for label, text in self.details.items()
        }
        return "\n".join(_lines(self.what, details))


def argument(name: str, value: str | Sequence[str] | None = None) -> str:
    """Name an argument of a call in a message, `name` or `name='value'`; a terminal shows it as an option."""
    return f"`{name}`" if value is None else f"`{name}={value!r}`"


def in_options(text: str) -> str:
    """A text with options in place of its arguments, for results and warnings, which speak of options."""
    return _as_options(text, None, _ARGUMENTS["next"])


def _as_options(text: str, options: Mapping[str, str] | None, arguments: re.Pattern[str]) -> str:
    def option(match: re.Match[str]) -> str:
        found = match.groupdict()
        name = found["name"] or (found["flag"] or "").removesuffix("=True") or found.get("about", "")
        typed = f"--{name.replace('_', '-')}" if options is None else options.get(name)
        if typed is None:
            return match[0]
        values = ast.literal_eval(found["value"] or "[]")
        words = [values] if isinstance(values, str) else values
        return " ".join(f"{typed} {shlex.quote(word)}" for word in words) or typed

    return arguments.sub(option, text)


def _lines(what: str, details: Mapping[str, str]) -> Iterator[str]:
    """One to three lines: place and what was found there; what was expected; what to do next."""
    place, found = (details.get(label, "") for label in ("where", "found"))
    is_new = place and f" {place} " not in f" {what} "
    yield (f"{place}: " if is_new else "") + what + (f"; found: {found}" if found else "")
    yield from (f"  {label}: {details[label]}" for label in ("expected", "next") if label in details)


def _line(label: str, value: Location | str | Sequence[str]) -> str:
    items = [value] if isinstance(value, Location | str) else value
    return "; ".join(shortened(visible(str(item)), _LONGEST[label]) for item in items)


class UsageError(GdAnalyzeError):
    """An argument of a call or of the command line is wrong."""


def require_type(value: object, kinds: type | tuple[type, ...], where: str, expected: str) -> None:
    """Raise a UsageError unless an argument is of one of these types, saying what is expected."""
    if not isinstance(value, kinds):
        message = f"{where} is of a wrong type"
        raise UsageError(message, where=where, expected=expected, found=in_python(value))


def require_whole(value: object, where: str, least: int) -> None:
    """Raise a UsageError unless an argument is a whole number of at least `least`."""
    if not isinstance(value, Integral) or isinstance(value, bool) or value < least:
        message, expected = f"{where} is out of range", f"a whole number, {least} or more"
        raise UsageError(message, where=where, expected=expected, found=in_python(value))


class ArmError(GdAnalyzeError):
    """An arm is unknown, or its description is malformed or physically inconsistent."""


class BranchError(ArmError):
    """A robot branches; `paths` has the joints on the way to each link that moves, by its name."""

    paths: Mapping[str, Sequence[str]] = {}


class TrajectoryError(GdAnalyzeError):
    """A trajectory cannot be read, planned or used with the arm at hand."""


class ModelError(GdAnalyzeError):
    """A simplified model's file is damaged or foreign, or the model does not fit its use."""


class StoreError(GdAnalyzeError):
    """An HDF5 result file is damaged, foreign or of another schema version."""


class OutputError(GdAnalyzeError):
    """A result cannot be written."""


class StorageError(OutputError):
    """The machine failed while a result was written: a full disk, a quota, a limit, a device."""


class GdAnalyzeWarning(UserWarning):
    """Something suspicious that does not stop the work; reports show it, too."""

    def __init__(self, text: str) -> None:
        super().__init__(visible(text))


class LeadingWarning(GdAnalyzeWarning):
    """Inputs are probably wrong, so that nothing else means much; it is shown before all others."""


class TorqueLimitWarning(LeadingWarning):
    """A motion takes more torque than the arm's drives give."""


def warn_caller(warning: GdAnalyzeWarning | str) -> None:
    """Give a warning from the line that called the library, as filters and `pytest.warns` expect it."""
    warning = GdAnalyzeWarning(warning) if isinstance(warning, str) else warning
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_OURS):
        frame, level = frame.f_back, level + 1
    warnings.warn(warning, stacklevel=level)


class Warned:
    """The library's warnings, once each, leading ones first; those of a stage of the work are told together.

    Parameters
    ----------
    texts
        Warnings given so far, which are not told again; the list grows.
    tell
        Called with every warning that is new since the last time: by default it is given to whoever called
        the library, in Python as on a terminal.
    """

    def __init__(
        self, texts: list[str] | None = None, tell: Callable[[GdAnalyzeWarning], None] = warn_caller
    ) -> None:
        self.texts = [] if texts is None else texts
        self._tell = tell
        self._told = set(self.texts)
        self._noted: dict[str, GdAnalyzeWarning] = {}

    def note(self, warning: GdAnalyzeWarning) -> None:
        """Note a warning, a leading one before all others."""
        text = str(warning)
        if text not in self.texts:
            self._noted[text] = warning
            self.texts.insert(0 if isinstance(warning, LeadingWarning) else len(self.texts), text)

    def tell(self) -> None:
        """Tell the warnings that were not told yet."""
        new_texts = [text for text in list(self.texts) if text not in self._told]  # threads may note more
        self._told.update(new_texts)
        for text in new_texts:
            if text in self._noted:  # others were told by who put them there
                self._tell(self._noted[text])

    @contextlib.contextmanager
    def collecting(self) -> Iterator[None]:
        """Note the library's warnings while the block lasts, and tell them at its end."""
        shown_by_python = warnings.showwarning

        def note(message: Warning | str, category: type[Warning], *arguments: Any, **keywords: Any) -> None:
            if isinstance(message, GdAnalyzeWarning):
                self.note(message)
            else:
                shown_by_python(message, category, *arguments, **keywords)

        try:
            with warnings.catch_warnings():
                warnings.simplefilter("always", GdAnalyzeWarning)
                warnings.showwarning = note
                yield
        finally:
            self.tell()
