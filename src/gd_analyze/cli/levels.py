"""How to simplify: options that verbs share."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import click

from gd_analyze.cli.given import F

# As in `gd_analyze.levels.LEVELS`, which loads NumPy; a test compares.
LEVELS = {
    "element": "parts of D and h as a whole, the text's method",
    "term": "torque terms one by one, the fewest operations",
    "energy": "the model remains a mechanical system, with symmetric D and its own energy",
}

budget_option = click.option(
    "--budget",
    default="1%",
    show_default=True,
    metavar="LIST",
    help="Allowed torque error: a share of each joint's peak torque (1%) or N m (0.5); one for all joints, "
    "or one per joint, comma-separated.",
)


def level_option(
    default: str | None, help_default: str, names: Sequence[str] = ("term", "energy", "element")
) -> Callable[[F], F]:
    """--level."""
    told = "; ".join(f"{name}: {LEVELS[name]}" for name in names)
    return click.option(
        "--level", type=click.Choice(names), default=default, help=f"{told}.  [default: {help_default}]"
    )


def simplify_options(function: F) -> F:
    """--refit and --operations."""
    for option in (
        click.option(
            "--operations",
            type=click.IntRange(min=0),
            metavar="NUMBER",
            help="Multiplications and additions the model may take: the budget is scaled until it does.",
        ),
        click.option(
            "--refit",
            is_flag=True,
            help="Refit what is kept, to absorb what is dropped; at level term or energy.",
        ),
    ):
        function = option(function)
    return function
