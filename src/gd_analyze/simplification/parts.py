"""The arm's torque as a sum of parts that can each be kept or dropped: the founding text's simplification.

The parts are D_ij^tran and D_ij^rot (i <= j), h_i^tran and h_i^rot, and c_i. Their arithmetic is traced once
from the formulation's own code; what a selection of parts needs is then known to the last multiplication.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics.elements import Element, elements
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True)
class Part:
    """One effect of one element; gravity loading has no split and counts as translation."""

    element: Element
    effect: str

    @property
    def label(self) -> str:
        """D12 translation, h3 rotation, c2."""
        if self.element.quantity == "gravity_loading":
            return self.element.label
        return f"{self.element.label} {self.effect}"

    def values(self, quantities: Mapping[Any, Any]) -> Array:
        """Its value at every state, shape (N,), of `quantities` as `Element.parts` takes them."""
        return self.element.parts(quantities)[EFFECTS.index(self.effect)]


def parts_of(n_joints: int) -> tuple[Part, ...]:
    """All parts of an arm of n joints, in the order of its elements."""
    return tuple(
        Part(element, effect)
        for element in elements(n_joints)
        for effect in (EFFECTS[:1] if element.quantity == "gravity_loading" else EFFECTS)
    )


def kept_effects(n_joints: int, kept: Collection[Part]) -> dict[str, str]:
    """What is kept of every element, by its label: one effect, "both" or "neither"."""
    names = {(): "neither", EFFECTS[:1]: EFFECTS[0], EFFECTS[1:]: EFFECTS[1], EFFECTS: "both"}
    chosen: dict[str, list[str]] = {element.label: [] for element in elements(n_joints)}
    for part in parts_of(n_joints):
        if part in kept:
            chosen[part.element.label].append(part.effect)
    return {label: names[tuple(effects)] for label, effects in chosen.items()}


def torque_by_part(quantities: Mapping[Any, Any], qdd: FloatArray, parts: tuple[Part, ...]) -> FloatArray:
    """Torque of every part at every joint and state, N m, shape (P, n, N).

    `quantities` is what `decompose` or `decompose_states` gave for states (N, n), `qdd` their accelerations.
    """
    count, n = qdd.shape
    out = np.zeros((len(parts), n, count))
    for p, part in enumerate(parts):
        values = part.values(quantities)
        for joint, factor in part.element.torque_factors(qdd).items():
            out[p, joint] = values * factor
    return out


@dataclass(frozen=True)
class TracedParts:
    """The arithmetic of every part.

    Parameters
    ----------
    trace
        Where the expressions live.
    qdd
        The accelerations' inputs, shape (n,).
    quantities
        Expressions of D, h and c by effect at the one state there is, as a decomposition has them.
    """

    trace: Trace
    qdd: Array
    quantities: Mapping[str, Array]

    def expression(self, part: Part) -> object:
        """Expression (or constant) of one part."""
        return part.values(self.quantities)[0]

    def torque(self, parts: Collection[Part], drive_inertia: Array | None) -> Array:
        """Expressions of the torques from some parts alone, shape (n,).

        Drive inertia, kg m^2, shape (n,), is added to the diagonal of D; None without drives.
        """
        n = len(self.qdd)
        inertia = np.full((n, n), 0.0, dtype=object)
        h = np.full(n, 0.0, dtype=object)
        c = np.full(n, 0.0, dtype=object)
        for part in parts_of(n):
            if part not in parts:
                continue
            i, j = part.element.i, part.element.j
            if part.element.quantity == "gravity_loading":
                c[i] = self.expression(part)
            elif j is None:
                h[i] = h[i] + self.expression(part)
            else:
                inertia[i, j] = inertia[i, j] + self.expression(part)
                inertia[j, i] = inertia[i, j]
        if drive_inertia is not None:
            for i in range(n):
                inertia[i, i] = inertia[i, i] + float(drive_inertia[i])
        return np.einsum("ij,j->i", inertia, self.qdd) + h + c


@lru_cache(maxsize=8)
def trace_parts(arm: RobotArm) -> TracedParts:
    """Run the formulation once on numbers that remember their arithmetic."""
    trace = Trace()
    q, qd, qdd = (trace.inputs(name, arm.n_joints) for name in ("q", "qd", "qdd"))
    kinematics = solve_kinematics(arm, q)
    moments = composite.composite_moments(arm, kinematics)
    quantities = {
        "inertia": composite.inertia(moments),
        "coriolis_centrifugal": composite.coriolis_centrifugal(moments, composite.brackets(moments), qd)[0],
        "gravity_loading": composite.gravity_loading(arm, moments),
    }
    states_first = {name: np.moveaxis(values, -1, 0) for name, values in quantities.items()}
    return TracedParts(trace, qdd[:, 0], states_first)
