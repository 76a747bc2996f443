"""How a verb gives its result, as text, as JSON or not at all, and which files it may write."""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cache import without_cache
from gd_analyze.cli.options import FILE, NameOrFile, together
from gd_analyze.cli.terminal import colour, shown_progress, tell_warning, width
from gd_analyze.errors import UsageError, Warned
from gd_analyze.files import require_writable
from gd_analyze.progress import Progress
from gd_analyze.text import visible

if TYPE_CHECKING:
    from gd_analyze.result import Result


@dataclass
class Output:
    """What --json and --quiet ask for, and the warnings given so far."""

    as_json: bool
    quiet: bool
    warnings: list[str] = field(default_factory=list)

    @contextmanager
    def working(self) -> Iterator[Progress]:
        """Show the stages of the work while it lasts, the first "reading", and its warnings in the end."""
        warned = Warned(self.warnings, (lambda warning: None) if self.quiet else tell_warning)
        with warned.collecting(), shown_progress(self.quiet, warned) as progress:
            progress.stage("reading")
            yield progress

    def warn(self, texts: Iterable[str]) -> None:
        """Note warnings that a study kept."""
        self.warnings[:] = dict.fromkeys([*texts, *self.warnings])

    def give(
        self,
        result: Result,
        *files: Path | None,
        folder: Path | None = None,
        replaced: str = "",
        next_command: str = "",
    ) -> None:
        """Print a result as text or JSON, and the names of its files; those of a folder in one line.

        `replaced` says in words what the files replaced; `next_command` is the last line.
        """
        written = [path for path in files if path is not None]
        if self.as_json:
            ends: dict[str, Any] = {"warnings": self.warnings, "files": list(map(str, written))}
            if next_command:
                ends["next"] = next_command
            # In ASCII and without the NaN and Infinity that JSON does not know.
            click.echo(json.dumps(result.values() | ends, indent=2, allow_nan=False))
        elif not self.quiet:
            from gd_analyze.report.document import result_document
            from gd_analyze.report.terminal import text_of, wrapped

            text = text_of(result_document(result), width(), functools.partial(click.style, bold=True))
            click.echo(text, nl=False, color=colour())
            if folder is not None and written:
                # A folder's name is not broken between its words.
                where = str(folder).replace(" ", "\u00a0")
                names = ", ".join(path.name for path in written)
                click.echo("\n".join(wrapped(f"wrote {where}: {names}", width(), "  ")))
            for path in () if folder is not None else written:
                remark = f", which replaces {replaced}" if replaced else ""
                click.echo(visible(f"wrote {path}{remark}"))
            if next_command:
                # In one line of its own, so that it can be pasted.
                click.echo(visible(f"next: {next_command}"))


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


def require_outputs(*paths: Path | None, option: str = "--out") -> None:
    """Refuse outputs that cannot be written, or that the verb reads, before it computes anything."""
    inputs = list(_inputs(click.get_current_context()))
    for path in filter(None, paths):
        require_writable(path, option)
        for word, status in inputs:
            if path.exists() and os.path.samestat(path.stat(), status):
                raise UsageError(
                    "the output would replace an input",
                    where=str(path),
                    found=f"the same file as {word}",
                    next_step=f"choose another name with {option}",
                )


def _inputs(context: click.Context) -> Iterator[tuple[str, os.stat_result]]:
    """Words of the command that name inputs, and the files they stand for."""
    for parameter in context.command.params:
        value: Any = context.params.get(parameter.name or "")
        if value is None or not (isinstance(parameter.type, NameOrFile) or parameter.type is FILE):
            continue
        for word in value if isinstance(value, tuple) else (value,):
            path = parameter.type.path_of(word) if isinstance(parameter.type, NameOrFile) else Path(word)
            try:
                yield str(word), os.fstat(0) if str(path) == "-" else path.stat()
                # A folder stands for the files in it.
                yield from (
                    (str(member), member.stat()) for member in (path.iterdir() if path.is_dir() else ())
                )
            except (OSError, ValueError):
                continue  # what cannot be read is for the reader to say
