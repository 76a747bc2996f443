"""Entry point: `gd-analyze ROBOT TRAJECTORY` is the main job, every other verb a subcommand."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import click

from gd_analyze.cli.analyze import analyze
from gd_analyze.cli.arms import arms
from gd_analyze.cli.completion import completion
from gd_analyze.cli.evaluate import evaluate
from gd_analyze.cli.plan import plan
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.version import __version__

EPILOG = """\b
Examples:
  gd-analyze puma560 pick-and-place
  gd-analyze my_arm.toml my_move.csv --budget 0.5% --out results
  gd-analyze arms puma560
  gd-analyze evaluate results/model.json other.csv
"""


class MainJobGroup(click.Group):
    """A group whose own arguments are the main job's when the first word is no verb."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the main job's verb in front where the user left it out."""
        own = {name for param in self.get_params(ctx) for name in param.opts}
        if args and args[0] not in self.commands and args[0] not in own:
            args = [analyze.name or "", *args]
        return super().parse_args(ctx, args)

    def format_usage(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Show the main job's usage beside the verbs'."""
        formatter.write_usage(ctx.command_path, "ROBOT TRAJECTORY [OPTIONS]")
        formatter.write_usage(ctx.command_path, "VERB [ARGUMENTS] [OPTIONS]", prefix="       ")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Show the main job's arguments and options, then the verbs."""
        inner = click.Context(analyze, info_name=analyze.name, parent=ctx)
        records = [r for p in analyze.get_params(inner) if (r := p.get_help_record(inner)) is not None]
        records = [r for r in records if "--help" not in r[0]]
        with formatter.section("Options of the main job"):
            formatter.write_dl(records)
        super().format_options(ctx, formatter)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Keep the order in which a user meets the verbs."""
        return list(self.commands)


@click.group(cls=MainJobGroup, epilog=EPILOG, no_args_is_help=True, context_settings={"max_content_width": 100})
@click.version_option(__version__, prog_name="gd-analyze")
def app() -> None:
    """Split an arm's dynamics by effect, rank the parts, drop what the torque budget allows.

    ROBOT is a built-in arm (see `gd-analyze arms`) or the path of an arm's TOML file; TRAJECTORY is a CSV
    file, the name of a shipped trajectory, or - for standard input. Results go to
    reports/ROBOT-TRAJECTORY/ unless --out names another folder.
    """


for command in (analyze, arms, plan, evaluate, completion):
    app.add_command(command)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit code: 0 done, 2 the user's input is at fault."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in words
    try:
        app(words, prog_name="gd-analyze", standalone_mode=False)
    except GdAnalyzeError as error:
        if debug:
            raise
        click.echo(f"{click.style('error', fg='red', bold=True)}: {error}", err=True)
        sys.exit(2)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted; nothing half-written was left behind", err=True)
        sys.exit(130)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(0)
