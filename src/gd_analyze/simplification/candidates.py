"""What a simplification may drop: torque terms, their coefficients, and their torques at given states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.harmonics.basis import Basis
from gd_analyze.harmonics.lagrangian import Monomial, Rate, Torques, TorqueTerm, absolute_rates
from gd_analyze.simplification.states import States
from gd_analyze.vectors import FloatArray

# Of the budget, what the first sweep may spend on terms too small to weigh one by one.
SWEEP_SHARE = 0.02


@dataclass(frozen=True, eq=False)
class Candidates:
    """What may be dropped: torque terms that go together, their coefficients, and their torques.

    `effects` are the torques of unit coefficients over allowed error, shape (terms, n, N).
    """

    torques: tuple[Torques, ...]
    coefficients: FloatArray
    effects: FloatArray

    @property
    def cost(self) -> FloatArray:
        """Operations a term takes when nothing is shared."""
        return np.array(
            [sum(1 + len(term.rates) + len(term.monomial) for term in torques) for torques in self.torques],
            dtype=float,
        )


def candidates_at(
    basis: Basis, states: States, torques: list[Torques], coefficients: FloatArray, allowed: FloatArray
) -> Candidates:
    """Torques of every candidate at every state, in the joints' own coordinates."""
    values = _MonomialValues(basis, states)
    effects = np.zeros((len(torques), basis.n_joints, len(states.q)))
    for k, group in enumerate(torques):
        for term, weight in group.items():
            effects[k, term.row] += weight * values(term)
    for run in basis.runs:
        for inner, outer in reversed(list(zip(run.joints[:-1], run.joints[1:], strict=True))):
            effects[:, inner] += effects[:, outer]
    return Candidates(tuple(torques), coefficients, effects / allowed[:, None])


class _MonomialValues:
    """Values of monomials times rates at the states, each literal and each product formed once."""

    def __init__(self, basis: Basis, states: States) -> None:
        back = np.linalg.inv(absolute_rates(basis))
        self._q = states.q.T
        self._moving = {1: back @ states.qd.T, 2: back @ states.qdd.T}
        self._literals: dict[tuple[str, tuple[int, ...]], FloatArray] = {}
        self._known: dict[tuple[tuple[Rate, ...], Monomial], FloatArray] = {}

    def __call__(self, term: TorqueTerm) -> FloatArray:
        key = (term.rates, term.monomial)
        if key not in self._known:
            value = np.ones(self._q.shape[1])
            for rate in term.rates:
                value = value * self._moving[rate.order][rate.joint]
            for literal in term.monomial:
                value = value * self._literal(literal)
            self._known[key] = value
        return self._known[key]

    def _literal(self, literal: tuple[str, tuple[int, ...]]) -> FloatArray:
        if literal not in self._literals:
            kind, multiples = literal
            argument = np.array(multiples, dtype=float) @ self._q
            if kind != "power":
                argument = np.cos(argument) if kind == "cos" else np.sin(argument)
            self._literals[literal] = argument
        return self._literals[literal]


def swept(pool: Candidates) -> list[int]:
    """Candidates that matter: the others together stay below a small share of the budget."""
    largest = np.abs(pool.effects).max(axis=2) * np.abs(pool.coefficients)[:, None]
    order = np.argsort(largest.max(axis=1))
    together = np.cumsum(largest[order], axis=0).max(axis=1)
    return sorted(int(k) for k in order[together > SWEEP_SHARE])
