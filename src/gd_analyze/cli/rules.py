"""Which options of a verb go together, where Python has no arguments of which the library says the same."""

from __future__ import annotations

import click
from click.core import ParameterSource


def is_given(option: str) -> bool:
    """Whether the command names an option of its verb."""
    context = click.get_current_context()
    (parameter,) = (parameter for parameter in context.command.params if option in parameter.opts)
    return context.get_parameter_source(str(parameter.name)) is not ParameterSource.DEFAULT


def excludes(option: str, *others: str, as_it: str) -> None:
    """Refuse an option together with others; `as_it` says why, after the option's name."""
    if is_given(option) and (given := [other for other in others if is_given(other)]):
        raise click.UsageError(f"{option} {as_it}: omit {', '.join(given)}")


def needs(option: str, other: str) -> None:
    """Refuse an option without another."""
    if is_given(option) and not is_given(other):
        raise click.UsageError(f"{option} needs {other}")
