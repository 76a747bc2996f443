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

`gd-analyze ROBOT TRAJECTORY` is the main job; everything else is a verb. Options may stand before, between or
behind the arguments.

**Output.** Results, tables and `--json` go to standard output; warnings, errors and progress to standard
error. Progress shows on a terminal only. `--json` prints one JSON value in ASCII, with `null` for numbers
that are not finite. `NO_COLOR=1` switches colour off. The terminal rounds for display; files and JSON hold
every digit.

**Files** appear whole or not at all, and those of one run together: they are made in a hidden folder beside
their places and moved there at the end. A command that fails, over its input or on a full disk, leaves what
was there before. Each file of a folder of results carries the mark of its run; where files of different runs
stand side by side, whatever writes or reads them names them in a warning. No command writes over a file that
it reads.

**Errors** say what is wrong, where (file, line, column), what was expected, what was found, and what to do
next. In the exit code, 2 means that the command or its input is at fault, 1 that gd-analyze or the machine
failed; `--debug` adds Python's traceback. `validate --fail-over` leaves with 1 as well where a model fails:
then there is a result, and no error.

**Units.** Joint values on the command line are degrees (metres for joints that slide), torques are N m (N).

**Names.** A trajectory file called like a shipped trajectory is reached as `./NAME`, an arm file called like
a verb likewise.
"""

COLUMNS = """
## The tables of the main job

| column | meaning |
|---|---|
| `peak torque` | largest magnitude of the exact torque of the joint along the trajectory |
| `allowed` | the error the budget allows the joint |
| `largest`, `RMS` | largest and root mean square error of the model, and their `share` of peak torque |
| `tran`, `rot` | largest magnitude of the element's translational and rotational part |
| `torque`, `joint` | the element's largest torque and the joint it acts at |
| `share` | that torque's share of the joint's peak torque |
| `verdict` | `translation`, `rotation` or `both`: the effect that dominates; `gravity`; `negligible` |
| `kept` | what parts of the element [FGL87]'s own method keeps: `T`, `R`, `T+R`, `✓` or, for none, `0` |
| `text` | the verdict that [FGL87] reads from its figures, for the PUMA 560 |

An effect dominates an element when leaving the other one out changes it by at most 10 % of its peak. An
element is negligible when all its torques stay below budget / (n + 2), so that all negligible
elements may go at once. Where others cancel it, an element's share exceeds 100 %; it is ∞ where the joint
carries no torque at all.

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
