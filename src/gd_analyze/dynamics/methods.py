"""Table of the formulations of inverse dynamics: description, results and call of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gd_analyze.arguments import require_word
from gd_analyze.arrays import Array, FloatArray, chunks, set_points_last
from gd_analyze.dynamics import (
    composite_moments,
    generalized_dalembert,
    lagrange_euler,
    newton_euler_base,
    newton_euler_link,
    newton_euler_regrouped,
)
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True, eq=False)
class Dynamics:
    """D (n, n, N), h (n, N) and c (n, N) of one method."""

    inertia: Array
    coriolis_centrifugal: Array
    gravity_loading: Array


class TorqueOf(Protocol):
    """Torque (n, N) of an arm at q, qd, qdd (n, N)."""

    def __call__(self, arm: RobotArm, q: Array, qd: Array, qdd: Array, *, gravity: bool = True) -> Array:
        """Evaluate the torque."""


# D, h and c of an arm at q, qd (n, N).
DynamicsOf = Callable[[RobotArm, Array, Array], Dynamics]


@dataclass(frozen=True, eq=False)
class Method:
    """One formulation."""

    name: str
    title: str
    short: str  # short title for tables
    source: str  # derivation
    # Its representation of kinematics, and the `form` of its equations, as in [FGL87] Table 3.5
    kinematics: str
    form: str
    growth: str  # order of its operations in the number of joints
    torque: TorqueOf
    dynamics: DynamicsOf  # its D, h and c at q and qd; recursions are probed for theirs


def torque_of_states(
    method: Method, arm: RobotArm, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> FloatArray:
    """Torque by one method, N m (N), at any number of states, shape (N, n) like q, qd and qdd."""
    states = [set_points_last(np.asarray(x, dtype=float)) for x in (q, qd, qdd)]
    out = np.empty(states[0].shape)
    for chunk in chunks(len(q)):
        out[:, chunk] = method.torque(arm, *(x[:, chunk] for x in states))
    return out.T


def _lagrange_euler_dynamics(arm: RobotArm, q: Array, qd: Array) -> Dynamics:
    solved = lagrange_euler.solve(arm, q)
    return Dynamics(solved.inertia, solved.coriolis_centrifugal(qd), solved.gravity_loading)


def _dalembert_dynamics(arm: RobotArm, q: Array, qd: Array) -> Dynamics:
    kinematics = solve_kinematics(arm, q)
    return Dynamics(
        generalized_dalembert.inertia_by_link(arm, kinematics).sum(axis=(0, 1)),
        generalized_dalembert.coriolis_centrifugal_by_link(arm, kinematics, qd).sum(axis=(0, 1)),
        generalized_dalembert.gravity_loading_by_link(arm, kinematics).sum(axis=0),
    )


def _moments_dynamics(arm: RobotArm, q: Array, qd: Array) -> Dynamics:
    moments = composite_moments.composite_moments(arm, solve_kinematics(arm, q))
    pairs = composite_moments.brackets(moments)
    return Dynamics(
        composite_moments.inertia(moments).sum(axis=0),
        composite_moments.coriolis_centrifugal(moments, pairs, qd)[0].sum(axis=0),
        composite_moments.gravity_loading(arm, moments),
    )


def _closed_form(
    name: str, title: str, short: str, source: str, kinematics: str, growth: str, dynamics: DynamicsOf
) -> Method:
    """Make a method from D, h and c, from which torque is summed."""

    def torque(arm: RobotArm, q: Array, qd: Array, qdd: Array, *, gravity: bool = True) -> Array:
        terms = dynamics(arm, q, qd)
        sum_ = np.einsum("ijn,jn->in", terms.inertia, qdd) + terms.coriolis_centrifugal
        return sum_ + terms.gravity_loading if gravity else sum_

    return Method(name, title, short, source, kinematics, "closed form", growth, torque, dynamics)


def _recursion(name: str, title: str, short: str, source: str, kinematics: str, torque: TorqueOf) -> Method:
    """Make a method from torque only; D, h and c are probed at states where all other terms vanish.

    [FGL87] problem 3.11; Walker and Orin (1982).
    """

    def dynamics(arm: RobotArm, q: Array, qd: Array) -> Dynamics:
        still = np.zeros(q.shape)
        units = np.broadcast_to(np.eye(len(q))[:, :, None], (len(q), *q.shape))
        return Dynamics(
            np.stack([torque(arm, q, still, unit, gravity=False) for unit in units], axis=1),
            torque(arm, q, qd, still, gravity=False),
            torque(arm, q, still, still),
        )

    return Method(name, title, short, source, kinematics, "recursive", "n", torque, dynamics)


METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        _closed_form(
            "lagrange_euler", "Lagrange-Euler", "L-E", "[FGL87] section 3.2",
            "4x4 homogeneous matrices", "n^4", _lagrange_euler_dynamics,
        ),
        _recursion(
            "newton_euler_base", "Newton-Euler in the base frame", "N-E base", "[FGL87] Table 3.2",
            "rotation matrices, vectors in the base frame", newton_euler_base.torque,
        ),
        _recursion(
            "newton_euler_link", "Newton-Euler in link frames", "N-E link",
            "[FGL87] Table 3.3; Luh, Walker, Paul 1980",
            "rotation matrices, vectors in link frames", newton_euler_link.torque,
        ),
        _recursion(
            "newton_euler_regrouped", "Newton-Euler with regrouped parameters", "N-E regrouped",
            "Khalil, Kleinfinger 1987",
            "rotation matrices, vectors in axis frames", newton_euler_regrouped.torque,
        ),
        _closed_form(
            "generalized_dalembert", "Generalized d'Alembert as written", "G-D", "[FGL87] section 3.4",
            "rotation matrices, vectors in the base frame", "n^3", _dalembert_dynamics,
        ),
        _closed_form(
            "composite_moments", "Generalized d'Alembert by composite moments", "G-D composite",
            "docs/decisions/0001",
            "rotation matrices, vectors in the base frame", "n^2", _moments_dynamics,
        ),
    )
}  # fmt: skip


def known_method(name: str) -> Method:
    """Find a formulation by name."""
    require_word(name, METHODS, "method")
    return METHODS[name]
