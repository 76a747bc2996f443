"""Writes docs/cli.md from the commands' own help: `python tests/docs/cli_reference.py`."""

from __future__ import annotations

from pathlib import Path

import click

from gd_analyze.cli.app import app

PAGE = Path(__file__).parents[2] / "docs" / "cli.md"
WIDTH = 78  # what click makes of a terminal of 80 columns

INTRODUCTION = """\
# Command line

<!-- Written by tests/docs/cli_reference.py from the commands' own help; a test compares the two. -->

This page has the help of every command. `gd-analyze ROBOT TRAJECTORY` is the main job; every other command is
a verb: `gd-analyze VERB`. Options may stand before, between or after the arguments.

**Output.** Results and `--json` go to standard output; warnings, errors and progress to standard error.
Progress shows on a terminal only. A result consists of facts, tables with units in their headings, and
notices. `--json` prints the same as one JSON value in ASCII, with `null` for numbers that are not finite, and
`warnings` and `files` at its end. The terminal rounds numbers, bounds upwards; files and JSON hold every
digit. `NO_COLOR=1` switches colour off.

**Files** are written under hidden names and moved into place at the end. A command that fails leaves the old
files unchanged. Each file in a folder of results carries the mark of its run; a warning names files of
another run beside it. No command overwrites a file that it reads.

**Errors** say what is wrong, where (file, line, column), what was expected, what was found, and what to do
next. Exit code 2: the command or its input is at fault. Exit code 1: gd-analyze or the machine failed, or a
model failed `validate --fail-over`. `--debug` adds Python's traceback.

**Units.** Joint values on the command line are degrees (metres for prismatic joints), torques are N m (N).

**Names.** If a trajectory file has the name of a shipped trajectory, or an arm file that of a verb, give it
as `./NAME`.
"""

COLUMNS = """
## The tables of the main job

| column | meaning |
|---|---|
| `peak torque` | largest magnitude of the exact torque of the joint along the trajectory |
| `allowed` | the error the budget allows the joint |
| `error`, `of peak` | largest error of the model at the set points, and its share of peak torque |
| `proven`, `of peak` | bound on the error near the motion, rounded up, and its share of peak torque |
| `tran`, `rot` | largest magnitude of the element's translational and rotational part |
| `torque`, `joint` | the element's largest torque and the joint it acts at |
| `of peak` | that torque's share of the joint's peak torque |
| `effect` | the effect that dominates: `T`, `R`, `T+R`; `✓` gravity; `–` negligible; `0` zero |
| `kept` | parts of the element that [FGL87]'s own method keeps: `T`, `R`, `T+R`, `✓` or, for none, `0` |
| `FGL87` | the verdict that [FGL87] reads from its figures, for the PUMA 560 |

An effect dominates an element if dropping the other one changes it by at most 10 % of its peak. An element is
negligible if all its torques stay below budget / (n + 2); all negligible elements can be dropped together.
The share of an element that others cancel may exceed 100 %; it is ∞ where the joint has no torque.

[FGL87]: K. S. Fu, R. C. Gonzalez, C. S. G. Lee, *Robotics: Control, Sensing, Vision, and Intelligence*,
McGraw-Hill, 1987, chapter 3.
"""


def help_of(*verb: str) -> str:
    """What `gd-analyze [VERB] --help` prints at 80 columns."""
    context = click.Context(app, info_name="gd-analyze", terminal_width=WIDTH, **app.context_settings)
    command: click.Command = app
    for name in verb:
        command = app.commands[name]
        context = click.Context(command, info_name=name, parent=context, terminal_width=WIDTH)
    return command.get_help(context) + "\n"


def page() -> str:
    """Text of docs/cli.md."""
    sections = [INTRODUCTION, "\n## gd-analyze\n\n```text\n" + help_of() + "```\n", COLUMNS]
    for name, command in app.commands.items():
        if not command.hidden:
            sections.append(f"\n## gd-analyze {name}\n\n```text\n{help_of(name)}```\n")
    return "".join(sections)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
