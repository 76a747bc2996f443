"""What a payload does to a model that knows nothing of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import ROUND_OFF_SHARE, FloatArray, chunks
from gd_analyze.dynamics.regressor import regressor
from gd_analyze.motions.states import States, states_for
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel


@dataclass(frozen=True, eq=False)
class PayloadEffect:
    """What a point mass in the hand, at the last link frame's origin, does to a model over some states.

    Parameters
    ----------
    torque_per_kg
        Largest torque that the mass needs at each joint, N m per kg (N per kg for a sliding joint), shape
        (n,).
    mass_within_budget
        Largest mass, kg, for which each joint's error stays within the model's budget, shape (n,): 0 where
        it is beyond the budget without any, infinite where no mass acts on the joint. Infinite everywhere,
        too, where the budget is of the norm and no joint has one of its own.
    """

    torque_per_kg: FloatArray
    mass_within_budget: FloatArray

    @property
    def largest_mass(self) -> float:
        """Largest mass, kg, for which every joint's error stays within the budget."""
        return float(self.mass_within_budget.min())

    @property
    def limiting_joint(self) -> int | None:
        """The joint, from 1, that leaves its budget first; None where no mass acts on any."""
        return int(self.mass_within_budget.argmin()) + 1 if np.isfinite(self.largest_mass) else None


def payload_effect(model: SimplifiedModel, states: States) -> PayloadEffect:
    """Find what a payload needs at every joint, and how much of it a model's budget allows.

    Torque is linear in a mass at a fixed point of the last link, so the error at a state is e - m g, with g
    the torque of one kilogram, and leaves the budget b at m = (b +- e) / abs(g).

    Parameters
    ----------
    model
        Made for the arm without the payload.
    states
        The states in question; the result says nothing of others.
    """
    states = states_for(model.arm, states)
    exact = ExactDynamics(model.form, states)
    error = model.torque(*states.arrays) - exact.torque
    # One column of the regressor, N m, shape (N, n).
    of_a_kilogram = np.empty(error.shape)
    for chunk in chunks(len(states)):
        of_a_kilogram[chunk] = regressor(model.arm, *states.at(chunk).last)[:, -1, 0].T
    # Cancelled terms leave round-off behind, where there is neither an error nor an effect.
    no_error = exact.round_off
    no_effect = ROUND_OFF_SHARE * max(of_a_kilogram.max(), -of_a_kilogram.min())
    accuracy = model.accuracy
    allowed = accuracy.allowed if accuracy.asked.norm is None else np.full(model.arm.n_joints, np.inf)
    torque, mass = np.zeros(model.arm.n_joints), np.full(model.arm.n_joints, np.inf)
    for chunk in chunks(len(states)):
        size, sign = np.abs(of_a_kilogram[chunk]), np.sign(of_a_kilogram[chunk])
        here = np.where(np.abs(error[chunk]) <= no_error, 0.0, error[chunk])
        acts = size > no_effect
        most = np.full(size.shape, np.inf)
        np.divide(allowed + sign * here, size, out=most, where=acts)
        most[np.abs(here) > allowed] = 0.0
        torque = np.maximum(torque, np.where(acts, size, 0.0).max(axis=0))
        mass = np.minimum(mass, most.min(axis=0))
    return PayloadEffect(torque, mass)
