"""The entry point: runs the verbs and turns whatever goes wrong into a message and an exit code."""

from __future__ import annotations

import atexit
import errno
import gc
import io
import os
import shlex
import signal
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

import click
from click.exceptions import NoArgsIsHelpError

from gd_analyze.cli.app import app
from gd_analyze.cli.main_job import analyze
from gd_analyze.cli.terminal import tell
from gd_analyze.errors import GdAnalyzeError, StorageError, UsageError
from gd_analyze.text import visible
from gd_analyze.threads import begin_with_one_thread

DONE, FAILED, BAD_INPUT, INTERRUPTED, TERMINATED = 0, 1, 2, 130, 143
# Errors of the input, whatever state the system is in: no file can have that name.
_AT_FAULT = (errno.ENAMETOOLONG, errno.EILSEQ)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line on words, or those of the process; `SystemExit` unless all went well."""
    if arguments is None:
        _fill_closed_streams()
        _behave_as_a_process()
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        code = _run(words)
        sys.stdout.flush()
    except (click.Abort, KeyboardInterrupt):
        code = INTERRUPTED
    except Exception as error:
        code = _code_of_signal(error) or _explain(error, words)
    if code == INTERRUPTED:
        click.echo("interrupted", err=True)
    if arguments is None and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing is left to clean up
    if code != DONE:
        _empty_output()
        sys.exit(code)


def _empty_output() -> None:
    """Drop what standard output refuses: Python would try again on leaving, and end with its own code."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _code_of_signal(error: BaseException | None) -> int | None:
    """Exit code of the signal behind an error: imports and the making of classes wrap what it raises."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return INTERRUPTED
        if isinstance(error, SystemExit) and error.code == TERMINATED:
            return TERMINATED
        error = error.__cause__ or error.__context__
    return None


def _run(words: list[str]) -> int:
    for word in words:
        if not word.isprintable() and any("\ud800" <= letter <= "\udfff" for letter in word):
            raise UsageError(
                "a word of the command cannot be decoded in this system's encoding",
                found=repr(word),
                next_step="rename the file, or set LC_ALL to the encoding of its name",
            )
    # It goes into comments and onto pages, where a newline within a word would end a line.
    command = visible(shlex.join(["gd-analyze", *words]))
    return int(app(words, prog_name="gd-analyze", standalone_mode=False, obj=command) or DONE)


# What takes less memory, with most verbs.
_FEW = "fewer set points or states"
# What takes less memory, with other verbs.
_FEWER = {"equations": "--element, or an arm of fewer joints"}


def _explain(error: Exception, words: Sequence[str]) -> int:
    """Print what went wrong to standard error and choose the exit code."""
    if isinstance(error, NoArgsIsHelpError):
        error.show()
        return BAD_INPUT
    if "--debug" in words:
        traceback.print_exception(error)
    if isinstance(error, click.ClickException):
        error = _as_our_own(error)
    if isinstance(error, GdAnalyzeError):
        tell("error", error.with_options(options_by_argument(_verb(words))))
        return FAILED if isinstance(error, StorageError) else BAD_INPUT
    if isinstance(error, MemoryError):
        verb = next((word for word in words if not word.startswith("-")), "")
        fewer = _FEWER.get(verb, _FEW if verb in app.commands else f"--no-christoffel, or {_FEW}")
        tell("error", str(GdAnalyzeError("out of memory", found=str(error), next_step=f"try {fewer}")))
    elif isinstance(error, OSError):
        where = None if error.filename is None else str(error.filename)
        explained = GdAnalyzeError("the system refused", where=where, found=error.strerror or str(error))
        tell("error", str(explained))
        if error.errno in _AT_FAULT:
            return BAD_INPUT
    else:
        last = traceback.extract_tb(error.__traceback__)[-1]
        explained = GdAnalyzeError(
            f"{type(error).__name__}: {error}",
            where=f"{Path(last.filename).name}, line {last.lineno}",
            next_step="this is a bug in gd-analyze; please report it with what --debug shows",
        )
        tell("error", str(explained))
    return FAILED


def _verb(words: Sequence[str]) -> click.Command:
    """The verb of a command."""
    return app.commands[next((word for word in words if word in app.commands), analyze.name or "")]


def options_by_argument(verb: click.Command) -> dict[str, str]:
    """Options of a verb by the library's arguments."""
    parameters = [param for param in verb.params if param.opts[0][0] == "-"]
    options = {str(param.name): param.opts[0] for param in parameters}
    negative = {
        f"{param.name}=False": param.secondary_opts[0] for param in parameters if param.secondary_opts
    }
    return options | negative


# Options of earlier versions, and what says the same.
_BY_MAP = {
    "--columns": "--map time=#1 --map 'q=#2..#7'",
    "--rate": "--map time=250Hz",
    "--time-unit": "--map time=:ms",
    "--degrees": "--map q=:deg",
    "--family": "--map 'q=target_q_*'",
}


def _as_our_own(error: click.ClickException) -> GdAnalyzeError:
    """Put click's complaint into the form of every other message."""
    context = getattr(error, "ctx", None)
    said_now = _BY_MAP.get(error.option_name) if isinstance(error, click.NoSuchOption) else None
    message = " ".join(error.format_message().split()).rstrip(".").replace(". (", " (")
    return UsageError(
        message[:1].lower() + message[1:],
        expected=" ".join(context.get_usage().removeprefix("Usage: ").split()) if context else None,
        next_step=said_now or (f"see `{context.command_path} --help`" if context else None),
    )


def _behave_as_a_process() -> None:
    """Settle what concerns the whole process, not a call from Python."""
    begin_with_one_thread()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A terminal that cannot show a sign shows a question mark, and nothing breaks.
            stream.reconfigure(errors="replace")
    if hasattr(signal, "SIGPIPE"):
        # As with every Unix tool, `| head` ends it quietly; all files are written before anything is printed.
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    # By an exception, so that temporary files are removed on the way.
    if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(TERMINATED))
    # Importing the numerical libraries makes a million objects that live as long as the process. Looking
    # through them again and again, and once more on leaving, would take a fifth of the main job.
    gc.set_threshold(1_000_000, 50, 100)
    atexit.register(gc.freeze)


def _fill_closed_streams() -> None:
    """Open the null device in place of standard streams that are closed, as `>&-` and `<&-` do in a shell.

    Their numbers are taken then, so that no file opened later gets the number that libraries print to.
    Nothing can be written to that of the output: a result that goes nowhere is an error.
    """
    null = Path(os.devnull)
    sys.stdin = sys.stdin or null.open(encoding="utf-8")
    sys.stdout = sys.stdout or null.open(encoding="utf-8")
    sys.stderr = sys.stderr or null.open("w", encoding="utf-8")
