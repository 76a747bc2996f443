"""Results of ranking single terms, and of simplifying at every level and several budgets."""

from __future__ import annotations

from collections.abc import Sequence

from gd_analyze.formulas.languages import Plain
from gd_analyze.result import Fact, Result, Table, Value, attributes_of
from gd_analyze.results.model_facts import counts_by_kind, drives_text
from gd_analyze.results.run_tables import term_values
from gd_analyze.results.shown_tables import TERMS_IN_TERMINAL
from gd_analyze.schema import declared_columns, declared_table
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.term_ranking import TermRanking
from gd_analyze.simplification.trade_off import TradeOffPoint, curves

# Shares of peak torque for which the result states the number of terms.
_STATED_SHARES = (0.1, 0.01, 0.001)


def ranking_result(ranking: TermRanking, exact: ExactDynamics, level: str, top: int) -> Result:
    """Every term with its torque and the error without it; people see the first `top`."""
    terms, arm = ranking.terms, exact.arm
    needed = []
    for share in _STATED_SHARES:
        count = next((term.rank - 1 for term in terms if term.without_share <= share), len(terms))
        if count < len(terms) or ranking.unlisted_share <= share:
            label = f"Terms for {100 * share:g} % of peak torque"
            needed.append(Fact(f"needed_for_{share:g}", label, count, shown="count"))
    seen = {**attributes_of(terms, "rank"), **term_values(ranking)}
    values = {"term" if name == "text" else name: seen[name] for name in seen} | {
        "below_uncertainty": [ranked.below_uncertainty for ranked in terms],
        "alone_unit": [arm.joints[ranked.alone_joint - 1].effort_unit for ranked in terms],
    }
    shown = {ranked.term: ranked.weight for ranked in terms[:top]}
    legend = Plain().legend(LEVELS[level].legend(exact.form, shown))
    table = declared_table(
        "terms",
        "terms",
        "Torque of each term, and error without it and all below",
        values,
        TERMS_IN_TERMINAL,
        note=f"Where {', '.join(legend)}." if legend else "",
        top=top,
        seen=seen,
    )
    unlisted = f"at most {100 * ranking.unlisted_share:.2g} % of peak torque together"
    return Result(
        title=f"{arm.title or arm.name}: {len(terms)} {LEVELS[level].keeps}",
        subtitle=f"ranked over {exact.states.in_words}",
        facts=(
            Value("arm", arm.name),
            Value("level", level),
            Fact("drives", "Drives included", exact.form.drives).seen_if(arm.counts_drives()),
            Value("states", dict(exact.states.described)),
            *needed,
            Fact("unlisted", "Terms not ranked", ranking.unlisted, note=unlisted).seen_if(
                ranking.unlisted > 0
            ),
            Value("unlisted_share", ranking.unlisted_share),
            Value("torque_uncertainty", ranking.uncertainty),
            Fact(
                "not_worth_keeping",
                "Lowest-ranked terms within the torque's uncertainty",
                ranking.not_worth_keeping,
                shown="count",
                text="unknown: the arm states no uncertainty" if ranking.uncertainty is None else None,
            ),
        ),
        parts=(table,),
    )


def trade_off_result(points: Sequence[TradeOffPoint], exact: ExactDynamics, budget: Budget) -> Result:
    """Operations, and sines and cosines, by level and budget."""
    arm, full, by_level = exact.arm, exact.form.operations, curves(tuple(points))
    budgets = [point.budget for point in next(iter(by_level.values()), ())]
    seen = {"budget": budgets} | {
        f"operations_{level.name}": [
            f"{point.operations.total}/{point.operations.sines_cosines}" for point in row
        ]
        for level, row in by_level.items()
    }
    by_budget = Table(
        None,
        "Operations/sines and cosines of one torque evaluation, by budget",
        declared_columns("trade_off", seen, [*seen]),
        "Each budget is kept at these states alone, as with `simplify --at-set-points`; near a motion it "
        "takes more operations. If no model takes fewer, those of the exact torque are shown.",
    )
    stored = [
        {
            "level": point.level.name,
            "budget": point.budget,
            "operations": counts_by_kind(point.operations),
            "largest_share": point.error_share,
        }
        for point in points
    ]
    saves = any(point.operations.total < full.total for point in points)
    drives = drives_text(arm, exact.form.drives)
    return Result(
        title=f"{arm.title or arm.name}: operations against torque error",
        subtitle=", ".join(filter(None, [f"over {exact.states.in_words}", drives])),
        facts=(
            Value("arm", arm.name),
            Value("drives", exact.form.drives),
            Value("states", dict(exact.states.described)),
            Value("budget", str(budget)),
            Value("shares_of", budget.shares_of),
            Fact("operations_full", "Operations of the exact torque", counts_by_kind(full), text=str(full)),
            Value("saves", saves)
            if saves
            else Fact("saves", "Operations saved within these budgets", saves, text="none"),
        ),
        parts=(by_budget, Value("points", stored)),
    )
