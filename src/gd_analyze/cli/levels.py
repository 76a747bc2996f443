"""How to simplify: options that verbs share."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import click

from gd_analyze.cli.options import F, number_option, together
from gd_analyze.text import LEVEL_NAMES

# Of levels: as none is asked for.
CHEAPEST = "cheapest"


# What --budget is.
BUDGET = (
    "Allowed torque error: a share of each joint's peak torque (1%), torque limit (0.5% limit), "
    "Coulomb friction (10% friction) or parameter uncertainty (uncertainty), or N m (0.5); the larger of "
    'several joined by "or" (1% or 10% friction); one for all joints, or one per joint, comma-separated.'
)


def budget_option(words: str = BUDGET) -> Callable[[F], F]:
    """--budget."""
    return click.option("--budget", default="1%", show_default=True, metavar="LIST", help=words)


def level_option(names: Sequence[str] = tuple(LEVEL_NAMES), default: str = CHEAPEST) -> Callable[[F], F]:
    """--level; None for the cheapest."""
    words = [f"{name}: {LEVEL_NAMES[name]}" for name in names]
    if default == CHEAPEST:
        words.insert(0, f"{CHEAPEST}: of those promising for the arm, the one of fewest operations")
        names = (CHEAPEST, *names)
    return click.option(
        "--level",
        type=click.Choice(names),
        default=default,
        show_default=True,
        callback=lambda context, option, chosen: None if chosen == CHEAPEST else chosen,
        help=f"{'; '.join(words)}.",
    )


simplify_options = together(
    click.option(
        "--refit",
        is_flag=True,
        help="Refit what is kept, to absorb what is dropped; at level term or energy; "
        "level recursive always does.",
    ),
    number_option(
        "--operations",
        None,
        "Multiplications and additions the model may take: the budget is scaled until it does.",
    ),
)
