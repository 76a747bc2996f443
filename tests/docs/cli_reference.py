"""Writes the help in docs/cli.md anew, from the commands' own: `python tests/docs/cli_reference.py`."""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from collections.abc import Iterator
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


def shared_records() -> dict[tuple[str, str], int]:
    """Arguments and options, each with its help, that several verbs have; and how many of them."""
    counts = Counter(record for verb in app.commands for _, record in records(verb))
    return {record: count for record, count in counts.items() if count > 1}


def records(verb: str) -> Iterator[tuple[click.Parameter, tuple[str, str]]]:
    """Parameters of a verb, each with its line of help."""
    command = app.commands[verb]
    root = click.Context(app, info_name="gd-analyze", terminal_width=WIDTH, **app.context_settings)
    context = click.Context(command, info_name=verb, parent=root, terminal_width=WIDTH)
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        if record is not None:
            yield parameter, record


# Options that come together are named together.
TOGETHER = {"options of arms": ["--tip", "--base", "--lock", "--limits", "--gravity", "--drive-inertia"]}


def grouped(names: list[str]) -> list[str]:
    """Names of options, those that come together by one name."""
    for name, options in TOGETHER.items():
        if set(options) <= set(names):
            names[names.index(options[0])] = name
            names = [other for other in names if other not in options]
    return names


def help_of_its_own(verb: str = "") -> str:
    """Help of a verb, or of the main job, without what it shares with others, which is named last."""
    shared, text, names = shared_records(), help_of(*filter(None, [verb])), []
    for parameter, record in records(verb or "analyze"):
        if record in shared:
            text = text.replace(lines_of(record, text), "", 1)
            if shared[record] < len(app.commands) - 1:  # all but `completion`, which gives no result
                names.append(parameter.opts[-1] if record[0].startswith("-") else record[0])
    # The pages have commands, and the verbs follow.
    text = re.sub(r"\n  Examples:\n(?:    .*\n)+|\nVerbs \(.*\n(?:  .*\n)+", "", text)
    text = re.sub(r"\n[^\n:]*:\n(?=\n|$)", "", text).rstrip()  # no heading above nothing
    named = textwrap.fill(f"Shared: {', '.join(grouped(names))}.", WIDTH, break_on_hyphens=False)
    return f"{text}\n\n{named}\n" if names else f"{text}\n"


def lines_of(record: tuple[str, str], text: str) -> str:
    """Lines of a help that describe one option."""
    declaration = re.escape(record[0])
    match = re.search(rf"^  {declaration}(?:\n|  ).*\n(?:   .*\n)*", text, re.M)
    assert match, f"{record[0]} is not in the help"
    return match[0]


def page() -> str:
    """Text of docs/cli.md; what stands before the first help stays."""
    text = PAGE.read_text(encoding="utf-8")
    introduction = text.partition("\n## Options that many verbs share\n")[0]
    shared = shared_records()
    formatter = click.HelpFormatter(width=WIDTH)
    formatter.write_dl(sorted(shared, key=lambda record: (record[0].startswith("-"), -shared[record])))
    verbs = [name for name, command in app.commands.items() if not command.hidden]
    sections = [f"\n## gd-analyze {name}\n\n```text\n{help_of_its_own(name)}```\n" for name in verbs]
    options = f"\n## Options that many verbs share\n\n```text\n{formatter.getvalue()}```\n"
    main_job = f"\n## gd-analyze\n\n```text\n{help_of_its_own()}```\n"
    return "".join([introduction, options, main_job, *sections])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
