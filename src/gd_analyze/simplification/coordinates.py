"""In which velocities the terms of a model are: absolute ones, or the joints' own.

Of an arm with parallel axes, terms in absolute velocities are fewer, but some of them go together; those in
joint velocities are dropped one by one. A short search of both at few states decides.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.candidates import TooManyTermsError
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.search import SearchOptions, selected_terms

_STATES = 150  # states of the short search, beside extremes
_EFFORT = 0.3  # attempts of the short search, as a share of the usual


def in_cheaper_velocities(exact: ExactDynamics, allowed: FloatArray, options: SearchOptions) -> ExactDynamics:
    """The dynamics with terms in the velocities in which fewer operations are needed."""
    joint = exact.form.in_joint_velocities
    is_asked = options.level is TERM and not options.same_velocities
    if joint is exact.form or not is_asked:
        return exact
    sample = exact.thinned(_STATES)
    short = replace(options, effort=_EFFORT * options.effort)

    def operations(form: ExactForm) -> int:
        return selected_terms(sample.with_form(form), allowed, short).steps[-1].operations

    with suppress(TooManyTermsError):
        if operations(joint) < operations(exact.form):
            return exact.with_form(joint)
    return exact
