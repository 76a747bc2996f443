"""In which velocities the terms of a model are: absolute ones, or the joints' own.

Of an arm with parallel axes, terms in absolute velocities are fewer, but some of them go together; those in
joint velocities are dropped one by one. A short search at few states tells whether a search in joint
velocities may pay; the better of two models is the result.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.candidates import TooManyTermsError
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search import SearchOptions, selected_terms
from gd_analyze.simplification.torque_program import COUNTING

_STATES = 150  # states of the short search, beside extremes
_EFFORT = 0.3  # attempts of the short search, as a share of the usual
# Ratio of operations of D, h and c up to which two models count as equal, and those of the torque decide.
_EQUAL_OPERATIONS = 1.02


def in_worthwhile_velocities(
    exact: ExactDynamics, allowed: FloatArray, options: SearchOptions
) -> tuple[ExactDynamics, ...]:
    """The dynamics with terms in absolute velocities and, where it may pay, in joint velocities."""
    joint = exact.form.in_joint_velocities
    is_asked = options.level is TERM and not options.same_velocities
    if joint is exact.form or not is_asked:
        return (exact,)
    sample = exact.thinned(_STATES)
    short = replace(options, effort=_EFFORT * options.effort)

    def operations(form: ExactForm) -> int:
        terms = selected_terms(sample.with_form(form), allowed, short).terms
        return TERM.operations(form, terms, COUNTING)

    with suppress(TooManyTermsError):
        if operations(joint) < operations(exact.form):
            return exact, exact.with_form(joint)
    return (exact,)


def shortest(models: Sequence[SimplifiedModel]) -> SimplifiedModel:
    """The model with the fewest operations of D, h and c or, of nearly equal ones, of the torque.

    A model that drops nothing is exact, whose shortest program is known: the first stands for it.
    """
    dropping = [model for model in models if model.size[0] < model.size[1]] or models[:1]
    least = min(model.operations_minimized.total for model in dropping)
    equal = [model for model in dropping if model.operations_minimized.total <= _EQUAL_OPERATIONS * least]
    return min(equal, key=lambda model: model.operations.total)
