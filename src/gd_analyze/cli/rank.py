"""`gd-analyze rank`: every term of D, h and c by the torque that goes with it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli.given import Given, given_dynamics
from gd_analyze.cli.levels import level_option
from gd_analyze.cli.options import number_option
from gd_analyze.cli.output import Output, reporting

if TYPE_CHECKING:
    from gd_analyze.result import Result
    from gd_analyze.simplification.ranking import TermRanking

# Shares of peak torque for which the result says how many terms they take.
_SHARES = (0.1, 0.01, 0.001)


@click.command(short_help="Rank every term of D, h and c by the torque it makes.")
@given_dynamics
@level_option(("term", "energy"), "term")
@number_option("--top", 20, "Terms to print; --json has all.")
@reporting
def rank(given: Given, level: str, top: int, output: Output) -> None:
    r"""Rank single terms by what they do to torque, alone and together with all that matter less.

    "Without" is the largest torque error of a model that lacks a term and all ranked below it: read down
    until it falls below what you can accept, and everything further down may go at once. Velocities and rows
    are absolute ones, see docs/simplification.md.

    \b
    Examples:
      gd-analyze rank puma560 pick-and-place
      gd-analyze rank puma560 --no-drives --level energy --top 40
    """
    with output.working() as stage:
        stage("reading")
        exact = given.exact()
        stage("ranking")
        ranking = gd.rank_terms(exact, gd.LEVELS[level])
    output.give(_result(exact, ranking, level, top))


def _result(exact: gd.ExactDynamics, ranking: TermRanking, level: str, top: int) -> Result:
    from gd_analyze.formulas.languages import Plain
    from gd_analyze.formulas.writing import term_formula
    from gd_analyze.result import Column, Fact, Result, Table

    terms, arm, plain = ranking.terms, exact.arm, Plain()
    formulas = [term_formula(ranked.term, ranked.weight) for ranked in terms]
    units = [arm.joints[ranked.alone_joint - 1].effort_unit for ranked in terms]
    counts = [
        next((term.rank - 1 for term in terms if term.without_share <= share), len(terms))
        for share in _SHARES
    ]
    facts = [
        Fact(f"needed_for_{share:g}", f"Terms for {100 * share:g} % of peak torque", count, shown="count")
        for share, count in zip(_SHARES, counts, strict=True)
        if count < len(terms) or ranking.unlisted_share <= share
    ]
    stated = ranking.uncertainty is not None
    unlisted = f"at most {100 * ranking.unlisted_share:.2g} % of peak torque together"
    table = Table(
        "terms",
        "Torque of each term, and error without it and all below",
        (
            Column("rank", "", [ranked.rank for ranked in terms], shown="count"),
            Column("label", "in", [plain.symbol(formula.left) for formula in formulas], shown="text"),
            Column("quantity", "", [ranked.term.quantity for ranked in terms]),
            Column("term", "term", list(map(plain.right, formulas)), shown="text"),
            Column("weight", "", [ranked.weight for ranked in terms]),
            Column("alone_torque", "alone", [ranked.alone_torque for ranked in terms], units),
            Column("alone_unit", "", units),
            Column("alone_joint", "joint", [ranked.alone_joint for ranked in terms], shown="count"),
            Column("alone_share", "of peak", [ranked.alone_share for ranked in terms], shown="percent"),
            Column("without_share", "without", [ranked.without_share for ranked in terms], shown="percent"),
            Column("without_joint", "joint", [ranked.without_joint for ranked in terms], shown="count"),
            Column("below_uncertainty", "", [ranked.below_uncertainty for ranked in terms]),
        ),
        top=top,
    )
    return Result(
        title=f"{arm.title or arm.name}: {len(terms)} {gd.LEVELS[level].keeps}",
        subtitle=f"ranked over {exact.states.in_words}",
        facts=(
            Fact("arm", "", arm.name),
            Fact("level", "", level),
            Fact("drives", "Drives included" if arm.counts_drives() else "", exact.form.drives),
            Fact("states", "", dict(exact.states.described)),
            *facts,
            Fact("unlisted", "Terms not ranked" * bool(ranking.unlisted), ranking.unlisted, note=unlisted),
            Fact("unlisted_share", "", ranking.unlisted_share),
            Fact("torque_uncertainty", "", ranking.uncertainty),
            Fact(
                "not_worth_keeping",
                "Last terms within the torque's uncertainty",
                ranking.not_worth_keeping,
                shown="count",
                text=None if stated else "unknown: the arm states no uncertainty",
            ),
        ),
        parts=(table,),
    )
