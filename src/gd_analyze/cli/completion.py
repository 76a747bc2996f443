"""`gd-analyze completion`: the shell's completion script."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class


@click.command(short_help="Print a shell's completion script.")
@click.argument(
    "shell", type=click.Choice(["bash", "zsh", "fish"]), metavar="SHELL", help="bash, zsh or fish."
)
@click.pass_context
def completion(ctx: click.Context, shell: str) -> None:
    r"""Print the completion script of a shell: verbs, options, arms and trajectories.

    \b
    Put one of these into ~/.bashrc, ~/.zshrc or ~/.config/fish/config.fish:
      eval "$(gd-analyze completion bash)"
      eval "$(gd-analyze completion zsh)"
      gd-analyze completion fish | source
    """
    kind = get_completion_class(shell)
    assert kind is not None  # click ships all three
    click.echo(kind(ctx.find_root().command, {}, "gd-analyze", "_GD_ANALYZE_COMPLETE").source())
