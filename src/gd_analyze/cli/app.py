"""The verbs: `gd-analyze ROBOT TRAJECTORY` is the main job, every other verb a subcommand."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path

import click
from click.shell_completion import CompletionItem, get_completion_class

from gd_analyze import __version__
from gd_analyze.cache import cache_folder
from gd_analyze.cli.arms import arms
from gd_analyze.cli.batch import batch
from gd_analyze.cli.compare import compare
from gd_analyze.cli.diagnose import diagnose
from gd_analyze.cli.equations import equations
from gd_analyze.cli.export import export
from gd_analyze.cli.figures import figures
from gd_analyze.cli.formulations import formulations
from gd_analyze.cli.identify import identify
from gd_analyze.cli.main_job import analyze, report
from gd_analyze.cli.motions import columns, plan
from gd_analyze.cli.options import ROBOT
from gd_analyze.cli.other_words import in_place_of_verb
from gd_analyze.cli.simplify import rank_terms, simplify, trade_off
from gd_analyze.cli.trials import certify, evaluate
from gd_analyze.errors import UsageError
from gd_analyze.files import shipped

EPILOG = """\b
Examples:
  gd-analyze puma560 pick-and-place
  gd-analyze puma560 pick-and-place large-slew
  gd-analyze my_arm.toml my_move.csv --budget 0.5% --out results
  gd-analyze arms puma560
  gd-analyze evaluate results/model.json other.csv

\b
Exit codes:
  0  done; warnings, if any, are on standard error
  1  gd-analyze or the machine failed; or a model failed `evaluate`
  2  the command or its input is at fault, and nothing was written
  130  interrupted

\b
Slow results are cached; --version shows the folder. GD_ANALYZE_CACHE sets
another folder, or turns the cache off.
"""

_FLAGS = {"--json", "--quiet", "--no-cache", "--debug"}


class MainJobGroup(click.Group):
    """A group whose own arguments are the main job's when the first word is no verb."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the main job's verb in front where the user left it out."""
        option_names = {name for param in self.get_params(ctx) for name in param.opts}
        flags = list(takewhile(_FLAGS.__contains__, args))
        words = args[len(flags) :]
        if words and words[0] in self.commands:
            args = [words[0], *flags, *words[1:]]
        elif args and args[0] not in option_names:
            if words and not ctx.resilient_parsing:
                self._refuse_other_word(words[0], words[1:])
            args = [analyze.name or "", *args]
        return super().parse_args(ctx, args)

    def _refuse_other_word(self, word: str, following: Sequence[str]) -> None:
        """Say what does the job where the word is no arm, but names a job or is like a verb."""
        import difflib

        arms_known = shipped("robots", ".toml")
        if word.startswith("-") or word in arms_known or Path(word).suffix or Path(word).exists():
            return
        verbs = [name for name, command in self.commands.items() if not command.hidden]
        matches = difflib.get_close_matches(word, [*arms_known, *verbs], n=1)
        said = in_place_of_verb(word, following)
        if said is None and matches and matches[0] in verbs:
            said = f"did you mean `gd-analyze {matches[0]}`?"
        if said is not None:
            raise UsageError(
                f"there is no verb {word!r}",
                expected=f"one of {', '.join(verbs)}, or an arm and a trajectory",
                found="neither a verb, nor a built-in arm, nor an existing file",
                next_step=said,
            )

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Offer what may come first: a verb, an arm, or an option of the main job."""
        if incomplete.startswith("-"):
            main_job = click.Context(analyze, parent=ctx, resilient_parsing=True)
            verb_items = super().shell_complete(ctx, incomplete)
            values = {item.value for item in verb_items}
            main_job_items = [
                item for item in analyze.shell_complete(main_job, incomplete) if item.value not in values
            ]
            return [*verb_items, *main_job_items]
        return [*ROBOT.shell_complete(ctx, None, incomplete), *super().shell_complete(ctx, incomplete)]

    def format_usage(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Show the main job's usage beside the verbs'."""
        formatter.write_usage(ctx.command_path, "ROBOT TRAJECTORY... [OPTIONS]")
        formatter.write_usage(ctx.command_path, "VERB [ARGUMENTS] [OPTIONS]", prefix="       ")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Show the main job's arguments and options, then the verbs."""
        inner = click.Context(analyze, info_name=analyze.name, parent=ctx)
        all_records = [parameter.get_help_record(inner) for parameter in analyze.get_params(inner)]
        records = [record for record in all_records if record is not None and "--help" not in record[0]]
        with formatter.section("The main job"):
            formatter.write_dl(records)
        super().format_options(ctx, formatter)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the verbs."""
        rows = [(name, c.get_short_help_str(60)) for name, c in self.commands.items() if not c.hidden]
        with formatter.section("Verbs (options: gd-analyze VERB --help)"):
            formatter.write_dl(rows)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Keep the order in which a user meets the verbs."""
        return list(self.commands)


def _show_version(context: click.Context, _: click.Parameter, is_given: bool) -> None:
    if is_given:
        click.echo(f"gd-analyze {__version__}\ncache {cache_folder() or 'off'}")
        context.exit()


@click.group(
    cls=MainJobGroup,
    epilog=EPILOG,
    no_args_is_help=True,
    context_settings={"max_content_width": 80, "help_option_names": ["-h", "--help"], "show_default": True},
)
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_show_version,
    help="Show the version and the cache folder, and exit.",
)
def app() -> None:
    """Split an arm's dynamics by effect, rank the parts, drop what the torque budget allows."""


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


VERBS = (
    analyze,
    report,
    arms,
    columns,
    diagnose,
    identify,
    plan,
    figures,
    simplify,
    rank_terms,
    trade_off,
    batch,
    evaluate,
    equations,
    compare,
    formulations,
    certify,
    export,
    completion,
)
for command in VERBS:
    # In a raw docstring click's mark of a preformatted paragraph is two characters.
    command.help = (command.help or "").replace("\\b\n", "\b\n")
    app.add_command(command)
