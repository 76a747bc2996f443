"""`gd-analyze completion`: the shell's completion script."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class


@click.command()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def completion(ctx: click.Context, shell: str) -> None:
    """Print the completion script of a shell.

    \b
    Example:
      eval "$(gd-analyze completion bash)"
    """
    kind = get_completion_class(shell)
    assert kind is not None  # click ships all three
    click.echo(kind(ctx.find_root().command, {}, "gd-analyze", "_GD_ANALYZE_COMPLETE").source())
