"""Kinds of words in a command: how they are checked and completed, and options of several verbs."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem

from gd_analyze.files import shipped
from gd_analyze.text import LARGEST, number_in

F = TypeVar("F", bound=Callable[..., Any])


def command_line() -> str:
    """What the user typed, as it can be pasted into a shell again."""
    return str(click.get_current_context().find_root().obj or "")


class NameOrFile(click.ParamType[str]):
    """A shipped name or a path, completed as both."""

    def __init__(self, name: str, kind: str, suffix: str) -> None:
        self.name = name
        self._kind, self._suffix = kind, suffix

    def path_of(self, word: str) -> Path:
        """Path of what a word names."""
        return shipped(self._kind, self._suffix).get(word, Path(word))

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter | None, incomplete: str
    ) -> list[CompletionItem]:
        """Offer shipped names, and let the shell complete files."""
        names = [CompletionItem(n) for n in shipped(self._kind, self._suffix) if n.startswith(incomplete)]
        # The files come first: bash's script forgets what stood before the request for them.
        return [CompletionItem(incomplete, type="file"), *names]


class Output(click.Path):
    """A file or folder to write."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse the empty name, which would stand for the folder one is in."""
        if value == "":
            self.fail("the name is empty", param, ctx)
        return super().convert(value, param, ctx)


class NameList(click.ParamType[tuple[str, ...]]):
    """Some of a few names, comma-separated."""

    name = "list"

    def __init__(self, names: tuple[str, ...], kind: str) -> None:
        self.names, self._kind = names, kind

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        """Split and check; every name counts once."""
        if isinstance(value, tuple):
            return value
        chosen = [entry.strip().lower() for entry in str(value).split(",")]
        for entry in chosen:
            if entry not in self.names:
                self.fail(f"there is no {self._kind} {entry!r}, only {', '.join(self.names)}", param, ctx)
        return tuple(name for name in self.names if name in chosen)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Offer the names that may follow the last comma."""
        before, comma, last = incomplete.rpartition(",")
        taken = before.split(",")
        return [
            CompletionItem(before + comma + name)
            for name in self.names
            if name.startswith(last) and name not in taken
        ]


def number_read(words: str) -> float:
    """Read a number; nan where there is none."""
    number = number_in(words)
    return math.nan if number is None else number


class PositiveNumber(click.ParamType[float]):
    """A number above zero and of a size that anything has; click's own range lets nan and inf pass."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read it."""
        number = number_read(str(value))
        if not 0 < number <= LARGEST:
            self.fail(f"{value!r} is not a number above 0 and up to {LARGEST:g}", param, ctx)
        return number


ROBOT = NameOrFile("robot", "robots", ".toml")
TRAJECTORY = NameOrFile("trajectory", "trajectories", ".csv")

FILE = click.Path(path_type=Path)

ROBOT_HELP = "Built-in arm (see `gd-analyze arms`), or path of an arm's URDF, MJCF or TOML file."

# A double has no more.
_MOST_DIGITS = 17


def together(*options: Callable[[F], F]) -> Callable[[F], F]:
    """Several options as one decorator, in the order of the help."""

    def decorate(function: F) -> F:
        for option in reversed(options):
            function = option(function)
        return function

    return decorate


def number_option(
    name: str, default: int | None, words: str, least: int = 0, most: int | None = None
) -> Callable[[F], F]:
    """Make an option that takes a whole number."""
    return click.option(
        name,
        type=click.IntRange(least, most),
        default=default,
        show_default=True,
        metavar="NUMBER",
        help=words,
    )


def digits_option(words: str) -> Callable[[F], F]:
    """--digits, three by default."""
    digits = click.IntRange(1, _MOST_DIGITS)
    return click.option("--digits", type=digits, default=3, show_default=True, help=words)


def out_option(words: str) -> Callable[[F], F]:
    """--out, a file or a folder."""
    return click.option("-o", "--out", type=Output(), help=words)


overwrite_option = click.option(
    "--overwrite",
    is_flag=True,
    help="Replace a run of another arm, motion or other options that the folder holds.",
)


def formats_option(names: tuple[str, ...]) -> Callable[[F], F]:
    """--format, some of the files that a verb can write; all by default."""
    return click.option(
        "--format",
        "formats",
        type=NameList(names, "format"),
        default=",".join(names),
        show_default=True,
        metavar="LIST",
        help="Which files to write, comma-separated.",
    )


def margin_option(words: str) -> Callable[[F], F]:
    """--margin; None where it is not given."""
    return click.option(
        "--margin",
        metavar="LIST",
        help=f"{words}: 1deg or 1mm of position (revolute or prismatic joints), qd=2% of each joint's peak "
        "velocity, qdd=5% of its peak acceleration; those not named keep their default.  "
        "[default: 1deg,1mm,qd=2%,qdd=5%]",
    )


def trajectories_argument(
    without: str | None = None, several: str = "of several motions the budget holds on each"
) -> Callable[[F], F]:
    """TRAJECTORY..., one or several; optional where `without` says what happens then."""
    words = (
        "CSV file, log (its options: `gd-analyze columns --help`), name of a shipped trajectory, - for "
        f"standard input, or a folder of these; {several}."
    )
    return click.argument(
        "trajectories",
        type=TRAJECTORY,
        nargs=-1,
        required=without is None,
        metavar="TRAJECTORY..." if without is None else "[TRAJECTORY]...",
        help=words if without is None else f"{words} {without}",
    )


def trajectory_argument(without: str | None = None) -> Callable[[F], F]:
    """TRAJECTORY, which may be left out where `without` says what happens then."""
    words = (
        "CSV file, log (its options: `gd-analyze columns --help`), name of a shipped trajectory, or - for "
        "standard input."
    )
    return click.argument(
        "trajectory",
        type=TRAJECTORY,
        required=without is None,
        help=words if without is None else f"{words} {without}",
    )


top_option = number_option("--top", 12, "Rows of the ranking to print.")
