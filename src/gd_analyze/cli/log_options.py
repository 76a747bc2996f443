"""Options on how a log is read, for every verb that takes a trajectory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli.options import FILE, F, OutputPath, positive_number, together

if TYPE_CHECKING:
    from gd_analyze.motions.table import Progress

_KEPT = "gd_analyze.log"
# Where a command keeps what shows its stages.
STAGE = "gd_analyze.stage"
_OF_READINGS = {"cutoff", "largest_gap"}


def _keep(context: click.Context, parameter: click.Parameter, value: Any) -> Any:
    """Keep a value with the command, so that no verb has to pass it on."""
    # --planned is False; so is a flag that is absent.
    said = value not in (None, ()) and (value is not False or parameter.name == "measured")
    if parameter.name is not None and said:
        context.meta.setdefault(_KEPT, {})[parameter.name] = value
    return value


def _log_options(hidden: bool) -> Callable[[F], F]:
    def option(name: str, words: str, **more: Any) -> Callable[[F], F]:
        return click.option(name, help=words, hidden=hidden, expose_value=False, callback=_keep, **more)

    return together(
        option(
            "--columns",
            "Of a log: names of its columns where it has no header, such as time,q1..q6,-; of one that has, "
            "the only columns to look at.",
            metavar="LIST",
        ),
        option(
            "--map",
            "Of a log: role of a column (time=Time, q:JOINT=Position3, torque:JOINT=#9, torque=none) or of a "
            "column per joint (q=mp1..mp7), or the log's name of a joint (joint:elbow=joint_a3). May be "
            "repeated.",
            metavar="ROLE=COLUMN",
            multiple=True,
        ),
        option(
            "--rate",
            "Of a log: samples per second, where its time counts samples or it has none.",
            metavar="HZ",
            type=positive_number,
        ),
        option("--time-unit", "Of a log: unit of its time.", type=click.Choice(["s", "ms", "us", "ns"])),
        option("--degrees", "Of a log: angles of columns without a unit are in degrees.", is_flag=True),
        option(
            "--family",
            "Of a log: which columns to take where several hold the same, by a word of their names (target, "
            "actual), for one role: torque=cur. May be repeated.",
            metavar="WORD",
            multiple=True,
        ),
        option("--topic", "Of a bag: which topic to read.", metavar="TOPIC"),
        option("--mapping", "Of a log: mapping file to read it by.", type=FILE),
        option(
            "--save-mapping",
            "Of a log: write a mapping file of how it was read, for similar logs.",
            type=OutputPath(),
        ),
        option(
            "--torque-constant",
            "Of a log: its torque columns are currents; torque at the joints per ampere, by joint.",
            metavar="LIST",
        ),
        option(
            "--measured/--planned",
            "Of a log: readings of sensors, to be smoothed, or a plan.  [default: judged by its columns]",
            default=None,
        ),
        option(
            "--cutoff",
            "Of readings: cut-off frequency of their smoothing.  [default: from the noise found in them]",
            metavar="HZ",
            type=positive_number,
        ),
        option(
            "--largest-gap",
            "Of readings: longest time between two of them that is not a gap in the motion.",
            metavar="SECONDS",
            type=positive_number,
        ),
    )


# A verb that is about something else takes them without listing them.
log_options, log_options_listed = _log_options(hidden=True), _log_options(hidden=False)


def reading_asked() -> tuple[gd.Reading | None, gd.Treatment | None]:
    """How the user wants logs read, and readings treated; None where nothing is said of it."""
    words = click.get_current_context().meta.get(_KEPT, {})
    reading = {name: word for name, word in words.items() if name not in _OF_READINGS}
    treatment = {name: word for name, word in words.items() if name in _OF_READINGS}
    return gd.Reading.of(**reading) if reading else None, gd.Treatment(**treatment) if treatment else None


def read_motion(path: str | Path, arm: gd.RobotArm) -> gd.Trajectory:
    """Read a trajectory or a log as the command's options say, and show how far it is."""
    return gd.read_trajectory(path, arm, *reading_asked(), progress=progress_shown())


def read_motions(words: tuple[str, ...], arm: gd.RobotArm) -> gd.Trajectory:
    """Read trajectories, logs or folders of them as the command's options say; several become one."""
    from gd_analyze.motions.pool import trajectory_of

    return trajectory_of(words, arm, read_motion)


def progress_shown() -> Progress:
    """Show how much of a log is read."""
    stage, before = click.get_current_context().meta[STAGE], 0

    def tell(done: int, total: int) -> None:
        nonlocal before
        if done <= before or not before:
            stage("reading", total)
            before = 0
        stage.advance(done - before)
        before = done

    return tell
