"""In which velocities the terms of a model are: absolute ones, or the joints' own.

Of an arm with parallel axes, terms in absolute velocities are fewer, but some of them go together; those in
joint velocities can be dropped one by one. A short search at few states tells which model will be shorter.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.candidates import TooManyTermsError
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.search import selected_terms
from gd_analyze.simplification.torque_program import COUNTING, ROUGH

_STATES = 150  # states of the short search, beside extremes
_EFFORT = 0.3  # attempts of the short search, as a share of the usual
# Most operations in joint velocities over those in absolute ones: differences below come from few states.
_CLEARLY_FEWER = 0.95


def in_shorter_velocities(exact: ExactDynamics, allowed: FloatArray, options: SearchOptions) -> ExactDynamics:
    """The same dynamics with terms in the velocities in which a model of level term takes fewer operations.

    They are absolute unless operations of D, h and c are clearly fewer in joint velocities.
    """
    joint = exact.with_form(exact.form.in_joint_velocities)
    if (
        joint is exact
        or options.level is not TERM
        or options.operations is not None
        or options.same_velocities
    ):
        return exact
    sample = exact.thinned(_STATES)
    short = replace(options, refit=False, writing=ROUGH, effort=_EFFORT * options.effort, selections=None)

    def operations(form: ExactForm) -> int:
        terms = selected_terms(sample.with_form(form), TERM, allowed, short).terms
        return TERM.operations(form, terms, COUNTING)

    with suppress(TooManyTermsError):
        if operations(joint.form) <= _CLEARLY_FEWER * operations(exact.form):
            return joint
    return exact
