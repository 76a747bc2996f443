"""Options on how a log is read, for every verb that takes a trajectory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from gd_analyze.cli.options import FILE, Output, PositiveNumber, together

if TYPE_CHECKING:
    import gd_analyze as gd
    from gd_analyze.motions.reading import Reading, Treatment
    from gd_analyze.motions.table import Progress

F = TypeVar("F", bound=Callable[..., Any])

_KEPT = "gd_analyze.log"
# Where a command keeps what shows its stages.
STAGE = "gd_analyze.stage"


def _keep(context: click.Context, parameter: click.Parameter, value: Any) -> Any:
    """Keep a value with the command, for `reading_asked`: no verb has to pass it on."""
    # --planned is False; so is a flag that is absent.
    said = value not in (None, ()) and (value is not False or parameter.name == "measured")
    if parameter.name is not None and said:
        context.meta.setdefault(_KEPT, {})[parameter.name] = value
    return value


_OPTIONS: tuple[tuple[str, dict[str, Any]], ...] = (
    (
        "--columns",
        {
            "metavar": "LIST",
            "help": "Of a log: names of its columns where it has no header, such as time,q1..q6,-; of one "
            "that has, the only columns to look at.",
        },
    ),
    (
        "--map",
        {
            "multiple": True,
            "metavar": "ROLE=COLUMN",
            "help": "Of a log: what a column holds: time=Time, q:JOINT=Position3, torque:JOINT=#9, "
            "torque=none, or the log's name of a joint: joint:elbow=joint_a3. May be repeated.",
        },
    ),
    (
        "--rate",
        {
            "type": PositiveNumber(),
            "metavar": "HZ",
            "help": "Of a log: samples per second, where its time counts samples or it has none.",
        },
    ),
    ("--time-unit", {"type": click.Choice(["s", "ms", "us", "ns"]), "help": "Of a log: unit of its time."}),
    ("--degrees", {"is_flag": True, "help": "Of a log: angles of columns without a unit are in degrees."}),
    (
        "--family",
        {
            "multiple": True,
            "metavar": "WORD",
            "help": "Of a log: which columns to take where several hold the same, by a word of their names "
            "(target, actual), for one role: torque=cur. May be repeated.",
        },
    ),
    ("--topic", {"metavar": "TOPIC", "help": "Of a bag: which topic to read."}),
    ("--mapping", {"type": FILE, "help": "Of a log: read it as a mapping file says."}),
    (
        "--save-mapping",
        {
            "type": Output(),
            "help": "Of a log: write a mapping file of how it was understood, for logs alike.",
        },
    ),
    (
        "--measured/--planned",
        {
            "default": None,
            "help": "Of a log: readings of sensors, to be smoothed, or a plan.  "
            "[default: what its columns tell]",
        },
    ),
    (
        "--cutoff",
        {
            "metavar": "HZ",
            "type": PositiveNumber(),
            "help": "Of readings: cut-off frequency of their smoothing.  "
            "[default: by the noise found in them]",
        },
    ),
    (
        "--largest-gap",
        {
            "metavar": "SECONDS",
            "type": PositiveNumber(),
            "help": "Of readings: longest time between two of them across which the motion goes on.",
        },
    ),
)


def _together(hidden: bool) -> Callable[[F], F]:
    kept: dict[str, Any] = {"expose_value": False, "callback": _keep, "hidden": hidden}
    return together(*(click.option(name, **words, **kept) for name, words in _OPTIONS))


# A verb that is about something else takes them without listing them.
log_options, log_options_listed = _together(hidden=True), _together(hidden=False)

_TREATED = ("cutoff", "largest_gap")


def _words() -> dict[str, Any]:
    context = click.get_current_context(silent=True)
    return dict(context.meta.get(_KEPT, {})) if context is not None else {}


def reading_asked() -> Reading | None:
    """How the user wants logs read; None where nothing is said of it."""
    words = {name: word for name, word in _words().items() if name not in _TREATED}
    if not words:
        return None
    from gd_analyze.motions.reading import Reading

    return Reading.of(**words)


def treatment_asked() -> Treatment | None:
    """How the user wants readings treated; None where nothing is said of it."""
    words = {name: word for name, word in _words().items() if name in _TREATED}
    if not words:
        return None
    from gd_analyze.motions.reading import Treatment

    return Treatment(**words)


def read_motion(path: str | Path, arm: gd.RobotArm) -> gd.Trajectory:
    """Read a trajectory or a log as the command's options say, and show how far it is."""
    import gd_analyze as gd

    return gd.read_trajectory(path, arm, reading_asked(), treatment_asked(), progress=progress_shown())


def read_motions(words: tuple[str, ...], arm: gd.RobotArm) -> gd.Trajectory:
    """Read what words stand for, trajectories, logs or folders of them, as the command's options say.

    Several motions are one trajectory.
    """
    from gd_analyze.motions.pool import trajectory_of

    return trajectory_of(words, arm, read_motion)


def read_each(words: tuple[str, ...], arm: gd.RobotArm) -> list[gd.Trajectory]:
    """Read the same as `read_motions`, each motion by itself."""
    from gd_analyze.motions.pool import motions_of

    return motions_of(words, arm, read_motion)


def progress_shown() -> Progress:
    """Show on the terminal how much of a log is read, where the command shows its stages."""
    context = click.get_current_context(silent=True)
    stage = None if context is None else context.meta.get(STAGE)
    before = 0

    def tell(done: int, total: int) -> None:
        nonlocal before
        if stage is not None:
            if done <= before or not before:
                stage("reading", total)
                before = 0
            stage.advance(done - before)
        before = done

    return tell
