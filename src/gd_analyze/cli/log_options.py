"""Options on how a log is read, for every verb that takes a trajectory."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click

import gd_analyze as gd
from gd_analyze.cli.options import TRAJECTORY, Amount, F, command_line, together

_KEPT = "gd_analyze.log"
_OF_READINGS = {"cutoff", "largest_gap"}


def _keep(context: click.Context, parameter: click.Parameter, value: Any) -> Any:
    """Keep a value with the command, so that no verb has to pass it on."""
    # --planned is False; so is a flag that is absent.
    is_stated = value not in (None, ()) and (value is not False or parameter.name == "measured")
    if parameter.name is not None and is_stated:
        context.meta.setdefault(_KEPT, {})[parameter.name] = value
    return value


def _log_options(hidden: bool) -> Callable[[F], F]:
    def option(name: str, words: str, **more: Any) -> Callable[[F], F]:
        return click.option(name, help=words, hidden=hidden, expose_value=False, callback=_keep, **more)

    return together(
        option(
            "--map",
            "Log: what its columns are. A * stands for a joint's name or number: 'q=AIPos.A*:deg'; "
            "q=mp1..mp7 and q=#2..#8 list names and numbers; q:elbow=Position3 is of one joint. "
            "time=Stamp:us, time=250Hz (rows), time=Sample:250Hz. q=:deg, time=:ms: the unit of columns that "
            "are recognized. joints=s,l,u,r,b,t: the log's names of the joints. qd=none. May be repeated.",
            metavar="ROLE=COLUMNS[:UNIT]",
            multiple=True,
        ),
        option("--topic", "Bag: topic to read.", metavar="TOPIC"),
        option(
            "--torque-constant",
            "Log: joint torque per ampere of each joint, where torque columns hold currents.",
            metavar="LIST",
        ),
        option(
            "--torque-sign",
            "Log: -1 for joints whose torque is reversed, else 1; or one sign for all.",
            metavar="LIST",
        ),
        option(
            "--position-sign",
            "Log: likewise for joints that count the other way; reverses positions and torques.",
            metavar="LIST",
        ),
        option(
            "--offset",
            "Log: added to a joint's positions: 3=90deg. May be repeated.",
            metavar="JOINT=ANGLE",
            multiple=True,
        ),
        option(
            "--couple",
            "Log: a joint's variable as a sum of those logged, such as q3=q3-q2 where joint 3 is measured "
            "against the base. May be repeated.",
            metavar="SUM",
            multiple=True,
        ),
        option("--lag", "Log: time by which torques are late, such as 4ms.", metavar="TIME"),
        option("--drop-rows", "Log: leave out corrupt rows.", is_flag=True),
        option(
            "--measured/--planned",
            "Log: sensor readings, to be smoothed, or a plan.  [default: judged by its columns]",
            default=None,
        ),
        option(
            "--cutoff",
            "Readings: cut-off frequency of the smoothing.  [default: from their noise]",
            metavar="HZ",
            type=Amount("frequency", 0.01, 1e4),
        ),
        option(
            "--largest-gap",
            "Readings: longest step between samples that is no gap.",
            metavar="SECONDS",
            type=Amount("time", 1e-4, 60.0),
        ),
    )


# Most verbs take these options without listing them.
log_options, log_options_listed = _log_options(hidden=True), _log_options(hidden=False)
# LOG... and how they are read, for verbs that compare torques.
logs = together(
    click.argument(
        "logs",
        type=TRAJECTORY,
        nargs=-1,
        required=True,
        metavar="LOG...",
        help="Recordings with torques, or currents (--torque-constant), or a folder of them; options: "
        "`gd-analyze columns --help`.",
    ),
    log_options,
)


def reading_asked() -> tuple[gd.types.Reading | None, gd.types.Treatment | None]:
    """How the user wants logs read and readings treated; None where no option says so."""
    from gd_analyze.motions.reading import Reading, Treatment

    words = click.get_current_context().meta.get(_KEPT, {})
    reading = {name: word for name, word in words.items() if name not in _OF_READINGS}
    treatment = {name: word for name, word in words.items() if name in _OF_READINGS}
    return Reading.of(**reading) if reading else None, Treatment(**treatment) if treatment else None


def words_of_reading() -> list[str]:
    """The options on how logs are read, as words that say the same in any verb that reads them."""
    context = click.get_current_context()
    words = context.meta.get(_KEPT, {})
    typed: list[str] = []
    for option in context.command.params:
        if isinstance(option, click.Option) and option.name in words:
            value = words[option.name]
            if option.is_flag:
                typed.append((option.opts if value else option.secondary_opts)[0])
            else:
                values = value if option.multiple else [value]
                typed += [word for each in values for word in (option.opts[0], str(each))]
    return typed


def words_typed(option: str) -> list[str]:
    """An option of the command with its value, as typed; empty without it."""
    typed = shlex.split(command_line())
    for place, word in enumerate(typed):
        if word == option:
            return typed[place : place + 2]
        if word.startswith(f"{option}="):
            return [word]
    return []


def command_that_mends(inputs: Sequence[str], typed: Sequence[str], *, identify: bool, remedy: str) -> str:
    """What to type where file and logs do not agree; "" if nothing mends them.

    Parameters
    ----------
    inputs
        Words that name the robot and the logs.
    typed
        The command that takes the options of a remedy.
    identify
        Whether the links are to be fitted to the logs.
    remedy
        Options that mend the logs or the arm; "" for none.
    """
    if identify:
        return shlex.join(["gd-analyze", "identify", *inputs, *words_of_reading(), "-o", "fitted.toml"])
    options = shlex.split(remedy)
    # Options already typed would have to be combined with these.
    is_new = not {word.partition("=")[0] for word in typed} & {word for word in options if word[:2] == "--"}
    return shlex.join([*typed, *options]) if options and is_new else ""


def command_that_excites(robot: Sequence[str]) -> str:
    """What to type where a log tells nothing of a robot, named by these words: a motion that does."""
    return shlex.join(["gd-analyze", "plan", *robot, "--exciting", "--duration", "20", "-o", "exciting.csv"])


def command_of_columns(robot: Sequence[str], log: str) -> str:
    """What to type where columns of a log are of no use: how they are read."""
    return shlex.join(["gd-analyze", "columns", *robot, log, *words_of_reading()])


def read_motion(path: str | Path, arm: gd.types.RobotArm, progress: gd.types.Progress) -> gd.Trajectory:
    """Read a trajectory or a log as the command's options say."""
    return gd.read_trajectory(path, arm, *reading_asked(), progress=progress)


def read_logs(
    words: tuple[str, ...], arm: gd.types.RobotArm, progress: gd.types.Progress
) -> list[gd.Trajectory]:
    """Read logs or folders of them as the command's options say, each by itself."""
    from gd_analyze.motions.pool import motions_of

    return motions_of(words, arm, partial(read_motion, progress=progress)) if words else []


def read_motions(
    words: tuple[str, ...], arm: gd.types.RobotArm, progress: gd.types.Progress
) -> gd.Trajectory:
    """Read trajectories, logs or folders of them as the command's options say; several become one."""
    from gd_analyze.motions.pool import trajectory_of

    return trajectory_of(words, arm, partial(read_motion, progress=progress))
