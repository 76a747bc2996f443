"""How to simplify: options that the main job and `simplify` share."""

from __future__ import annotations

from collections.abc import Callable

import click

from gd_analyze.cli.options import F

_LEVEL = (
    "term: torque terms one by one, the fewest operations; energy: the model remains a mechanical system, "
    "with symmetric D and its own energy; element: parts of D and h as a whole, the text's method."
)


def level_option(default: str | None, help_default: str) -> Callable[[F], F]:
    """--level."""
    return click.option(
        "--level",
        type=click.Choice(["element", "term", "energy"]),
        default=default,
        help=f"{_LEVEL}  [default: {help_default}]",
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


def require_coefficients(level: str | None, refit: bool) -> None:
    """Refuse to refit what has no coefficients."""
    if refit and level == "element":
        raise click.UsageError("--refit goes with --level term or energy: parts have no coefficients")
