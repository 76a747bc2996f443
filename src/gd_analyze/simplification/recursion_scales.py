"""By what a changed recursion has its quantities larger than they are.

Where a force is twice as large and every lever that it meets half as long, torque is the same: numbers that
were refitted do so where that makes one of them vanish. To be read, such factors are taken out again.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence, Set

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.formulas.printer import PRIME
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Program
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.kept_programs import inputs_of
from gd_analyze.simplification.recursion import Changes
from gd_analyze.simplification.recursion_names import Quantity
from gd_analyze.simplification.recursion_told import Told

# Moments act as torques, and rates come from outside: these only may be larger.
_FREE = ("f", "a", "A", "omegad", "omega")
# States looked at, and rates and accelerations there, per s and s^2, where the arm states no limits.
_STATES, _RATE, _ACCELERATION = 300, 1.0, 10.0
# A factor is one where what is there is so much like what was, and so far from being as large.
_ALIKE, _FAR = 0.9, math.log(1.15)
# Factors of neighbouring links that differ less are one.
_ONE = math.log(1.2)


def scales(form: ExactForm, changes: Changes) -> dict[Quantity, float]:
    """Factors of quantities, those that are not 1, as some states tell them, always the same."""
    states = _some_states(form.arm)
    exact, model = (Told(form.recursion, some) for some in ({}, changes))
    was, now = _values(exact, states), _values(model, states)
    sums: dict[tuple[str, int], FloatArray] = defaultdict(lambda: np.zeros(3))
    members: dict[tuple[str, int], list[Quantity]] = defaultdict(list)
    for quantity in was.keys() & now.keys():
        group = quantity.kind.rstrip(PRIME), quantity.link
        one, other = was[quantity], now[quantity]
        sums[group] += one @ one, one @ other, other @ other
        members[group].append(quantity)
    out: dict[Quantity, float] = {}
    for kind in _FREE:
        logarithms = [_logarithm(sums[kind, link]) for link in range(form.arm.n_joints)]
        for links, found in _runs(logarithms):
            own = [quantity for link in links for quantity in members[kind, link]]
            if found and _is_made_up_for(found, frozenset(own), exact, model):
                out |= dict.fromkeys(own, math.exp(found))
    return out


def _logarithm(sums: FloatArray) -> float:
    """Of a factor, from sums of squares and products; 0 where it is none."""
    squares, product, now = sums
    if product <= max(_ALIKE * math.sqrt(squares * now), 0.0):
        return 0.0
    found = math.log(product / squares)
    return found if abs(found) > _FAR else 0.0


def _runs(logarithms: Sequence[float]) -> list[tuple[list[int], float]]:
    """Neighbouring links whose factors differ little, and the mean."""
    runs: list[list[int]] = []
    for link, found in enumerate(logarithms):
        first = logarithms[runs[-1][0]] if runs else 0.0
        if first and found and abs(found - first) < _ONE:
            runs[-1].append(link)
        else:
            runs.append([link])
    return [(run, sum(logarithms[link] for link in run) / len(run)) for run in runs]


def _is_made_up_for(found: float, group: Set[Quantity], exact: Told, model: Told) -> bool:
    """Whether what quantities go into has them so much less; otherwise something of them is lost."""
    symbols = {quantity.symbol for quantity in group}
    apart = closer = 0.0
    for into in (exact.values.keys() & model.values.keys()) - group:
        weights = {term.powers: term.weight for term in model.sum(into)}
        for term in exact.sum(into):
            ratio = weights.get(term.powers, 0.0) / term.weight
            if ratio > 0.0 and any(base in symbols for base, _ in term.powers):
                apart += abs(math.log(ratio))
                closer += abs(math.log(ratio) + found)
    return closer < apart


def _some_states(arm: RobotArm) -> States:
    """States within the limits that an arm states, or such as arms have."""
    rate, acceleration = arm.limits("rate_limit"), arm.limits("acceleration_limit")
    ranges = (
        np.full(arm.n_joints, math.pi),
        np.where(np.isfinite(rate), rate, _RATE),
        np.where(np.isfinite(acceleration), acceleration, _ACCELERATION),
    )
    random = np.random.default_rng(0)
    q, qd, qdd = (random.uniform(-1.0, 1.0, (_STATES, arm.n_joints)) * most for most in ranges)
    return States(q, qd, qdd)


def _values(told: Told, states: States) -> dict[Quantity, FloatArray]:
    """Quantities that are computed, at states."""
    quantities = list(told.values)
    program = Program(told.program.steps, tuple(told.values[quantity][1] for quantity in quantities))
    rows = program.run(inputs_of(states))
    return {quantity: told.values[quantity][0] * row for quantity, row in zip(quantities, rows, strict=True)}
