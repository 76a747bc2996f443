"""Writes the help in docs/cli.md anew, from the commands' own: `python tests/docs/cli_reference.py`."""

from __future__ import annotations

import re
from pathlib import Path

import click

from gd_analyze.cli.app import app

PAGE = Path(__file__).parents[2] / "docs" / "cli.md"
WIDTH = 78  # what click makes of a terminal of 80 columns


def help_of(*verb: str) -> str:
    """What `gd-analyze [VERB] --help` prints at 80 columns."""
    context = click.Context(app, info_name="gd-analyze", terminal_width=WIDTH, **app.context_settings)
    command: click.Command = app
    for name in verb:
        command = app.commands[name]
        context = click.Context(command, info_name=name, parent=context, terminal_width=WIDTH)
    return command.get_help(context) + "\n"


def page() -> str:
    """Text of docs/cli.md; what stands before the first help and between it and the verbs stays."""
    text = PAGE.read_text(encoding="utf-8")
    introduction, tables = re.findall(
        r"\A.*?(?=\n## gd-analyze\n)|\n## The tables.*?(?=\n## gd-analyze )", text, re.S
    )
    verbs = [name for name, command in app.commands.items() if not command.hidden]
    sections = [f"\n## gd-analyze {name}\n\n```text\n{help_of(name)}```\n" for name in verbs]
    return "".join([introduction, f"\n## gd-analyze\n\n```text\n{help_of()}```\n", tables, *sections])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
