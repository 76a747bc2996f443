"""Options that several verbs share, and completion of names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem

from gd_analyze.resources import shipped

F = TypeVar("F", bound=Callable[..., Any])


def reporting(function: F) -> F:
    """--json, --quiet and --debug."""
    for option in (
        click.option("--debug", is_flag=True, help="Show Python's traceback on an error."),
        click.option("--quiet", is_flag=True, help="Print nothing but errors."),
        click.option("--json", "as_json", is_flag=True, help="Print the result as JSON on standard output."),
    ):
        function = option(function)
    return function


class _NameOrFile(click.ParamType):
    """A shipped name or a path, completed as both."""

    def __init__(self, name: str, kind: str, suffix: str) -> None:
        self.name = name
        self._kind, self._suffix = kind, suffix

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Offer shipped names, and let the shell complete files."""
        names = [CompletionItem(n) for n in shipped(self._kind, self._suffix) if n.startswith(incomplete)]
        return [*names, CompletionItem(incomplete, type="file")]


ROBOT = _NameOrFile("robot", "robots", ".toml")
TRAJECTORY = _NameOrFile("trajectory", "trajectories", ".csv")
