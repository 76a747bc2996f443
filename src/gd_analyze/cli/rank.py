"""`gd-analyze rank`: every term of D, h and c by the torque that goes with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.options import ROBOT, ROBOT_HELP, reporting
from gd_analyze.cli.payload import load_arm_carrying, payload_option
from gd_analyze.cli.states import described, states_given, states_options, trajectory_argument

if TYPE_CHECKING:
    from gd_analyze.levels import ExactDynamics
    from gd_analyze.search.ranking import TermRanking

_SHORT = {
    "inertia": "D",
    "coriolis_centrifugal": "h",
    "gravity_loading": "c",
    "kinetic": "T",
    "potential": "U",
}


@click.command(short_help="Rank every term of D, h and c by the torque it makes.")
@click.argument("robot", type=ROBOT, help=ROBOT_HELP)
@trajectory_argument
@click.option(
    "--level",
    type=click.Choice(["term", "energy"]),
    default="term",
    show_default=True,
    help="term: terms of the torques; energy: terms of the kinetic and potential energy.",
)
@click.option("--drives", is_flag=True, help="Include drive inertia.")
@payload_option
@states_options
@click.option(
    "--top",
    type=click.IntRange(min=0),
    default=20,
    show_default=True,
    metavar="NUMBER",
    help="Terms to print; --json has all.",
)
@reporting
def rank(
    robot: str,
    trajectory: str | None,
    level: str,
    drives: bool,
    payload: str | None,
    states: int,
    seed: int,
    top: int,
    as_json: bool,
    quiet: bool,
    debug: bool,
) -> None:
    r"""Rank single terms by what they do to torque, alone and together with all that matter less.

    "Without" is the largest torque error of a model that lacks a term and all ranked below it: read down
    until it falls below what you can accept, and everything further down may go at once. Rates and rows are
    absolute ones, see docs/simplification.md.

    \b
    Examples:
      gd-analyze rank puma560 pick-and-place
      gd-analyze rank puma560 --drives --level energy --top 40
    """
    from gd_analyze.cli.terminal import print_json, stages, warnings_told

    with warnings_told(quiet) as told, stages(quiet) as stage:
        from gd_analyze.levels import ExactDynamics, level_named
        from gd_analyze.search.ranking import rank_terms

        stage("reading")
        arm = load_arm_carrying(robot, payload)
        exact = ExactDynamics.of(arm, states_given(arm, trajectory, states, seed), drives)
        stage("ranking")
        ranking = rank_terms(exact, level_named(level))
    if as_json:
        print_json(_document(exact, ranking, level, told))
    elif not quiet:
        _show(exact, ranking, level, top)


def _document(exact: ExactDynamics, ranking: TermRanking, level: str, told: list[str]) -> dict[str, Any]:
    from gd_analyze.tables import _term

    return {
        "arm": exact.arm.name,
        "level": level,
        "drives": exact.form.drives,
        "states": dict(exact.states.described),
        "terms": [_term(term) for term in ranking.terms],
        "torque_uncertainty": ranking.uncertainty,
        "not_worth_keeping": ranking.not_worth_keeping,
        "unlisted": ranking.unlisted,
        "unlisted_share": ranking.unlisted_share,
        "warnings": told,
    }


def _show(exact: ExactDynamics, ranking: TermRanking, level: str, top: int) -> None:
    from gd_analyze.cli.terminal import line, sentence, table
    from gd_analyze.formatting import number, percent
    from gd_analyze.tables import _term

    arm, terms = exact.arm, ranking.terms
    drives = ", with drives" if exact.form.drives else ""
    kind = "energy" if level == "energy" else "torque"
    sentence(
        f"{arm.title or arm.name}{drives}: {len(terms)} {kind} terms, ranked over "
        f"{described(exact.states.described)}",
        bold=True,
    )
    if top:
        shown = terms[:top]
        table(
            "Largest torque of each term alone and its share of that joint's peak torque; largest error "
            "without it and all below",
            [
                ("", "right"),
                *((name, "left") for name in ("", "in", "term")),
                *((name, "right") for name in ("alone", "joint", "share", "without", "joint")),
            ],
            [
                [
                    str(term.rank),
                    _SHORT[term.term.quantity],
                    str(_term(term)["label"]),
                    str(_term(term)["text"]),
                    number(term.alone_torque),
                    str(term.alone_joint),
                    percent(term.alone_share),
                    percent(term.without_share),
                    str(term.without_joint),
                ]
                for term in shown
            ],
        )
    line()
    if ranking.unlisted:
        sentence(
            f"The smallest {ranking.unlisted} terms are not ranked; together they make at most "
            f"{percent(ranking.unlisted_share)} of any joint's peak torque."
        )
    for share in (0.1, 0.01, 0.001):
        kept = next((term.rank - 1 for term in terms if term.without_share <= share), len(terms))
        sentence(f"The first {kept} keep every joint within {100 * share:g} % of its peak torque.")
    if ranking.uncertainty is None:
        sentence("The arm states no uncertainty of its parameters.")
    else:
        sentence(
            f"The last {ranking.not_worth_keeping} together stay below the torque's uncertainty that follows "
            "from the parameters' stated ones: not worth keeping."
        )
