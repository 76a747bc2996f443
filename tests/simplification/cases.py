"""Small sets of candidates that can be searched by trying all."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import strategies as st

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.candidates import Candidates
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.level import Costs
from gd_analyze.simplification.term import TERM
from strategies import two_link_of

_FORM = ExactForm(two_link_of(1.0, 1.0, 1.0))


def candidates_with(
    effects: FloatArray,
    costs: Costs,
    parameter: np.ndarray | None = None,
    magnitude: FloatArray | None = None,
) -> Candidates:
    """Candidates of any effects, whatever they stand for; by default each has a free number of its own."""
    count = len(effects)
    return Candidates(
        level=TERM,
        form=_FORM,
        terms=dict.fromkeys(range(count), 1.0),
        effects=effects,
        costs=costs,
        parameter=np.arange(count) if parameter is None else parameter,
        magnitude=np.ones(count) if magnitude is None else magnitude,
        ratio=np.ones(count),
        total=count,
    )


@st.composite
def candidate_sets(draw: st.DrawFn, most: int = 8) -> Candidates:
    """Effects some budgets large, costs shared by random groups."""
    count = draw(st.integers(1, most))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    joints, states = draw(st.integers(1, 3)), draw(st.integers(1, 12))
    effects = rng.normal(size=(count, joints, states)) * rng.choice([0.3, 1.0, 3.0], (count, 1, 1))
    costs = {frozenset([k]): int(rng.integers(1, 4)) for k in range(count)}
    for _ in range(draw(st.integers(0, 3))):
        members = frozenset(np.flatnonzero(rng.random(count) < 0.5).tolist())
        if len(members) > 1:
            costs[members] = int(rng.integers(1, 5))
    return candidates_with(effects, costs, rng.integers(0, count, count), rng.uniform(0.5, 2.0, count))


def cost_of(candidates: Candidates, kept: np.ndarray) -> int:
    return sum(
        operations for members, operations in candidates.costs.items() if any(kept[k] for k in members)
    )


def largest_error(candidates: Candidates, kept: np.ndarray, scale: np.ndarray | None = None) -> float:
    weights = (kept if scale is None else kept * scale) - 1.0
    return float(np.abs(weights @ candidates.flat).max(initial=0.0))


def cheapest(candidates: Candidates, budget: float) -> int:
    """Cost of the cheapest selection within a budget, by trying all."""
    return min(
        cost_of(candidates, np.array(kept))
        for kept in itertools.product([False, True], repeat=len(candidates.effects))
        if largest_error(candidates, np.array(kept)) <= budget
    )
