"""How a verb gives its result: as text, as JSON, or not at all."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.log_options import STAGE
from gd_analyze.cli.options import together
from gd_analyze.cli.terminal import Stages, line, print_json, show_result, stages, warnings_collected
from gd_analyze.simplification.cache import without_cache

if TYPE_CHECKING:
    from gd_analyze.result import Result


@dataclass
class Output:
    """What --json and --quiet ask for, and the warnings given so far."""

    as_json: bool
    quiet: bool
    warnings: list[str] = field(default_factory=list)

    @contextmanager
    def working(self) -> Iterator[Stages]:
        """Show the stages of the work while it lasts, and its warnings in the end."""
        with warnings_collected(self.quiet, self.warnings), stages(self.quiet) as stage:
            click.get_current_context().meta[STAGE] = stage
            yield stage

    def give(self, result: Result, wrote: Path | Sequence[Path] | None = None) -> None:
        """Print a result the way that was asked for, and which files hold it."""
        files = [] if wrote is None else [wrote] if isinstance(wrote, Path) else [*wrote]
        if self.as_json:
            ends = {"warnings": self.warnings, "files": [str(path) for path in files]}
            print_json(result.document() | ends)
        elif not self.quiet:
            show_result(result)
            for path in files:
                line(f"wrote {path}")


def reporting(function: Callable[..., None]) -> Callable[..., None]:
    """--json, --quiet, --no-cache and --debug; the verb gets an `Output`."""

    @functools.wraps(function)
    def verb(as_json: bool, quiet: bool, no_cache: bool, debug: bool, **words: Any) -> None:
        with without_cache() if no_cache else nullcontext():
            function(output=Output(as_json, quiet), **words)

    return together(
        click.option("--json", "as_json", is_flag=True, help="Print the result as JSON on standard output."),
        click.option("--quiet", is_flag=True, help="Print nothing but errors."),
        click.option("--no-cache", is_flag=True, help="Neither read nor write the cache."),
        click.option("--debug", is_flag=True, help="Show Python's traceback on an error."),
    )(verb)
