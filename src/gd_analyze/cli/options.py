"""Kinds of words in a command: how they are checked and completed."""

from __future__ import annotations

import math
from typing import Any

import click
from click.shell_completion import CompletionItem

from gd_analyze.resources import shipped

top_option = click.option(
    "--top",
    type=click.IntRange(min=0),
    default=12,
    show_default=True,
    metavar="NUMBER",
    help="Rows of the ranking to print.",
)


def command_line() -> str:
    """What the user typed, as it can be pasted into a shell again."""
    return str(click.get_current_context().find_root().obj or "")


class NameOrFile(click.ParamType[str]):
    """A shipped name or a path, completed as both."""

    def __init__(self, name: str, kind: str, suffix: str) -> None:
        self.name = name
        self._kind, self._suffix = kind, suffix

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter | None, incomplete: str
    ) -> list[CompletionItem]:
        """Offer shipped names, and let the shell complete files."""
        names = [CompletionItem(n) for n in shipped(self._kind, self._suffix) if n.startswith(incomplete)]
        # The files come first: bash's script forgets what stood before the request for them.
        return [CompletionItem(incomplete, type="file"), *names]


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


class PositiveNumber(click.ParamType[float]):
    """A finite number above zero, which click's own range does not insist on: it lets nan and inf pass."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read it."""
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not (math.isfinite(number) and number > 0):
            self.fail(f"{value!r} is not a number above 0", param, ctx)
        return number


ROBOT = NameOrFile("robot", "robots", ".toml")
TRAJECTORY = NameOrFile("trajectory", "trajectories", ".csv")

ROBOT_HELP = "Built-in arm (see `gd-analyze arms`), or path of an arm's TOML file."
TRAJECTORY_HELP = "CSV file, name of a shipped trajectory, or - for standard input."
