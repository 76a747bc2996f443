"""What every verb prints with: a console, tables that fit 80 columns, warnings, progress."""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.errors import GdAnalyzeWarning

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


def console() -> Console:
    """Console on standard output; plain text when it is not a terminal."""
    from rich.console import Console

    return Console(highlight=False, soft_wrap=False, width=None if sys.stdout.isatty() else 80)


def table(title: str, columns: Sequence[tuple[str, str]], rows: Sequence[Sequence[str]]) -> Table:
    """Make a table; each column is (heading, "left" or "right")."""
    from rich import box
    from rich.table import Table

    out = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    out.min_width = min(len(title), 78)
    out.padding = (0, 1, 0, 0)
    for heading, side in columns:
        out.add_column(heading, justify="right" if side == "right" else "left", no_wrap=True)
    for row in rows:
        out.add_row(*row)
    return out


def print_json(value: Any) -> None:
    """Print plain values as JSON."""
    click.echo(json.dumps(value, indent=2, ensure_ascii=False))


@contextmanager
def warnings_told(quiet: bool) -> Iterator[list[str]]:
    """Collect the library's warnings and print them, once each, to standard error."""
    told: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GdAnalyzeWarning)
        yield told
    for item in caught:
        if not issubclass(item.category, GdAnalyzeWarning):
            warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)
        elif str(item.message) not in told:
            told.append(str(item.message))
            if not quiet:
                click.echo(f"{click.style('warning', fg='yellow', bold=True)}: {item.message}", err=True)


@contextmanager
def progress_bar(label: str, total: int, shown: bool) -> Iterator[Callable[[int], None]]:
    """Show a bar on standard error while work of more than a second goes on."""
    if not shown or not sys.stderr.isatty():
        yield lambda done: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(label), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=total)
        yield lambda done: bar.advance(task, done)
