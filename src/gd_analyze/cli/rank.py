"""`gd-analyze rank`: every term of D, h and c by the torque that goes with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli.given import Given, given_dynamics
from gd_analyze.cli.levels import level_option
from gd_analyze.cli.options import number_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.terminal import line, sentence, table

if TYPE_CHECKING:
    from gd_analyze.simplification.ranking import TermRanking


@click.command(short_help="Rank every term of D, h and c by the torque it makes.")
@given_dynamics
@level_option(("term", "energy"), "term")
@number_option("--top", 20, "Terms to print; --json has all.")
@reporting
def rank(given: Given, level: str, top: int, output: Output) -> None:
    r"""Rank single terms by what they do to torque, alone and together with all that matter less.

    "Without" is the largest torque error of a model that lacks a term and all ranked below it: read down
    until it falls below what you can accept, and everything further down may go at once. Rates and rows are
    absolute ones, see docs/simplification.md.

    \b
    Examples:
      gd-analyze rank puma560 pick-and-place
      gd-analyze rank puma560 --no-drives --level energy --top 40
    """
    with output.working() as stage:
        stage("reading")
        exact = given.exact()
        stage("ranking")
        chosen = gd.LEVELS[level]
        ranking = gd.rank_terms(exact, chosen)
    rows = _rows(ranking, exact.arm)
    output.give(
        lambda: {
            "arm": exact.arm.name,
            "level": level,
            "drives": exact.form.drives,
            "states": dict(exact.states.described),
            "terms": rows,
            "torque_uncertainty": ranking.uncertainty,
            "not_worth_keeping": ranking.not_worth_keeping,
            "unlisted": ranking.unlisted,
            "unlisted_share": ranking.unlisted_share,
            "warnings": output.warnings,
        },
        lambda: _show(exact, ranking, f"{len(ranking.terms)} {chosen.keeps}", rows[:top]),
    )


def _rows(ranking: TermRanking, arm: gd.RobotArm) -> list[dict[str, Any]]:
    """One row per term, as JSON has it."""
    from dataclasses import asdict

    from gd_analyze.formulas.plain import Plain
    from gd_analyze.formulas.writing import term_formula

    plain, rows = Plain(), []
    for ranked in ranking.terms:
        formula = term_formula(ranked.term, ranked.weight)
        about = {"label": plain.symbol(formula.left), "quantity": ranked.term.quantity}
        unit = arm.joints[ranked.alone_joint - 1].effort_unit
        rows.append(about | asdict(ranked) | {"term": plain.right(formula), "alone_unit": unit})
    return rows


def _show(exact: gd.ExactDynamics, ranking: TermRanking, kept: str, shown: list[dict[str, Any]]) -> None:
    from gd_analyze.cli.joint_table import arm_in_words
    from gd_analyze.results.words import SYMBOLS, drives_told
    from gd_analyze.text import number, percent

    terms, arm = ranking.terms, arm_in_words(exact.arm, exact.form.drives)
    sentence(f"{arm}: {kept}, ranked over {exact.states.in_words}", bold=True)
    if shown:
        peak = "peak torque" + (f", {told}" if (told := drives_told(exact.arm, exact.form.drives)) else "")
        table(
            f"Largest torque of each term alone and its share of that joint's {peak}; largest error without "
            "it and all below",
            ["", "", "in", "term", "alone", "", "joint", "share", "without", "joint"],
            [
                [
                    str(row["rank"]),
                    SYMBOLS[row["quantity"]],
                    row["label"],
                    row["term"],
                    number(row["alone_torque"]),
                    row["alone_unit"],
                    str(row["alone_joint"]),
                    percent(row["alone_share"]),
                    percent(row["without_share"]),
                    str(row["without_joint"]),
                ]
                for row in shown
            ],
            "rlllrl",
        )
    line()
    if ranking.unlisted:
        sentence(
            f"The smallest {ranking.unlisted} terms are not ranked; together they make at most "
            f"{percent(ranking.unlisted_share)} of any joint's peak torque."
        )
    for share in (0.1, 0.01, 0.001):
        first = next((term.rank - 1 for term in terms if term.without_share <= share), len(terms))
        if first < len(terms) or ranking.unlisted_share <= share:
            sentence(f"The first {first} keep every joint within {100 * share:g} % of its peak torque.")
        else:
            sentence(f"More than the first {first} keep it within {100 * share:g} %.")
    if ranking.uncertainty is None:
        sentence("The arm states no uncertainty of its parameters.")
    else:
        sentence(
            f"The last {ranking.not_worth_keeping} together stay below the torque's uncertainty that follows "
            "from the parameters' stated ones: not worth keeping."
        )
