"""What every verb prints with: lines, errors, warnings and progress; control signs are made `visible`."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.errors import Warned
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.text import visible

if TYPE_CHECKING:
    import xarray as xr

# Columns where the terminal's own number is unknown.
WIDTH = 80
# Without a terminal: seconds of work before the first stage is told.
SHORT_SECONDS = 5.0
# Without a terminal: seconds between two lines on the same stage.
REPEATED_AFTER_SECONDS = 60.0


def lines(text: str) -> None:
    """Print a text of several lines: to a file as it is, to a terminal with control characters spelt out."""
    if sys.stdout.isatty():
        text = "".join(visible(line.expandtabs()) + "\n" for line in text.removesuffix("\n").split("\n"))
    click.echo(text, nl=False)


def tell(kind: str, text: str) -> None:
    """Print an error or a warning to standard error; on a terminal its lines are wrapped between words."""
    named = "red" if kind == "error" else "yellow"
    texts = [visible(line) for line in f"{kind}: {text}".split("\n")]
    if sys.stderr.isatty():
        from gd_analyze.report.terminal import wrapped

        indent = "    " if len(texts) > 1 else "  "
        texts = [piece for line in texts for piece in wrapped(line, _terminal_width(), indent)]
    styled = click.style(kind, fg=named, bold=True)
    # Not err=True, which would write past a moving progress display.
    click.echo(styled + "\n".join(texts).removeprefix(kind), file=sys.stderr, color=colour())


def tell_warning(warning: Warning) -> None:
    """Print a warning to standard error."""
    tell("warning", str(warning))


class _LineProgress(Progress):
    """Tells the stages of long work in plain lines on standard error; short work stays silent."""

    def __init__(self, warned: Warned) -> None:
        self._warned = warned
        self._begin = time.monotonic()
        self._label, self._count, self._printed, self._printed_at = "", "", "", 0.0
        self._lock = threading.Lock()
        # For the stage that goes on by then.
        self._timer = threading.Timer(SHORT_SECONDS, self._print)
        self._timer.daemon = True
        self._timer.start()

    def stage(self, label: str, total: int | None = None) -> None:
        """Print the warnings of the last stage, and the new one unless it is too early or was just told."""
        self._warned.tell()
        self._count = ""
        self._print(label)

    def counted(self, count: str) -> None:
        """Print how far the stage is, once a minute."""
        self._count = f", {count}"
        self._print()

    def ranked(self, ranking: xr.Dataset, budget: str) -> None:
        """Print the warnings of the stage."""
        self._warned.tell()

    def end(self) -> None:
        """Tell nothing any more."""
        self._timer.cancel()

    def _print(self, label: str | None = None) -> None:
        with self._lock:
            self._label = self._label if label is None else label
            seconds = time.monotonic() - self._begin
            is_new = self._label != self._printed or seconds - self._printed_at >= REPEATED_AFTER_SECONDS
            if seconds >= SHORT_SECONDS and is_new:
                self._printed, self._printed_at = self._label, seconds
                click.echo(f"{visible(self._label)}{self._count}, after {seconds:.0f} s", err=True)


class _MovingProgress(Progress):
    """Shows stages on a terminal: the present one moves, and the main job's first answer stands above."""

    def __init__(self, display: Any, warned: Warned) -> None:
        self._display, self._task, self._warned = display, display.add_task(""), warned
        self._label = ""

    def stage(self, label: str, total: int | None = None) -> None:
        """Print the warnings of the last stage, and show the new one."""
        self._warned.tell()
        self._label = visible(label)
        self._display.reset(self._task, description=self._label, total=total)

    def counted(self, count: str) -> None:
        """Show how far the stage is."""
        self._display.update(self._task, description=f"{self._label}, {count}")

    def advance(self, steps: int = 1) -> None:
        """Move the bar."""
        self._display.advance(self._task, steps)

    def ranked(self, ranking: xr.Dataset, budget: str) -> None:
        """Show the verdict lists above; the result repeats them for the model's own budget."""
        from gd_analyze.report.document import result_document
        from gd_analyze.report.terminal import text_of
        from gd_analyze.result import Result
        from gd_analyze.results.run_facts import verdict_section

        self._warned.tell()
        section = verdict_section(ranking)
        lists = Result(f"Verdicts at {budget}; models are being searched", parts=(section,))
        self._display.text_above = text_of(result_document(lists), _terminal_width())


@contextmanager
def shown_progress(quiet: bool, warned: Warned) -> Iterator[Progress]:
    """Show work on standard error while it lasts: moving on a terminal, else in lines."""
    if quiet:
        yield NO_PROGRESS
    elif sys.stderr.isatty():
        with _display() as display:
            yield _MovingProgress(display, warned)
    else:
        lines = _LineProgress(warned)
        try:
            yield lines
        finally:
            lines.end()


def _display() -> Any:
    """What moves: a line for the stage, and above it a text."""
    from rich import progress
    from rich.console import Console, RenderableType
    from rich.text import Text

    class Display(progress.Progress):
        text_above = ""

        def get_renderables(self) -> Iterator[RenderableType]:
            if self.text_above:
                yield Text(self.text_above)
            yield from super().get_renderables()

    words = progress.TextColumn("{task.description:<34}", markup=False)
    times = progress.TimeElapsedColumn(), progress.TimeRemainingColumn()
    columns = progress.SpinnerColumn(), words, progress.BarColumn(14), *times
    return Display(*columns, console=Console(stderr=True), transient=True, redirect_stdout=False)


def colour() -> bool | None:
    """Whether to colour: never where NO_COLOR asks for none, else if it is a terminal."""
    return False if os.environ.get("NO_COLOR") else None


def width() -> int:
    """Columns that lines on standard output may take."""
    return _terminal_width() if sys.stdout.isatty() else WIDTH


def _terminal_width() -> int:
    import shutil

    return max(40, shutil.get_terminal_size((WIDTH, 24)).columns)
